//! What a sample costs on the board's core, in instructions: `cargo xtask bench instructions`.
//!
//! Instructions, not cycles: the emulator has no caches, no flash wait states and no pipeline.
//! Under `-icount shift=10` its clock advances by 1,024 ns an instruction, and SysTick counts that
//! clock: 25.6 ticks an instruction, so that a difference of two readings is exact. The image
//! checks this against a loop of known length first.
//!
//! Prints one line a figure; nothing is asserted here. There is no heap: nothing in the image could
//! give one.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod counting;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    on_target_tests::expansion::exit(counting::run())
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("counts instructions of the emulated core only: cargo xtask bench instructions");
}
