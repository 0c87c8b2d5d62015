//! Which filter a robot's sensors need.
//!
//! A high cutoff lets the noise of speeds and their derivatives through, which the sizes in the model turn into bias; a
//! low one smears short accelerations and clamps that the model could have followed. The right one depends on the sensors,
//! so it is measured: each candidate filters the first rows of the logs, the signed model is fitted, and the residual's
//! means over a second, which every cutoff passes alike, are compared.

use std::collections::BTreeMap;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::thread;

use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::Gate;
use model_core::estimator::Conditioner;
use model_core::model::Model;

use super::dataset::{Dataset, Row, condition};
use super::physical;
use crate::error::Result;
use crate::log::{RawRow, SampleReader};
use crate::robot::Robot;

/// Candidates, Hz: half-octaves from where means over a second pass unchanged.
const CANDIDATES: [f64; 11] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0];

/// Highest candidate as a share of the sample rate.
const HIGHEST_SHARE: f64 = 0.3;

/// Rows that take part, over all logs.
const MOST_ROWS: usize = 50_000;

/// The first rows of a log.
struct Pilot<const N: usize> {
    rows: Vec<RawRow<N>>,
    period_s: f64,
}

/// The cutoff with the least residual over a second, Hz.
///
/// # Errors
/// A log that cannot be read, or a robot with impossible dimensions.
pub(super) fn choose<const N: usize>(robot: &Robot, files: &[PathBuf], mass_kg: f64) -> Result<f64> {
    let share = MOST_ROWS / files.len().max(1);
    let mut pilots = Vec::new();
    for file in files {
        let mut reader = SampleReader::<N>::open(file, robot)?;
        let mut rows = Vec::new();
        while rows.len() < share
            && let Some(row) = reader.next_row()?
        {
            rows.push(row);
        }
        pilots.push(Pilot { rows, period_s: reader.period_s() });
    }
    let slowest = pilots.iter().map(|pilot| pilot.period_s).fold(0.0, f64::max);
    let highest = HIGHEST_SHARE / slowest;
    let mut candidates = Vec::new();
    for cutoff_hz in CANDIDATES.into_iter().filter(|cutoff| *cutoff <= highest) {
        candidates.push((cutoff_hz, robot.core::<N>(cutoff_hz)?));
    }
    let (even, odd): (Vec<_>, Vec<_>) =
        candidates.into_iter().enumerate().partition(|(index, _)| index % 2 == 0);
    let attempt = |half: Vec<(usize, (f64, CoreRobot<f64, N>))>| -> Vec<(f64, Seconds)> {
        let one = |(_, (cutoff_hz, core))| Some((cutoff_hz, residual(robot, &core, &pilots, mass_kg)?));
        half.into_iter().filter_map(one).collect()
    };
    // Two threads, not one a candidate: each holds as many rows as a whole store.
    let mut tried = thread::scope(|scope| {
        let other = scope.spawn(|| attempt(odd));
        let mut tried = attempt(even);
        tried.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        tried
    });
    tried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(lowest_good_enough(&tried).unwrap_or(highest.min(CANDIDATES[0])))
}

/// The lowest cutoff that is not worse than the best by more than one standard error of their difference: the less passes
/// the filter, the less noise the predicted power is compared with.
fn lowest_good_enough(tried: &[(f64, Seconds)]) -> Option<f64> {
    let (_, best) = tried.iter().min_by(|(_, a), (_, b)| a.mean_size().total_cmp(&b.mean_size()))?;
    tried.iter().find(|(_, seconds)| seconds.not_worse_than(best)).map(|(cutoff_hz, _)| *cutoff_hz)
}

/// The residual's means over each second.
fn residual<const N: usize>(
    robot: &Robot,
    core: &CoreRobot<f64, N>,
    pilots: &[Pilot<N>],
    mass_kg: f64,
) -> Option<Seconds> {
    let mut dataset = Dataset::empty(*core, Gate::Signed);
    for (log, pilot) in pilots.iter().enumerate() {
        let mut conditioner = Conditioner::new(core, pilot.period_s).ok()?;
        for raw in &pilot.rows {
            if let Some(row) = condition(&mut conditioner, raw, mass_kg) {
                // Logs and their runs are told apart by one number.
                dataset.keep(Row { run: row.run * pilots.len() as u32 + log as u32, ..row });
            }
        }
    }
    let model =
        Model::Signed { torque: physical::solve(&dataset, robot.drive()).torque, drive: robot.drive() };
    let mut seconds = Seconds::default();
    for row in &dataset.store {
        seconds.add((row.run, row.time.floor() as i64), row.power - model.power(&row.motion, row.mass)?);
    }
    seconds.close();
    (!seconds.sizes.is_empty()).then_some(seconds)
}

/// Sizes of a residual's means over seconds, W. Sizes, not squares: the few seconds with the hardest starts and stops must
/// not decide alone.
#[derive(Default)]
struct Seconds {
    current: Option<(u32, i64)>,
    sum: f64,
    rows: f64,
    sizes: BTreeMap<(u32, i64), f64>,
}

impl Seconds {
    fn add(&mut self, second: (u32, i64), residual: f64) {
        if self.current != Some(second) {
            self.close();
            self.current = Some(second);
        }
        self.sum += residual;
        self.rows += 1.0;
    }

    fn close(&mut self) {
        if let Some(second) = self.current.take() {
            self.sizes.insert(second, (self.sum / self.rows).abs());
        }
        (self.sum, self.rows) = (0.0, 0.0);
    }

    fn mean_size(&self) -> f64 {
        self.sizes.values().sum::<f64>() / self.sizes.len() as f64
    }

    /// Compared second by second.
    fn not_worse_than(&self, best: &Self) -> bool {
        let worse: Vec<f64> =
            self.sizes.iter().filter_map(|(second, size)| Some(size - best.sizes.get(second)?)).collect();
        let count = worse.len() as f64;
        let mean = worse.iter().sum::<f64>() / count;
        let variance = worse.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        mean <= (variance / count).sqrt()
    }
}
