//! What commands that read logs have in common on their command line.

mod log;
mod units;

pub use log::{Log, paths};
pub use units::UnitArguments;
