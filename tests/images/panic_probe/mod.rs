//! A panic handler that cannot be linked: an image with it exists only if the optimiser has removed
//! every panic.

#[expect(unsafe_code, reason = "the name of something that does not exist; it is never called")]
unsafe extern "C" {
    /// Defined nowhere.
    safe fn this_image_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    this_image_can_panic()
}
