//! Many robots over many days: every log read once into its sums ([`fit::run_gram`]), what they say
//! of each robot, and since when.
//!
//! Its face: [`fleet`].
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod abstain;
mod base;
#[cfg(feature = "bucket")]
mod bucket;
mod disagree;
mod drift;
mod finding;
mod keys;
mod logs;
mod metrics;
mod models;
mod outlier;
mod page;
mod rank;
mod source;
mod state;
#[cfg(test)]
mod tests;
mod workflow;

pub use self::models::Exported;
pub use self::workflow::{Answer, Report, Request, Seconds, fleet};
