//! The board's filter for a log, and a gyro beside it where the coefficients ask for one.

use std::path::Path;

use model_core::delay::FRAMES;
use model_core::estimator::Unfit;
use model_core::filter::InvalidCutoff;
use model_core::gyro::GyroConditioner;
use support::error::Error;

use super::robot::chassis::{Chassis, Wheels};
use super::{RUN, RawRow, RawSample};
use crate::with_core;

/// A row behind the filter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Now {
    /// The wheels.
    pub wheels: Wheels,
    /// Actuation power, W.
    pub power: f64,
    /// Whether the filter has settled.
    pub settled: bool,
}

/// The conditioner of a robot's logs, whatever its number of wheels.
pub struct Conditioner {
    filter: Box<dyn Push + Send>,
    /// Told by reference: it is as large as that of the robot with the most wheels.
    now: Now,
}

impl Conditioner {
    /// For rows `period_s` apart.
    ///
    /// # Errors
    /// As of [`GyroConditioner::new`].
    pub fn new(robot: &Chassis, period_s: f64) -> Result<Self, Unfit> {
        Ok(with_core!(robot, core => Self::of(Box::new(GyroConditioner::new(core, period_s)?))))
    }

    /// For a log of this robot.
    ///
    /// # Errors
    /// The log is too slow for the filter.
    pub fn of_log(robot: &Chassis, file: &Path, period_s: f64) -> support::error::Result<Self> {
        if period_s.is_nan() {
            let message = "no two rows belong to one run; expected runs of many rows";
            return Err(Error::failed(message).in_file(file).in_column(RUN));
        }
        Self::new(robot, period_s).map_err(|why| {
            let message = match why {
                Unfit::Cutoff(InvalidCutoff { cutoff_hz, below_hz }) => format!(
                    "sampled at {:.2} Hz, too slow for the filter's cutoff of {cutoff_hz} Hz; expected a cutoff \
                     below {below_hz:.2} Hz (filter_cutoff_hz in robot.toml)",
                    1.0 / period_s,
                ),
                Unfit::Model | Unfit::Delay => format!(
                    "sampled at {:.2} Hz, too fast for a delay of {} s; expected at most {FRAMES} sample periods",
                    1.0 / period_s,
                    robot.conditioning().delay,
                ),
                Unfit::Sides => "true slip of a robot that has no two sides".to_owned(),
            };
            Error::failed(message).in_file(file)
        })
    }

    fn of(filter: Box<dyn Push + Send>) -> Self {
        Self { filter, now: Now::default() }
    }

    /// The next row behind the filter; `None` where it tells nothing yet.
    pub fn push(&mut self, row: &RawRow) -> Option<&Now> {
        self.push_sample(&row.sample, row.yaw_rate, row.elapsed)
    }

    /// The same of a sample `elapsed` s after the one before, with the turn rate by a gyro, rad/s.
    pub fn push_sample(&mut self, sample: &RawSample, turn_rate: f64, elapsed: f64) -> Option<&Now> {
        self.filter.push(sample, turn_rate, elapsed, &mut self.now).then_some(&self.now)
    }
}

trait Push {
    /// Whether it tells anything.
    fn push(&mut self, sample: &RawSample, turn_rate: f64, elapsed: f64, now: &mut Now) -> bool;
}

impl<const N: usize> Push for GyroConditioner<f64, N> {
    fn push(&mut self, sample: &RawSample, turn_rate: f64, elapsed: f64, now: &mut Now) -> bool {
        let Some(passed) = self.push(&sample.core(), turn_rate, elapsed) else { return false };
        now.wheels.set(&passed.motion.wheels);
        (now.power, now.settled) = (passed.power, passed.settled);
        true
    }
}
