//! What a log is worth before anything is fitted: sampling, sensors, excitation, static power.

mod blocks;
mod excitation;
mod findings;
mod plot;
mod scan;
mod segment;
mod sensors;
mod sketch;
mod static_power;
mod timing;
mod verdict;

use std::path::Path;

use serde::Serialize;

pub use blocks::{Block, Blocks};
pub use excitation::{Excitation, PayloadShare};
pub use findings::{Finding, Severity};
pub use sensors::{Outliers, Stuck};
pub use static_power::{Moving, StaticPower, StaticState};
pub use timing::Timing;
pub use verdict::{Use, Verdict};

use crate::error::Result;
use crate::log::Exclusions;
use crate::robot::Robot;

/// Everything `gmr inspect` says about a log, in the order it is printed as JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// What the log is good for, in one line.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// Path of the log.
    pub log: String,
    /// Name of the robot.
    pub robot: String,
    /// Rows used.
    pub rows: u64,
    /// Time from the first to the last row, s, over all runs.
    pub duration_s: f64,
    /// Median sample rate, Hz; none where no row continues the one before.
    pub rate_hz: Option<f64>,
    /// Steps of time and gaps.
    #[serde(flatten)]
    pub timing: Timing,
    /// What was left out.
    pub exclusions: Exclusions,
    /// Spikes of power and acceleration.
    pub outliers: Vec<Outliers>,
    /// Columns that stood still while others changed.
    pub stuck: Vec<Stuck>,
    /// What the drive shows of the robot; none without wheel columns.
    pub excitation: Option<Excitation>,
    /// Power at standstill, state by state, the lowest first.
    pub static_states: Vec<StaticState>,
    /// Levels of power that are taken for motion; only without wheel columns.
    pub moving_levels: Vec<StaticState>,
    /// How the standstill was found.
    pub standstill_from: &'static str,
    /// Columns that are neither time, wheels, power, payload nor run: candidate drivers of a gap.
    pub other_columns: Vec<String>,
    /// What to know and to do.
    pub findings: Vec<Finding>,
    /// For the figure.
    #[serde(skip)]
    pub series: plot::Series,
}

impl Report {
    /// Reads the log of a run of `robot`.
    ///
    /// # Errors
    /// As [`crate::log::LogReader`]; the log has other wheels than the robot.
    pub fn of(path: &Path, robot: &Robot, progress: impl FnMut(u64, Option<u64>)) -> Result<Self> {
        let scan = scan::scan(path, robot, progress)?;
        Ok(findings::report(path, robot, scan))
    }

    /// Writes the figure: histogram of static power with its Gaussians, and power over time with the states.
    ///
    /// # Errors
    /// As [`crate::report::Page::save`].
    pub fn save_figure(&self, file: &Path) -> Result<()> {
        plot::page(self).save(file)
    }
}
