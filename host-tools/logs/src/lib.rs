//! Logs of runs, and the robots that they are of.
//!
//! Its face: [`robot::Robot`], read from robot.toml; [`SampleReader`], a log as a stream of rows;
//! [`runs::Runs`], logs whole and filtered. [`Header`] and [`LogReader`] know files, lines and
//! columns; [`DriveReader`] wheels, power, payload, runs and gaps; [`SampleReader`] what an
//! estimator takes, without static power. Bags and tables become such rows in [`foreign`];
//! [`convert`] writes them as one; [`suspicion`] asks whether a log is what its columns say.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod arguments;
pub mod checks;
mod columnar;
mod conditioned;
mod conditioner;
#[cfg(feature = "every-format")]
pub mod convert;
mod drive;
mod exclusions;
pub mod foreign;
mod header;
mod line;
mod masses;
mod missing;
pub mod motions;
mod parsed;
mod pieces;
mod raw;
mod reader;
pub mod robot;
mod row;
mod run_numbers;
pub mod runs;
mod samples;
mod scan;
mod shared;
pub mod simulated;
mod source;
pub mod standing;
pub mod suspicion;
mod table;

pub use columnar::{Table, Values};
pub use conditioned::NO_GYRO;
pub use conditioner::{Conditioner, Now};
pub use drive::check_wheels;
pub use drive::{DriveReader, Gap, MIN_GAP_FACTOR, Record, wheel_columns};
pub use exclusions::Exclusions;
pub use header::Header;
pub use missing::missing;
pub use reader::{ColumnRequest, LogReader, Role};
pub use samples::{RawRow, RawSample, SampleReader};
pub use shared::Shared;
pub use table::TableReader;

/// Name of the time column, s.
pub const TIME: &str = "time_s";
/// Name of the power column, W.
pub const POWER: &str = "power_w";
/// What the names of a simulator's own columns begin with.
const SIM: &str = "sim_";
/// Name of the column of the power that a simulator says would have been measured, W.
pub const SIM_POWER: &str = "sim_power_w";
/// Name of the optional total mass column, kg.
pub const MASS: &str = "mass_kg";
/// Name of the optional column of the turn rate by a gyro, counter-clockwise, rad/s.
pub const YAW_RATE: &str = "yaw_rate_rad_s";
/// Name of the optional column of the pitch, nose up, rad.
pub const PITCH: &str = "pitch_rad";
/// Name of the optional column that tells runs apart; time may restart where it changes.
pub const RUN: &str = "run";

/// Name of the speed column of wheel `wheel`, counted from 0: `wheel1_rad_s` for wheel 0.
pub fn speed_column(wheel: usize) -> String {
    format!("wheel{}_rad_s", wheel + 1)
}

/// Name of the column of the torque (N·m) that a simulator's motor gives wheel `wheel`, counted
/// from 0: `sim_torque1_nm` for wheel 0.
pub fn sim_torque_column(wheel: usize) -> String {
    format!("sim_torque{}_nm", wheel + 1)
}

/// Name of the acceleration column of wheel `wheel`, counted from 0.
pub fn acceleration_column(wheel: usize) -> String {
    format!("wheel{}_rad_s2", wheel + 1)
}
