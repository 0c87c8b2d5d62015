//! All that a fit needs to know of a run, in a few kilobytes: sums that add up over runs, whoever
//! made them.
//!
//! What they hold and what they cannot tell: docs/fleet.md.

mod columns;
mod files;
mod fitted;
mod how;
mod local;
mod parquet;
mod polynomial;
mod read;
mod run;
mod step;
mod summary;
mod summing;
#[cfg(test)]
mod tests;

pub use self::columns::{Flat, Merge, Number, TEXTS, names};
pub use self::files::{read_all, write_all};
pub use self::fitted::{Fitted, LeftOut, eq18, leave_one_out, signed};
pub use self::how::How;
pub use self::local::{Local, PARAMETERS, Reference};
pub use self::read::{Spent, Summed};
pub use self::run::{FORMAT, RunGram, Setting, total};
pub use self::step::{Moved, Step, Told, step};
pub use self::summary::{Histogram, Summary};
pub use self::summing::{Answer, Request, gram};
