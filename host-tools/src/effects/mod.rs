//! Effects that a fitted model may lack.

mod candidate;
mod entries;
mod regressor;
pub mod written;

pub use candidate::{Candidate, NotTestable};
pub use entries::{ENTRIES, Entry, Sign, find};
pub use regressor::{Regressor, Switched};

/// Column with the pitch, nose up, rad.
pub const PITCH: &str = "pitch_rad";
/// Column with the processor's load, percent.
pub const PROCESSOR: &str = "cpu_percent";
