//! All that a fit needs to know of a run, in a few kilobytes: sums that add up over runs, whoever made them.
//!
//! What they hold and what they cannot tell: docs/fleet.md.

mod fitted;
mod local;
mod polynomial;
mod read;
mod run;
mod summary;

pub use self::fitted::{Fitted, LeftOut, eq18, leave_one_out, signed};
pub use self::local::{Local, Reference};
pub use self::read::{Conditioned, of_log};
pub use self::run::{FORMAT, RunGram, Setting, read_all, total, write_all};
pub use self::summary::{Histogram, Summary};
