//! What must not happen: says so, keeps why, cuts the motors' supply and starts again.
//!
//! The reset is a system reset. The independent watchdog's would leave the board in its bootloader
//! until somebody switches it off (docs/board.md, trap B).

use core::panic::PanicInfo;

use super::last_words::reset_because;
use crate::reset::ResetCause;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
    reset_because(ResetCause::Panic, 0)
}

#[expect(unsafe_code, reason = "cortex-m-rt wants these handlers declared unsafe; nothing in them is")]
mod handlers {
    use super::{ResetCause, reset_because};

    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        defmt::error!("fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
        reset_because(ResetCause::Fault, frame.pc())
    }

    /// One that nobody handles would come again as soon as it returned.
    #[cortex_m_rt::exception]
    unsafe fn DefaultHandler(number: i16) -> ! {
        reset_because(ResetCause::Interrupt, number as u32)
    }

    #[cortex_m_rt::exception]
    unsafe fn NonMaskableInt() -> ! {
        reset_because(ResetCause::NonMaskable, 0)
    }
}
