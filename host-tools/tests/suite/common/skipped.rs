//! Tests that cannot run here are counted as skipped, not as passed.

use std::io::Write as _;

/// Says that this test is skipped, and why: on standard output itself, which the test harness does
/// not keep to itself. `cargo xtask test` counts these lines and takes their tests from those that
/// passed. Once a test, which must end with it.
pub(crate) fn skipped(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let _ = writeln!(std::io::stdout(), "\nSKIPPED: {}::{test}: {why}", env!("CARGO_CRATE_NAME"));
}
