//! How logs are summed up.

use std::path::{Path, PathBuf};
use std::time::Instant;

use logs::Header;
use logs::robot::Robot;
use support::context::Context;
use support::error::Result;

use super::local::Reference;
use super::read::{Conditioned, Summed, of_header};

/// How logs are read and summed.
pub struct How {
    /// Coefficients with their checksum, that the sums of the signed model are taken near.
    pub reference: Option<(Reference, String)>,
    /// Of the filter.
    pub filter_cutoff_hz: f64,
    conditioned: Conditioned,
}

impl How {
    /// As the coefficients of this file were fitted, and near them.
    ///
    /// # Errors
    /// They cannot be read, are of another robot or of another model than the signed one, or hold
    /// effects.
    pub fn near(robot: &Robot, file: &Path, mass_kg: f64) -> Result<Self> {
        Ok(Conditioned::near(robot, file, mass_kg)?.into())
    }

    /// With this cutoff of the filter, and nothing else.
    ///
    /// # Errors
    /// A robot with a dimension that none can have.
    pub fn at(robot: &Robot, cutoff_hz: f64, mass_kg: f64) -> Result<Self> {
        let core = robot.chassis(cutoff_hz)?;
        Ok(Conditioned { core, drive: robot.drive(), reference: None, mass_kg }.into())
    }

    /// With the cutoff that a fit of these logs would choose.
    ///
    /// # Errors
    /// As [`at`](Self::at); a log that cannot be read.
    pub fn chosen(context: &Context, robot: &Robot, logs: &[PathBuf], mass_kg: f64) -> Result<Self> {
        Self::at(robot, crate::choose_cutoff(context, robot, logs, mass_kg)?, mass_kg)
    }

    /// The sums of a log's runs.
    ///
    /// # Errors
    /// A log that cannot be read, is not one of this robot or is too slow for the filter.
    pub fn of_log(&self, context: &Context, robot: &Robot, file: &Path) -> Result<Summed> {
        let started = Instant::now();
        let header = Header::open(context, file)?;
        let opening_s = started.elapsed().as_secs_f64();
        let mut summed = self.of_header(robot, header)?;
        summed.spent.reading_s += opening_s;
        Ok(summed)
    }

    /// The same, of a log that is open: of columns in memory, for one.
    ///
    /// # Errors
    /// As [`of_log`](Self::of_log).
    pub fn of_header(&self, robot: &Robot, header: Header) -> Result<Summed> {
        of_header(robot, &self.conditioned, header)
    }
}

impl From<Conditioned> for How {
    fn from(conditioned: Conditioned) -> Self {
        Self {
            reference: conditioned.reference.clone(),
            filter_cutoff_hz: conditioned.core.cutoff_hz(),
            conditioned,
        }
    }
}
