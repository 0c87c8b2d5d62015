//! What is known of a log after it was looked through.

use logs::Exclusions;
use logs::standing::Stuck;
use serde::Serialize;

use super::blocks::Block;
use super::excitation::Excitation;
use super::finding::Finding;
use super::sensors::Outliers;
use super::static_power::StaticState;
use super::timing::Timing;
use super::verdict::Verdict;

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
    pub(super) blocks: Vec<Block>,
}
