//! The executor of what must be on time: in an interrupt of its own, above whatever answers hosts.
//!
//! | priority | who |
//! |---|---|
//! | 0 | the drivers' interrupts and board time's: short |
//! | 6 | this executor: sampling, and the inertial sensor |
//! | 7 | USB, whose interrupt moves what a host sends |
//! | thread | answering, storing, LEDs, the watchdog's food |

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};

static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Starts it. To be called once.
pub fn sampling() -> SendSpawner {
    interrupt::OTG_FS.set_priority(Priority::P7);
    // Of a peripheral that is not used here.
    interrupt::UART4.set_priority(Priority::P6);
    EXECUTOR.start(interrupt::UART4)
}

#[expect(unsafe_code, reason = "the handler that the executor's contract asks for")]
mod handler {
    use super::EXECUTOR;
    use embassy_stm32::interrupt;

    #[interrupt]
    unsafe fn UART4() {
        // SAFETY: polled from here only, and only after `sampling` has enabled this interrupt.
        unsafe { EXECUTOR.on_interrupt() }
    }
}
