//! Many robots over many days: every log read once into its sums ([`fit::run_gram`]), what they say of each robot, and since when.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod abstain;
mod base;
#[cfg(feature = "bucket")]
mod bucket;
mod disagree;
mod drift;
mod keys;
mod logs;
mod outlier;
mod page;
mod rank;
mod source;
mod state;
#[cfg(test)]
mod tests;

pub use self::abstain::{Judged, judge};
pub use self::disagree::{Disagreement, Disagreements, disagreements};
pub use self::drift::{Change, Drift, changes};
pub use self::logs::{Log, Place};
pub use self::outlier::{Outlier, Outliers, outliers};
pub use self::page::{Found, save};
pub use self::rank::{Standing, rank};
pub use self::source::Source;
pub use self::state::{Outcome, State};
