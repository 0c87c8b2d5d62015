//! SysTick as a counter of instructions.

use core::hint::black_box;

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// An instruction takes 2^SHIFT ns of the emulator's time: `-icount shift=10`, the largest there
/// is.
pub(crate) const SHIFT: u32 = 10;
/// The core clock of mps2-an500 has 25 MHz.
pub(crate) const TICK_NS: u32 = 40;
pub(crate) const WRAP: u32 = 1 << 24;

/// Counts what a closure executes.
pub(crate) struct Counter {
    pub(crate) syst: SYST,
    /// Instructions between two readings with nothing in between.
    own: u32,
}

impl Counter {
    /// `None` unless the counter says of a loop what it consists of.
    pub(crate) fn calibrated() -> Option<Self> {
        let mut core = cortex_m::Peripherals::take()?;
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(WRAP - 1);
        core.SYST.clear_current();
        core.SYST.enable_counter();
        let counter = Self { syst: core.SYST, own: empty() };
        // `delay(n)` is a loop of two instructions, run n + 1 times.
        let (short, long) = (counter.count_loop(100), counter.count_loop(1000));
        (long - short == 2 * (1000 - 100)).then_some(counter)
    }

    #[inline(never)]
    fn count_loop(&self, turns: u32) -> u16 {
        self.count(|| cortex_m::asm::delay(turns)).0
    }

    /// The instructions of `work`, its result written to memory included.
    #[inline(always)]
    pub(crate) fn count<R>(&self, work: impl FnOnce() -> R) -> (u16, R) {
        let before = SYST::get_current();
        let result = work();
        black_box(&result);
        let after = SYST::get_current();
        let instructions = between(before, after).saturating_sub(self.own);
        (u16::try_from(instructions).unwrap_or(u16::MAX), result)
    }
}

/// Two readings, one after the other.
fn empty() -> u32 {
    let before = SYST::get_current();
    between(before, SYST::get_current())
}

/// SysTick counts down.
fn between(before: u32, after: u32) -> u32 {
    let ticks = before.wrapping_sub(after) % WRAP;
    (ticks * TICK_NS + (1 << (SHIFT - 1))) >> SHIFT
}
