//! Runs the tasks and sleeps with WFI in between.
//!
//! The executor for boards sleeps with WFE, which the emulator takes for no operation: the core
//! would spin at the host's expense.
#![expect(unsafe_code, reason = "the executor's contract: one context, polled by one caller")]

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

/// A task was woken since the last poll.
static IS_WOKEN: AtomicBool = AtomicBool::new(false);

#[unsafe(export_name = "__pender")]
fn pend(_context: *mut ()) {
    IS_WOKEN.store(true, Ordering::Release);
}

/// Starts the tasks that `spawn` names. To be called once.
pub fn run(spawn: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
    let executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    spawn(executor.spawner());
    loop {
        // SAFETY: initialised above, and polled from here only.
        unsafe { executor.poll() };
        // With interrupts masked, so that none comes between the look and the sleep; one that comes
        // ends it all the same.
        cortex_m::interrupt::free(|_| {
            if !IS_WOKEN.swap(false, Ordering::Acquire) {
                cortex_m::asm::wfi();
            }
        });
    }
}
