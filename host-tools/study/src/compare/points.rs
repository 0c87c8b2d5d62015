//! Logs as baselines read them: the rows of the fit, and columns of some logs, after the same
//! filter.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use fit::dataset::{Row, condition};
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::{Conditioner, Exclusions, Header, SampleReader};
use model_core::estimator::GAP_PERIODS;
use model_core::filter::{Channel, LowPass};
use support::context::Context;
use support::error::{Error, Result};

use crate::baselines::{Need, Point, Readings};

/// Needs beside speeds and power, and their columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    needs: Vec<Need>,
    columns: Vec<&'static str>,
}

impl Wanted {
    /// The needs that all of these logs meet.
    ///
    /// # Errors
    /// A log cannot be read.
    pub fn of(context: &Context, robot: &Robot, files: &[PathBuf]) -> Result<Self> {
        let headers = files.iter().map(|file| Header::open(context, file)).collect::<Result<Vec<_>>>()?;
        let has = |column: &str| headers.iter().all(|header| header.has(column));
        let needs: Vec<Need> = Need::ALL
            .into_iter()
            .filter(|need| need.columns(robot).iter().all(|column| has(column)))
            .collect();
        let columns = needs.iter().flat_map(|need| need.columns(robot)).copied().collect();
        Ok(Self { needs, columns })
    }

    /// Whether the logs meet this need.
    pub fn has(&self, need: Need) -> bool {
        self.needs.contains(&need)
    }

    /// From the values of the columns, in their order.
    fn readings(&self, values: &[f64]) -> Readings {
        let mut readings = Readings::NONE;
        let mut values = values.iter().copied();
        let mut next = || values.next().unwrap_or(f64::NAN);
        for need in &self.needs {
            match need {
                Need::Command => {
                    readings.command.vx = next();
                    readings.command.vy = if self.columns.contains(&"cmd_vy_m_s") { next() } else { 0.0 };
                    readings.command.omega = next();
                }
                Need::Pitch => readings.pitch = next(),
                Need::SlopeHeading => readings.slope_heading = next(),
                Need::Vibration => readings.vibration = [next(), next(), next()],
                Need::RollingFriction => readings.rolling_friction = next(),
                Need::StaticFriction => readings.static_friction = next(),
            }
        }
        readings
    }
}

/// Every `stride`-th usable row of these logs, in their order.
///
/// # Errors
/// A log that cannot be read or is not one of this robot.
pub fn read(
    context: &Context,
    robot: &Robot,
    core: &Chassis,
    files: &[PathBuf],
    mass_kg: f64,
    wanted: &Wanted,
    stride: u32,
) -> Result<Vec<(Row, Point)>> {
    read_telling(context, robot, core, files, mass_kg, (wanted, stride), |_, _| ())
}

/// The same; `excluded` receives every log's unusable rows.
pub(super) fn read_telling(
    context: &Context,
    robot: &Robot,
    core: &Chassis,
    files: &[PathBuf],
    mass_kg: f64,
    (wanted, stride): (&Wanted, u32),
    excluded: impl Fn(&Path, Exclusions),
) -> Result<Vec<(Row, Point)>> {
    let mut points = Vec::new();
    let (mut runs, mut used) = (0, 0_u64);
    for file in files {
        let mut reader = SampleReader::open_with(context, file, robot, &wanted.columns)?;
        let period = reader.period_s();
        let mut conditioner = Conditioner::of_log(core, file, period)?;
        let filter = LowPass::new(core.cutoff_hz(), period).map_err(|_| {
            Error::failed(format!("sampled too slowly for a cutoff of {} Hz", core.cutoff_hz())).in_file(file)
        })?;
        let reading = |column: &&str| Reading { turns: HEADINGS.contains(column), ..Reading::default() };
        let mut channels: Vec<Reading> = wanted.columns.iter().map(reading).collect();
        let (first_run, mut last_run) = (runs, 0);
        while let Some(raw) = reader.next_row()? {
            last_run = raw.run;
            let follows = raw.elapsed >= 0.0 && raw.elapsed <= GAP_PERIODS * period;
            let elapsed = if follows { raw.elapsed / period } else { f64::INFINITY };
            let values: Vec<f64> = channels
                .iter_mut()
                .zip(reader.extras())
                .map(|(channel, value)| channel.step(&filter, *value, elapsed))
                .collect();
            let Some(row) = condition(&mut conditioner, &raw, mass_kg) else { continue };
            if used.is_multiple_of(u64::from(stride)) {
                let row = Row { run: first_run + raw.run, ..row.owned() };
                points.push((row, Point { readings: wanted.readings(&values), ..Point::new(core, &row) }));
            }
            used += 1;
        }
        runs = first_run + last_run + 1;
        excluded(file, reader.exclusions());
    }
    Ok(points)
}

