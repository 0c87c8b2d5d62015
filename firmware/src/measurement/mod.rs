//! One sample: both buses read at once, the estimator run, and everything kept that the link shows.

mod battery;
mod sampler;
mod snapshot;

pub use battery::BatteryMeter;
pub use sampler::Sampler;
pub use snapshot::{BatterySnapshot, DriveSnapshot, EstimateSnapshot, RailSnapshot, Snapshot, WheelSnapshot};
