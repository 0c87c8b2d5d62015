//! Which filter a robot's sensors need.
//!
//! A high cutoff lets the noise of speeds and their derivatives through, which the sizes in the
//! model turn into bias; a low one smears short accelerations and clamps that the model could have
//! followed. The right one depends on the sensors, so it is measured: each candidate filters the
//! first rows of the logs, the signed model is fitted, and the residual's means over a second,
//! which every cutoff passes alike, are compared by the likelihood of a distribution with heavy
//! tails. The fit takes some thousands of these rows, the means take them all.
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
use numerics::robust::median;
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
        let choice = form::choose(robot, &cores[place], terms, pilots, &|_| false, None);
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

/// A candidate's form of the model, and what it loses.
struct Tried {
    choice: Choice,
    losses: Losses,
}

/// `None` where a log is too slow for it.
fn tried(robot: &Robot, core: &Chassis, pilots: &Pilots, choice: Choice) -> Option<Tried> {
    let losses = residual(robot, core, pilots, &choice.form)?;
    Some(Tried { choice, losses })
}

/// The lowest cutoff that is not worse than the best by more than one standard error of their
/// difference: the less passes the filter, the less noise the predicted power is compared with.
fn lowest_good_enough(tried: &[Option<Tried>]) -> Option<usize> {
    let best = tried.iter().flatten().min_by(|a, b| a.losses.mean().total_cmp(&b.losses.mean()))?;
    tried.iter().position(|one| one.as_ref().is_some_and(|one| one.losses.not_worse_than(&best.losses)))
}

/// What the residual loses in each second.
fn residual(robot: &Robot, core: &Chassis, pilots: &Pilots, form: &Form) -> Option<Losses> {
    let mut dataset = Dataset::empty(core.with_conditioning(form.conditioning), Gate::Signed);
    dataset.free_terms = form.free_terms;
    let rows = pilots.condition(&dataset.robot, MOST_ROWS)?;
    let stride = rows.len().div_ceil(FITTED_ROWS).max(1);
    dataset.store = rows.iter().step_by(stride).collect();
    let model = Model::Signed { torque: physical::solve(&dataset, robot).torque, drive: robot.drive() };
    let mut sums: BTreeMap<Second, (f64, f64)> = BTreeMap::new();
    for row in rows.iter() {
        let (sum, count) = sums.entry((row.run, row.time.floor() as i64)).or_default();
        *sum += row.power - row.predicted(&model)?;
        *count += 1.0;
    }
    Losses::of(&sums.into_iter().map(|(second, (sum, count))| (second, sum / count)).collect())
}

/// A run, and a second of it.
type Second = (u32, i64);

/// Student's distributions from Cauchy's to nearly the normal one: degrees of freedom, the size
/// below which half of it lies, and the logarithm of its density at 0 (SciPy: `t.ppf(0.75, k)`,
/// `t.logpdf(0, k)`).
const TAILS: [(f64, f64, f64); 5] = [
    (1.0, 1.0, -1.144_729_886),
    (2.0, 0.816_496_581, -1.039_720_771),
    (4.0, 0.740_697_084, -0.980_829_253),
    (8.0, 0.706_386_613, -0.950_108_612),
    (16.0, 0.690_132_254, -0.934_553_408),
];

/// Smallest scale of the means over seconds, W: above what the digits of a log leave.
const LEAST_SCALE: f64 = 1e-6;

/// How badly each second's mean residual is explained, nats: by the one of [`TAILS`] that explains
/// a candidate best. A hard turn can leave a hundred times what a crawl leaves; by sizes in W such
/// seconds would decide alone.
struct Losses(BTreeMap<Second, f64>);

impl Losses {
    /// Of means in W; `None` without any.
    fn of(means: &BTreeMap<Second, f64>) -> Option<Self> {
        let mut sizes: Vec<f64> = means.values().map(|mean| mean.abs()).collect();
        let middle = median(&mut sizes)?;
        let by_tail = TAILS.map(|(freedom, half, log_peak)| {
            let scale = (middle / half).max(LEAST_SCALE);
            let loss = |mean: &f64| {
                scale.ln() - log_peak + (freedom + 1.0) / 2.0 * ((mean / scale).powi(2) / freedom).ln_1p()
            };
            Self(means.iter().map(|(second, mean)| (*second, loss(mean))).collect())
        });
        by_tail.into_iter().min_by(|a, b| a.mean().total_cmp(&b.mean()))
    }

    fn mean(&self) -> f64 {
        self.0.values().sum::<f64>() / self.0.len() as f64
    }

    /// Compared second by second.
    fn not_worse_than(&self, best: &Self) -> bool {
        let worse: Vec<f64> =
            self.0.iter().filter_map(|(second, loss)| Some(loss - best.0.get(second)?)).collect();
        let count = worse.len() as f64;
        let mean = worse.iter().sum::<f64>() / count;
        let variance = worse.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        mean <= (variance / count).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn losses(seconds: usize, mean: impl Fn(usize) -> f64) -> Losses {
        Losses::of(&(0..seconds).map(|second| ((0, second as i64), mean(second))).collect()).unwrap()
    }

    /// Alternating signs; every tenth second is a hard turn.
    fn turning(quiet: f64, turn: f64) -> Losses {
        losses(400, |second| {
            let size = if second % 10 == 0 { turn } else { quiet * (1.0 + (second % 7) as f64 / 10.0) };
            if second % 2 == 0 { size } else { -size }
        })
    }

    #[test]
    fn hard_turns_do_not_decide_alone() {
        let (smears, follows) = (turning(1.0, 100.0), turning(0.5, 120.0));
        assert!(follows.mean() < smears.mean() && !smears.not_worse_than(&follows));
        // By sizes in W it would be the worse: 20 W in a tenth of them outweigh 0.65 W in the rest.
        assert!(follows.not_worse_than(&smears) && follows.not_worse_than(&follows));
    }

    /// SciPy: the least mean of `-t.logpdf(x, k, scale=1 / t.ppf(0.75, k))` over the degrees of
    /// freedom; the median's size is 1 W.
    #[test]
    fn the_tail_is_the_one_that_explains_best() {
        for (sizes, mean) in [([0.5, -1.0, 2.0], 1.728_289_414), ([0.1, 1.0, -1000.0], 5.984_266_242)] {
            let got = losses(3, |second| sizes[second]).mean();
            assert!((got - mean).abs() < 1e-6, "{sizes:?}: {got}");
        }
    }
}
