//! Runs a table of tests and reports as `cargo test` does.

use crate::{Failed, Outcome, say};

/// A named test.
pub struct Test {
    /// As reported.
    pub name: &'static str,
    /// What runs.
    pub function: fn() -> Outcome,
}

/// Runs every test of `image`, one line each and a summary; true when all passed.
#[must_use]
pub fn run(image: &str, tests: &[Test]) -> bool {
    say!("\nrunning {} tests\n", tests.len());
    let mut failed = 0;
    for test in tests {
        #[cfg(target_os = "none")]
        crate::target::restart_watchdog();
        say!("test {image}::{} ... ", test.name);
        match (test.function)() {
            Ok(()) => say!("ok\n"),
            Err(Failed) => failed += 1,
        }
    }
    let word = if failed == 0 { "ok" } else { "FAILED" };
    say!("\ntest result: {word}. {} passed; {failed} failed\n\n", tests.len() - failed);
    failed == 0
}
