//! The emulated board: output and exit code through semihosting, and an end for every way a test
//! can go astray.

use core::fmt::Arguments;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;

/// No test may take longer. All of them take well under a second.
const LIMIT_S: u32 = 10;
/// The core clock of mps2-an500.
const CLOCK_HZ: u32 = 25_000_000;
const TICKS_PER_SECOND: u32 = 2;

/// Ticks since the current test began.
static TICKS: AtomicU32 = AtomicU32::new(0);

pub(crate) fn print(arguments: Arguments<'_>) {
    semihosting::print!("{arguments}");
}

/// Ends the emulator, whose exit code becomes 0 or 1.
pub fn exit(passed: bool) -> ! {
    semihosting::process::exit(if passed { 0 } else { 1 })
}

/// Gives the next test [`LIMIT_S`] seconds from now.
pub(crate) fn restart_watchdog() {
    TICKS.store(0, Ordering::Relaxed);
    // Only the first call gets the peripherals; the timer then runs for good.
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(CLOCK_HZ / TICKS_PER_SECOND - 1);
        core.SYST.clear_current();
        core.SYST.enable_interrupt();
        core.SYST.enable_counter();
    }
}

/// How often SysTick has come round, for who counts by it.
pub fn rounds() -> u32 {
    TICKS.load(Ordering::Relaxed)
}

#[exception]
fn SysTick() {
    if TICKS.fetch_add(1, Ordering::Relaxed) + 1 >= LIMIT_S * TICKS_PER_SECOND {
        give_up(format_args!("no end after {LIMIT_S} s"));
    }
}

#[expect(unsafe_code, reason = "cortex-m-rt wants this handler declared unsafe; nothing in it is")]
mod hard_fault {
    #[cortex_m_rt::exception]
    unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
        super::give_up(format_args!("HardFault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr()))
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    give_up(format_args!("{info}"))
}

/// A test that neither passes nor fails ends the image: what it left behind is not known.
fn give_up(why: Arguments<'_>) -> ! {
    print(format_args!("FAILED\n    {why}\n\ntest result: FAILED. The tests after this one did not run\n\n"));
    exit(false)
}
