//! How logs are summed up, whatever number of wheels their robot has.

use std::path::{Path, PathBuf};
use std::time::Instant;

use logs::robot::Robot;
use logs::{Header, with_wheels};
use support::context::Context;
use support::error::Result;

use super::local::Reference;
use super::read::{Conditioned, Summed, of_header};

/// Sums a log's rows, of a robot of so many wheels.
type SumHeader = dyn Fn(&Robot, Header) -> Result<Summed> + Send + Sync;

/// How logs are read and summed.
pub struct How {
    /// Coefficients with their checksum, that the sums of the signed model are taken near.
    pub reference: Option<(Reference, String)>,
    /// Of the filter.
    pub filter_cutoff_hz: f64,
    of_header: Box<SumHeader>,
}

impl How {
    /// As the coefficients of this file were fitted, and near them.
    ///
    /// # Errors
    /// They cannot be read, are of another robot or of another model than the signed one, or hold
    /// effects.
    pub fn near(robot: &Robot, file: &Path, mass_kg: f64) -> Result<Self> {
        with_wheels!(robot, near(robot, file, mass_kg))
    }

    /// With this cutoff of the filter, and nothing else.
    ///
    /// # Errors
    /// A robot with a dimension that none can have.
    pub fn at(robot: &Robot, cutoff_hz: f64, mass_kg: f64) -> Result<Self> {
        with_wheels!(robot, at(robot, cutoff_hz, mass_kg))
    }

    /// With the cutoff that a fit of these logs would choose.
    ///
    /// # Errors
    /// As [`at`](Self::at); a log that cannot be read.
    pub fn chosen(context: &Context, robot: &Robot, logs: &[PathBuf], mass_kg: f64) -> Result<Self> {
        with_wheels!(robot, chosen(context, robot, logs, mass_kg))
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
        (self.of_header)(robot, header)
    }
}

impl<const N: usize> From<Conditioned<N>> for How {
    fn from(how: Conditioned<N>) -> Self {
        Self {
            reference: how.reference.clone(),
            filter_cutoff_hz: how.core.cutoff_hz,
            of_header: Box::new(move |robot, header| of_header(robot, &how, header)),
        }
    }
}

fn near<const N: usize>(robot: &Robot, file: &Path, mass_kg: f64) -> Result<How> {
    Ok(Conditioned::<N>::near(robot, file, mass_kg)?.into())
}

fn at<const N: usize>(robot: &Robot, cutoff_hz: f64, mass_kg: f64) -> Result<How> {
    let core = robot.core::<N>(cutoff_hz)?;
    Ok(Conditioned { core, drive: robot.drive(), reference: None, mass_kg }.into())
}

fn chosen<const N: usize>(context: &Context, robot: &Robot, logs: &[PathBuf], mass_kg: f64) -> Result<How> {
    at::<N>(robot, crate::choose_cutoff::<N>(context, robot, logs, mass_kg)?, mass_kg)
}
