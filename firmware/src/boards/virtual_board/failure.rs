//! What must not happen: says so and ends the emulator with a failure.

use core::panic::PanicInfo;

use semihosting::process::ExitCode;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    ExitCode::FAILURE.exit_process()
}

#[expect(unsafe_code, reason = "cortex-m-rt wants this handler declared unsafe; nothing in it is")]
mod hard_fault {
    use semihosting::process::ExitCode;

    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        defmt::error!("fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
        ExitCode::FAILURE.exit_process()
    }
}
