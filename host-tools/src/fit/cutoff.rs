//! Which filter a robot's sensors need.
//!
//! A high cutoff lets the noise of speeds and their derivatives through, which the sizes in the model turn into bias; a
//! low one smears short accelerations and clamps that the model could have followed. The right one depends on the sensors,
//! so it is measured: each candidate filters the first rows of the logs, the signed model is fitted, and the residual's
//! means over a second, which every cutoff passes alike, are compared.

use std::collections::BTreeMap;

use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::Gate;
use model_core::model::Model;
use rayon::prelude::*;

use super::dataset::Dataset;
use super::physical;
use super::pilot::Pilots;
use crate::error::Result;
use crate::robot::Robot;

/// Candidates, Hz: half-octaves from where means over a second pass unchanged.
const CANDIDATES: [f64; 11] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0];

/// Highest candidate as a share of the sample rate.
const HIGHEST_SHARE: f64 = 0.3;

/// Rows of which the residual is taken, at most about.
const MOST_ROWS: usize = 50_000;

/// The cutoff with the least residual over a second, Hz.
///
/// # Errors
/// A robot with impossible dimensions.
pub(super) fn choose<const N: usize>(robot: &Robot, pilots: &Pilots<N>) -> Result<f64> {
    let highest = HIGHEST_SHARE / pilots.slowest_s();
    let mut candidates = Vec::new();
    for cutoff_hz in CANDIDATES.into_iter().filter(|cutoff| *cutoff <= highest) {
        candidates.push((cutoff_hz, robot.core::<N>(cutoff_hz)?));
    }
    let one =
        |(cutoff_hz, core): (f64, CoreRobot<f64, N>)| Some((cutoff_hz, residual(robot, &core, pilots)?));
    let tried: Vec<Option<(f64, Seconds)>> = candidates.into_par_iter().map(one).collect();
    let tried: Vec<(f64, Seconds)> = tried.into_iter().flatten().collect();
    Ok(lowest_good_enough(&tried).unwrap_or(highest.min(CANDIDATES[0])))
}

/// The lowest cutoff that is not worse than the best by more than one standard error of their difference: the less passes
/// the filter, the less noise the predicted power is compared with.
fn lowest_good_enough(tried: &[(f64, Seconds)]) -> Option<f64> {
    let (_, best) = tried.iter().min_by(|(_, a), (_, b)| a.mean_size().total_cmp(&b.mean_size()))?;
    tried.iter().find(|(_, seconds)| seconds.not_worse_than(best)).map(|(cutoff_hz, _)| *cutoff_hz)
}

/// The residual's means over each second.
fn residual<const N: usize>(robot: &Robot, core: &CoreRobot<f64, N>, pilots: &Pilots<N>) -> Option<Seconds> {
    let mut dataset = Dataset::empty(*core, Gate::Signed);
    dataset.store = pilots.condition(core, MOST_ROWS)?;
    let model = Model::Signed { torque: physical::solve(&dataset, robot).torque, drive: robot.drive() };
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
