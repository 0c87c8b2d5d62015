//! What is in a log, and what its energy goes into, at a glance: the first command that anybody
//! runs, without a robot.toml.
//!
//! Everything is a sum over one pass; memory does not grow with the log.

mod advice;
mod bins;
mod page;
mod read;
mod report;
mod tally;
mod topics;

pub use self::report::Report;
pub use page::page;