/// One column after the filter.
#[derive(Default)]
struct Reading {
    channel: Channel<f64>,
    value: Option<f64>,
    /// Since its last value, sample periods.
    age: f64,
    /// Unwraps an angle: the filter has to see it continue.
    turns: bool,
    last: f64,
}

/// Columns that jump at ±π.
const HEADINGS: [&str; 1] = ["slope_heading_rad"];

impl Reading {
    /// The filtered value, so many sample periods after the previous row. An empty field keeps the
    /// value for as long as a gap in the log may last. After that the value is unknown until the
    /// column continues, and the filter restarts there.
    fn step(&mut self, filter: &LowPass<f64>, value: f64, elapsed: f64) -> f64 {
        self.age += elapsed;
        if self.age > GAP_PERIODS {
            self.value = None;
        }
        if value.is_finite() {
            let value = match self.value {
                Some(_) if self.turns => value + TAU * ((self.last - value) / TAU).round(),
                _ => value,
            };
            if self.value.is_none() {
                filter.settle(&mut self.channel, value);
            }
            self.last = value;
            self.age = 0.0;
            self.value = Some(filter.step(&mut self.channel, value).value);
        }
        self.value.unwrap_or(f64::NAN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From 3.1 to −3.1 is 0.083 rad on, not 6.2 back: the filter ends at 2π − 3.1, and stays
    /// between the two. After a gap it restarts at the log's value.
    #[test]
    fn a_heading_goes_on_past_half_a_turn() {
        let filter = LowPass::new(1.0, 0.05).unwrap();
        let mut reading = Reading { turns: true, ..Reading::default() };
        assert!((reading.step(&filter, 3.1, f64::INFINITY) - 3.1).abs() < 1e-9);
        let passed: Vec<f64> = (0..200).map(|_| reading.step(&filter, -3.1, 1.0)).collect();
        // A Butterworth filter of fifth order overshoots a step by 12.8 %, here by 0.0107 of
        // 0.0832: to 3.1939.
        assert!(passed.iter().all(|value| (3.1..3.1945).contains(value)), "{passed:?}");
        assert!((passed[199] - (TAU - 3.1)).abs() < 1e-6);
        assert!((reading.step(&filter, -3.1, f64::INFINITY) + 3.1).abs() < 1e-9);
    }

    /// Held over five empty rows, unknown from the sixth on; then a restart without memory.
    #[test]
    fn an_empty_column_is_held_no_longer_than_a_gap() {
        let filter = LowPass::new(1.0, 0.05).unwrap();
        let mut reading = Reading::default();
        assert!((reading.step(&filter, 2.0, f64::INFINITY) - 2.0).abs() < 1e-9);
        let empty: Vec<f64> = (0..7).map(|_| reading.step(&filter, f64::NAN, 1.0)).collect();
        assert!(empty[..5].iter().all(|value| (value - 2.0).abs() < 1e-9), "{empty:?}");
        assert!(empty[5..].iter().all(|value| value.is_nan()), "{empty:?}");
        assert!((reading.step(&filter, -1.0, 1.0) + 1.0).abs() < 1e-9);
    }
}
