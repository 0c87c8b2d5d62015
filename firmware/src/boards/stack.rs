//! How deep the stack has been. `cortex-m-rt` paints it before anything runs.

use core::ptr::{addr_of, read_volatile};

use cortex_m_rt::STACK_PAINT_VALUE;
use embassy_time::{Duration, Timer};

/// Looking takes some 0.2 ms: longer than an answer, shorter than half a sample's period.
const PERIOD: Duration = Duration::from_secs(60);

#[expect(unsafe_code, reason = "the linker's symbols, and memory that has no object in it yet")]
mod memory {
    use super::{STACK_PAINT_VALUE, addr_of, read_volatile};

    unsafe extern "C" {
        /// Ends of the stack, which grows down from the first (memory.x).
        static _stack_start: u32;
        static _stack_end: u32;
    }

    /// Bytes between the stack's beginning and the lowest word that does not look painted any more.
    pub(super) fn deepest() -> usize {
        // SAFETY: only their addresses are used. Between them is the stack's memory: readable
        // words, all of them.
        unsafe {
            let (mut lowest, start) = (addr_of!(_stack_end), addr_of!(_stack_start));
            while lowest < start && read_volatile(lowest) == STACK_PAINT_VALUE {
                lowest = lowest.add(1);
            }
            start as usize - lowest as usize
        }
    }
}

/// Logs when the stack was deeper than ever before.
pub async fn watch_stack() -> ! {
    let mut deepest = 0;
    loop {
        let now = memory::deepest();
        if now > deepest {
            deepest = now;
            defmt::info!("stack: {=usize} bytes deep", deepest);
        }
        Timer::after(PERIOD).await;
    }
}
