//! The first rows of each log, to choose by what the whole is to be read with.

use std::path::PathBuf;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::runs::RawRun;
use logs::{Conditioner, RawRow, SampleReader};
use rayon::prelude::*;
use support::context::Context;
use support::error::Result;

use super::dataset::{Kept, Rows};
use super::of_runs;

/// Rows that take part, over all logs.
const MOST_ROWS: usize = 50_000;

/// Share of a log's rows that has the turn rate of a gyro at least, where one is looked at: what
/// starts late or ends early has more.
const LEAST_GYRO_SHARE: f64 = 0.9;

/// The first rows of every log, before any filter.
pub(super) struct Pilots {
    logs: Vec<Pilot>,
    /// Mass where a log has none, kg.
    mass_kg: f64,
}

struct Pilot {
    rows: Vec<RawRow>,
    period_s: f64,
}

impl Pilots {
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn read(context: &Context, robot: &Robot, files: &[PathBuf], mass_kg: f64) -> Result<Self> {
        let share = MOST_ROWS / files.len().max(1);
        let mut logs = Vec::new();
        for file in files {
            let mut reader = SampleReader::open(context, file, robot)?;
            let mut rows = Vec::new();
            while rows.len() < share
                && let Some(row) = reader.next_row()?
            {
                rows.push(row);
            }
            logs.push(Pilot { rows, period_s: reader.period_s() });
        }
        Ok(Self { logs, mass_kg })
    }

    /// The same without the rows that lack the turn rate of a gyro, so that a model with it and one
    /// without are judged by the same rows. `None` where a log has no gyro, or for a part of its
    /// rows only.
    pub(super) fn with_gyro(&self) -> Option<Self> {
        let has_it = |row: &&RawRow| row.yaw_rate.is_finite();
        let is_whole = |log: &Pilot| {
            log.rows.iter().filter(has_it).count() as f64 >= LEAST_GYRO_SHARE * log.rows.len() as f64
        };
        let masked = |row: &RawRow| {
            let mut row = *row;
            // No power, no row.
            row.sample.power += 0.0 * row.yaw_rate;
            row
        };
        let logs = self.logs.iter().map(|log| {
            is_whole(log)
                .then(|| Pilot { rows: log.rows.iter().map(masked).collect(), period_s: log.period_s })
        });
        Some(Self { logs: logs.collect::<Option<_>>()?, mass_kg: self.mass_kg })
    }

    /// Sample period of the slowest log, s.
    pub(super) fn slowest_s(&self) -> f64 {
        self.logs.iter().map(|log| log.period_s).fold(0.0, f64::max)
    }

    /// Sample period of the fastest log, s.
    pub(super) fn fastest_s(&self) -> f64 {
        self.logs.iter().map(|log| log.period_s).fold(f64::INFINITY, f64::min)
    }

    /// The rows after the filter of `core`, at most about so many, evenly over the whole; `None`
    /// where a log is too slow for it. One number distinguishes logs and their runs.
    pub(super) fn condition(&self, core: &Chassis, most: usize) -> Option<Rows> {
        let all: usize = self.logs.iter().map(|log| log.rows.len()).sum();
        let stride = all.div_ceil(most).max(1);
        let of_log = |(place, log): (usize, &Pilot)| {
            let mut conditioner = Conditioner::new(core, log.period_s).ok()?;
            let mut rows = Rows::with_capacity(log.rows.len(), core.wheels());
            for raw in &log.rows {
                let Some(now) = conditioner.push(raw).filter(|now| now.settled) else { continue };
                let run = raw.run * self.logs.len() as u32 + place as u32;
                rows.push(Kept { run, ..Kept::of(now, raw, self.mass_kg) });
            }
            Some(rows)
        };
        let of_logs = self.logs.par_iter().enumerate().map(of_log).collect::<Option<Vec<Rows>>>()?;
        Some(of_logs.iter().flat_map(|rows| rows.iter()).step_by(stride).collect())
    }

    /// The whole of runs in memory.
    pub(super) fn of_runs(runs: &[RawRun]) -> Self {
        let pilot = |run: &RawRun| Pilot { rows: of_runs::rows(run).collect(), period_s: run.period_s };
        Self { logs: runs.iter().map(pilot).collect(), mass_kg: f64::NAN }
    }

    /// One log of these rows.
    #[cfg(test)]
    pub(super) fn of_rows(rows: Vec<RawRow>, period_s: f64) -> Self {
        Self { logs: vec![Pilot { rows, period_s }], mass_kg: f64::NAN }
    }

    /// Powers from a time (s) on are nonsense.
    #[cfg(test)]
    pub(super) fn spoil_from(&mut self, time: f64) {
        for row in self.logs.iter_mut().flat_map(|log| &mut log.rows).filter(|row| row.time >= time) {
            row.sample.power = 1e3 * row.time.sin();
        }
    }
}
