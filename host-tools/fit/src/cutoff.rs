//! Which filter a robot's sensors need.
//!
//! A high cutoff lets the noise of speeds and their derivatives through, which the sizes in the
//! model turn into bias; a low one smears short accelerations and clamps that the model could have
//! followed. The right one depends on the sensors, so it is measured: each candidate filters the
//! first rows of the logs, the signed model is fitted, and the residual's means over a second,
//! which every cutoff passes alike, are compared. The fit takes some thousands of these rows, the
//! means take them all.
//!
//! What the model lacks hides what a cutoff smears: without the slip memory of a skid-steered robot
//! every cutoff is as bad as the next. So candidates are tried again with the terms that the logs
//! support at each cutoff ([`by_the_data`]).

use std::collections::BTreeMap;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model_core::eq18::Gate;
use model_core::model::Model;
use model_core::plausibility::LEAST_CUTOFF;
use rayon::prelude::*;
use support::error::Result;

use super::dataset::Dataset;
use super::form::{self, Choice, Form, Term};
use super::physical;
use super::pilot::Pilots;

/// Candidates, Hz: half-octaves from where means over a second pass unchanged.
const CANDIDATES: [f64; 11] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0];

/// Candidates in an octave.
const OCTAVE: usize = 2;

/// Highest candidate as a share of the sample rate.
const HIGHEST_SHARE: f64 = 0.3;

/// Rows of which the residual is taken, at most about.
const MOST_ROWS: usize = 50_000;

/// Rows that a candidate's parameters are fitted to: drawn evenly after the filter, the same for
/// every candidate. So few rows add 8 parameters / 6,000 rows, a seventh of a percent, to the
/// squared error. The seconds are compared all: their number is what distinguishes two candidates.
const FITTED_ROWS: usize = 6_000;

/// The cutoff, Hz, and the further terms that the logs support at it. The first cutoff is chosen
/// without terms. If the logs support a term there, every octave is tried with its own terms: their
/// numbers compensate for what a cutoff smears.
///
/// # Errors
/// A robot with impossible dimensions.
pub(super) fn by_the_data(robot: &Robot, pilots: &Pilots, terms: &[Term]) -> Result<(f64, Choice)> {
    let highest = (HIGHEST_SHARE / pilots.slowest_s()).max(LEAST_CUTOFF);
    let mut cores = Vec::new();
    for cutoff_hz in CANDIDATES.into_iter().filter(|cutoff| *cutoff <= highest) {
        cores.push(robot.chassis(cutoff_hz)?);
    }
    if cores.is_empty() {
        cores.push(robot.chassis(highest)?);
    }
    let plain = |place: usize| tried(robot, &cores[place], pilots, Choice::default());
    let with_terms = |place: usize| {
        let choice = form::choose(robot, &cores[place], terms, pilots, &|_| false);
        tried(robot, &cores[place], pilots, choice)
    };
    let all: Vec<Option<Tried>> = (0..cores.len()).into_par_iter().map(plain).collect();
    let first = lowest_good_enough(&all).unwrap_or(0);
    let mut asked: Vec<Option<Tried>> = cores.iter().map(|_| None).collect();
    asked[first] = with_terms(first);
    if asked[first].as_ref().is_some_and(|tried| tried.choice.form != Form::default()) {
        let others: Vec<usize> = (0..cores.len()).step_by(OCTAVE).filter(|place| *place != first).collect();
        let trials: Vec<Option<Tried>> = others.par_iter().map(|&place| with_terms(place)).collect();
        for (place, trial) in others.into_iter().zip(trials) {
            asked[place] = trial;
        }
    }
    let chosen = lowest_good_enough(&asked).unwrap_or(first);
    let choice = asked[chosen].take().map(|tried| tried.choice).unwrap_or_default();
    Ok((cores[chosen].cutoff_hz(), choice))
}

/// A candidate's form of the model, and the residual's means that it leaves.
struct Tried {
    choice: Choice,
    means: Seconds,
}

/// `None` where a log is too slow for it.
fn tried(robot: &Robot, core: &Chassis, pilots: &Pilots, choice: Choice) -> Option<Tried> {
    let means = residual(robot, core, pilots, &choice.form)?;
    Some(Tried { choice, means })
}

/// The lowest cutoff that is not worse than the best by more than one standard error of their
/// difference: the less passes the filter, the less noise the predicted power is compared with.
fn lowest_good_enough(tried: &[Option<Tried>]) -> Option<usize> {
    let best = tried.iter().flatten().min_by(|a, b| a.means.mean_size().total_cmp(&b.means.mean_size()))?;
    tried.iter().position(|one| one.as_ref().is_some_and(|one| one.means.not_worse_than(&best.means)))
}

/// The residual's means over each second.
fn residual(robot: &Robot, core: &Chassis, pilots: &Pilots, form: &Form) -> Option<Seconds> {
    let mut dataset = Dataset::empty(core.with_conditioning(form.conditioning), Gate::Signed);
    dataset.free_terms = form.free_terms;
    let rows = pilots.condition(&dataset.robot, MOST_ROWS)?;
    let stride = rows.len().div_ceil(FITTED_ROWS).max(1);
    dataset.store = rows.iter().step_by(stride).collect();
    let model = Model::Signed { torque: physical::solve(&dataset, robot).torque, drive: robot.drive() };
    let mut seconds = Seconds::default();
    for row in rows.iter() {
        seconds.add((row.run, row.time.floor() as i64), row.power - row.predicted(&model)?);
    }
    seconds.close();
    (!seconds.sizes.is_empty()).then_some(seconds)
}

/// Sizes of a residual's means over seconds, W. Sizes, not squares: the few seconds with the
/// hardest starts and stops must not decide alone.
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
