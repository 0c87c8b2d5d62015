//! A test harness for images without std: a table of named tests, each reported on its own line,
//! all run even when one fails, exit code 0 only when all passed.
//!
//! The same images run on the host, where `cargo test` runs them too: a difference between the two
//! is a difference of the arithmetic, not of the test.
#![cfg_attr(target_os = "none", no_std)]

mod failure;
mod now;
mod run;
mod say;
#[cfg(target_os = "none")]
mod target;

pub use failure::{Failed, Outcome, close, ensure, within};
pub use now::now;
pub use run::{Test, run};

/// What [`tests!`] expands to needs these names.
#[doc(hidden)]
pub mod expansion {
    #[cfg(target_os = "none")]
    pub use crate::target::{exit, rounds};
    #[cfg(target_os = "none")]
    pub use cortex_m_rt;
}

/// The entry point of a test image, from the names of its test functions, each a `fn() -> Outcome`.
#[macro_export]
macro_rules! tests {
    ($($test:ident),+ $(,)?) => {
        const TESTS: &[$crate::Test] = &[$($crate::Test { name: stringify!($test), function: $test }),+];

        #[cfg(target_os = "none")]
        use $crate::expansion::cortex_m_rt;

        #[cfg(target_os = "none")]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            $crate::expansion::exit($crate::run(env!("CARGO_CRATE_NAME"), TESTS))
        }

        #[cfg(not(target_os = "none"))]
        fn main() -> std::process::ExitCode {
            if $crate::run(env!("CARGO_CRATE_NAME"), TESTS) {
                std::process::ExitCode::SUCCESS
            } else {
                std::process::ExitCode::FAILURE
            }
        }
    };
}
