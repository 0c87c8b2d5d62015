//! What must not happen: says so and starts again.
//!
//! The reset is a system reset. The watchdog's would leave the board in its bootloader until somebody switches it off
//! (docs/board.md, trap B).

use core::panic::PanicInfo;

use cortex_m::peripheral::SCB;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    SCB::sys_reset()
}

#[expect(unsafe_code, reason = "cortex-m-rt wants this handler declared unsafe; nothing in it is")]
mod hard_fault {
    use cortex_m::peripheral::SCB;

    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        defmt::error!("fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
        SCB::sys_reset()
    }
}
