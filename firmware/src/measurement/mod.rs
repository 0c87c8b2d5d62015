//! One sample: both buses read at once, the estimator run, and everything kept that the link shows.

mod sampler;
mod snapshot;

pub use sampler::Sampler;
pub use snapshot::{DriveSnapshot, EstimateSnapshot, RailSnapshot, Snapshot, WheelSnapshot};
