//! Measured and simulated power behind the same filter.

use logs::robot::chassis::Chassis;
use logs::runs::{RawRun, Runs};
use support::error::Result;

/// Runs as measured, with all that is needed to put another power in place of the measured one.
#[derive(Debug)]
pub struct Behind<'a> {
    robot: &'a Chassis,
    raw: &'a [RawRun],
    /// As measured.
    pub measured: Runs,
}

impl<'a> Behind<'a> {
    /// Conditions runs.
    ///
    /// # Errors
    /// As [`Runs::condition`].
    pub fn new(robot: &'a Chassis, raw: &'a [RawRun]) -> Result<Self> {
        Ok(Self { robot, raw, measured: Runs::condition(robot, raw.to_vec())? })
    }

    /// Another power, W, one vector a run and a value a row of the log, as the filter passes it: a
    /// value a row of [`measured`](Self::measured).
    ///
    /// # Errors
    /// As [`Runs::condition`].
    pub fn filtered(&self, power: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let mut raw = self.raw.to_vec();
        for (run, power) in raw.iter_mut().zip(power) {
            for ((_, sample, ..), power) in run.rows.iter_mut().zip(power) {
                sample.power = *power;
            }
        }
        let runs = Runs::condition(self.robot, raw)?;
        Ok(runs.runs.iter().map(|run| run.rows.iter().map(|row| row.power).collect()).collect())
    }

    /// Measured less that power, all runs in a row, W.
    ///
    /// # Errors
    /// As [`Runs::condition`].
    pub fn residual(&self, power: &[Vec<f64>]) -> Result<Vec<f64>> {
        let rows = self.measured.runs.iter().flat_map(|run| &run.rows).map(|row| row.power);
        Ok(rows.zip(self.filtered(power)?.into_iter().flatten()).map(|(m, s)| m - s).collect())
    }
}
