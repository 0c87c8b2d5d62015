//! A log as samples of the estimator: static power taken off, time as steps, mass filled in.

use std::path::Path;

use model_core::estimator::{GAP_PERIODS, Sample};
use support::context::Context;
use support::error::{Error, Result};

use super::drive::DriveReader;
use super::{Exclusions, Header, MASS};
use crate::robot::Robot;
use crate::robot::chassis::PerWheel;

/// What is measured at an instant.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RawSample {
    /// Wheel speeds, rad/s.
    pub wheel_speed: PerWheel<f64>,
    /// Wheel accelerations, rad/s², if the log has them for all wheels.
    pub wheel_acceleration: Option<PerWheel<f64>>,
    /// Actuation power, W.
    pub power: f64,
}

impl RawSample {
    /// As model-core takes it.
    ///
    /// # Panics
    /// If `N` is not the robot's number of wheels.
    pub fn core<const N: usize>(&self) -> Sample<f64, N> {
        Sample {
            wheel_speed: self.wheel_speed.array(),
            wheel_acceleration: self.wheel_acceleration.map(|accelerations| accelerations.array()),
            power: self.power,
        }
    }
}

impl<const N: usize> From<Sample<f64, N>> for RawSample {
    fn from(sample: Sample<f64, N>) -> Self {
        Self {
            wheel_speed: sample.wheel_speed.into(),
            wheel_acceleration: sample.wheel_acceleration.map(PerWheel::from),
            power: sample.power,
        }
    }
}

/// A row before the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawRow {
    /// Line of the log, the header being line 1.
    pub line: u64,
    /// What is measured.
    pub sample: RawSample,
    /// Time since the row before, s; infinite where this row does not continue it.
    pub elapsed: f64,
    /// Total mass, kg, where the log tells it.
    pub mass: Option<f64>,
    /// Run of this log, from 0.
    pub run: u32,
    /// Time within the log, s.
    pub time: f64,
    /// Turn rate by a gyro, counter-clockwise, rad/s; no number where the log has none. An empty
    /// field keeps the one before for as long as a hole in the log would.
    pub yaw_rate: f64,
}

/// Reads a log row by row.
pub struct SampleReader {
    reader: DriveReader,
    static_power: f64,
    last: Option<(u32, f64)>,
    /// The latest turn rate, rad/s, and how old it is, s.
    yaw_rate: (f64, f64),
    rows: u64,
}

impl SampleReader {
    /// Opens the log of a run of `robot`.
    ///
    /// # Errors
    /// As [`DriveReader::open`].
    pub fn open(context: &Context, path: &Path, robot: &Robot) -> Result<Self> {
        Self::open_with(context, path, robot, &[])
    }

    /// As [`open`](Self::open), with further columns, handed out by [`extras`](Self::extras).
    ///
    /// # Errors
    /// As [`DriveReader::open_with`].
    pub fn open_with(context: &Context, path: &Path, robot: &Robot, columns: &[&str]) -> Result<Self> {
        Self::of(Header::open(context, path)?, robot, columns)
    }

    /// Of an opened log.
    ///
    /// # Errors
    /// As [`open_with`](Self::open_with).
    pub fn of(header: Header, robot: &Robot, columns: &[&str]) -> Result<Self> {
        let reader = DriveReader::of(header, robot, columns)?;
        let static_power = robot.static_power_w().unwrap_or(0.0);
        Ok(Self { reader, static_power, last: None, yaw_rate: (f64::NAN, 0.0), rows: 0 })
    }

    /// The next row, or `None` at the end.
    ///
    /// # Errors
    /// As [`DriveReader::next_record`]; a mass that is not above 0.
    pub fn next_row(&mut self) -> Result<Option<RawRow>> {
        let Some(record) = self.reader.next_record()? else { return Ok(None) };
        self.rows += 1;
        if let Some(mass) = record.mass_kg
            && mass <= 0.0
        {
            return Err(Error::failed(format!("a total mass of {mass} kg; expected above 0"))
                .in_file(self.reader.path())
                .at_line(record.line)
                .in_column(MASS));
        }
        let run = record.run as u32;
        let elapsed = match self.last {
            Some((last_run, last_time)) if last_run == run => record.time_s - last_time,
            _ => f64::INFINITY,
        };
        self.last = Some((run, record.time_s));
        let (held, age) = self.yaw_rate;
        let age = age + elapsed;
        let is_fresh = age <= GAP_PERIODS * self.reader.period_s();
        self.yaw_rate = match record.yaw_rate {
            Some(rate) => (rate, 0.0),
            None => (if is_fresh { held } else { f64::NAN }, age),
        };
        Ok(Some(RawRow {
            line: record.line,
            sample: RawSample {
                wheel_speed: record.wheel_speed,
                wheel_acceleration: record.wheel_acceleration,
                power: record.power_w - self.static_power,
            },
            elapsed,
            mass: record.mass_kg,
            run,
            time: record.time_s,
            yaw_rate: self.yaw_rate.0,
        }))
    }

    /// Up to `most` of the next rows; none at the end.
    ///
    /// # Errors
    /// As [`next_row`](Self::next_row).
    pub fn next_block(&mut self, most: usize) -> Result<Vec<RawRow>> {
        let mut block = Vec::with_capacity(most);
        while block.len() < most
            && let Some(row) = self.next_row()?
        {
            block.push(row);
        }
        Ok(block)
    }

    /// The further columns of the row handed out last, in the order asked for; NaN where a field is
    /// empty.
    pub fn extras(&self) -> &[f64] {
        self.reader.extras()
    }

    /// Names of the runs seen so far, indexed by [`RawRow::run`].
    pub fn run_names(&self) -> &[String] {
        self.reader.run_names()
    }

    /// Median sample period, s.
    pub fn period_s(&self) -> f64 {
        self.reader.period_s()
    }

    /// Rows left out so far.
    pub fn exclusions(&self) -> Exclusions {
        self.reader.exclusions()
    }

    /// Bytes read and the size of the file.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.reader.progress()
    }

    /// Whether the log tells the mass.
    pub fn has_mass(&self) -> bool {
        self.reader.has_mass()
    }

    /// Rows handed out.
    pub fn rows(&self) -> u64 {
        self.rows
    }
}
