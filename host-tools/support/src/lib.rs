//! What every crate of `gmr` stands on.
//!
//! Its face: [`error::Error`], [`input::Input`], [`output::write_whole`] and the checks before it ([`own`]),
//! [`progress`], [`metrics`].

/// As std's, but without a panic where standard output is closed: [`output::finish`] says so.
macro_rules! println {
    ($($text:tt)*) => { $crate::output::print(format_args!("{}\n", format_args!($($text)*))) };
}

/// As std's, but without a panic where standard error is closed.
macro_rules! eprintln {
    ($($text:tt)*) => { $crate::output::say(format_args!($($text)*)) };
}

/// A line of [`notice`](mod@notice).
#[macro_export]
macro_rules! notice {
    ($($text:tt)*) => { $crate::notice::add(format_args!($($text)*)) };
}

pub mod error;
pub mod figure;
pub mod input;
pub mod interrupt;
pub mod job;
pub mod metrics;
pub mod notice;
pub mod output;
pub mod own;
pub mod printable;
pub mod progress;
pub mod temporary;
