//! What commands that read logs have in common on their command line.

mod log;
mod speed;
mod units;

pub use log::{Log, paths};
pub use speed::times_real_time;
pub use units::UnitArguments;
