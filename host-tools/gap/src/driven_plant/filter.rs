//! Measured and simulated power after the same filter.

use logs::robot::chassis::Chassis;
use logs::runs::{RawRun, Runs};
use support::error::Result;

/// Measured runs whose power can be replaced by another.
#[derive(Debug)]
pub struct PowerFilter<'a> {
    robot: &'a Chassis,
    raw: &'a [RawRun],
    /// As measured.
    pub measured: Runs,
}

impl<'a> PowerFilter<'a> {
    /// Conditions runs.
    ///
    /// # Errors
    /// As [`Runs::condition`].
    pub fn new(robot: &'a Chassis, raw: &'a [RawRun]) -> Result<Self> {
        Ok(Self { robot, raw, measured: Runs::condition(robot, raw.to_vec())? })
    }

    /// Another power, W, after the filter: a value a row of [`measured`](Self::measured). `power`:
    /// a vector a run, a value a row of the log.
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
