//! What every crate of `gmr` stands on.
//!
//! Its face: [`error::Error`], [`context::Context`], [`input::Input`], [`output::write_whole`] and
//! the checks before it ([`overwrite`]),
//! [`progress`], [`metrics`]; [`program::run`] is a program's `main`.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod context;
pub mod error;
pub mod figure;
pub mod input;
pub mod interrupt;
pub mod job;
pub mod metrics;
pub mod output;
pub mod overwrite;
pub mod printable;
pub mod program;
pub mod progress;
pub mod temporary;
