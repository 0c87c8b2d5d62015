//! What a log is worth before anything is fitted: sampling, sensors, excitation, static power.

mod blocks;
mod doubts;
mod excitation;
mod finding;
mod findings;
mod plot;
mod report;
mod scan;
mod segment;
mod sensors;
mod sketch;
mod static_power;
mod timing;
mod verdict;

use std::path::Path;

pub use self::report::Report;
pub use blocks::{Block, Blocks};
pub use doubts::{check, first_problem};
pub use excitation::{Excitation, PayloadShare};
pub use finding::{Finding, Severity};
use logs::robot::Robot;
pub use sensors::Outliers;
pub use static_power::{Moving, StaticPower, StaticState};
use support::context::Context;
use support::error::Result;
pub use timing::Timing;
pub use verdict::{Use, Verdict};

impl Report {
    /// Reads the log of a run of `robot`.
    ///
    /// # Errors
    /// As [`logs::LogReader`]; the log has other wheels than the robot.
    pub fn of(
        context: &Context,
        path: &Path,
        robot: &Robot,
        progress: &mut dyn FnMut(u64, Option<u64>),
    ) -> Result<Self> {
        let scan = scan::scan(context, path, robot, progress)?;
        Ok(findings::report(path, robot, scan))
    }

    /// Writes the figure: histogram of static power with its Gaussians, and power over time with
    /// the states.
    ///
    /// # Errors
    /// As [`Page::save`](::report::Page::save).
    pub fn save_figure(&self, file: &Path) -> Result<()> {
        plot::page(self).save(file)
    }
}
