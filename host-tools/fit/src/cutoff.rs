//! Which filter a robot's sensors need.
//!
//! A high cutoff lets the noise of speeds and their derivatives through, which the sizes in the
//! model turn into bias; a low one smears short accelerations and clamps that the model could have
//! followed. The right one depends on the sensors, so it is measured: each candidate filters the
//! first rows of the logs, the signed model is fitted, and what mass and energy of blocks of ten
//! seconds lose by what it leaves is compared. (Their residual alone hardly shows what a low cutoff
//! smears of what tells the mass: `cargo xtask bench kinds`.)
//!
//! What the model lacks hides what a cutoff smears: with the slip memory of a skid-steered robot left out every cutoff is as bad as the
//! next. So candidates are asked again with the terms that the logs carry behind each ([`by_the_data`]).

use std::collections::BTreeMap;

use logs::robot::Robot;
use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::Gate;
use model_core::model::Model;
use model_core::payload::huber;
use model_core::plausibility::LEAST_CUTOFF;
use rayon::prelude::*;
use support::error::Result;

use super::assess;
use super::dataset::Dataset;
use super::form::{self, Choice, Form, Term};
use super::physical;
use super::pilot::Pilots;

/// Candidates, Hz: half-octaves from where a second passes unchanged.
const CANDIDATES: [f64; 11] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0, 32.0];

/// Candidates in an octave.
const OCTAVE: usize = 2;

/// Highest candidate as a share of the sample rate.
const HIGHEST_SHARE: f64 = 0.3;

/// Mass and energy are judged over blocks of this length, s: of a filtered signal's many
/// correlation times, and many in a log.
const BLOCK_S: f64 = 10.0;

/// Rows of which the residual is taken, at most about.
const MOST_ROWS: usize = 50_000;

/// The cutoff, Hz, with those of the further terms that the logs carry behind it. Where they carry any behind the one that is chosen
/// without, every octave is asked with its own: their numbers make up for what a cutoff smears.
///
/// # Errors
/// A robot with impossible dimensions.
pub(super) fn by_the_data<const N: usize>(
    robot: &Robot,
    pilots: &Pilots<N>,
    terms: &[Term],
) -> Result<(f64, Choice)> {
    let highest = (HIGHEST_SHARE / pilots.slowest_s()).max(LEAST_CUTOFF);
    let mut cores = Vec::new();
    for cutoff_hz in CANDIDATES.into_iter().filter(|cutoff| *cutoff <= highest) {
        cores.push(robot.core::<N>(cutoff_hz)?);
    }
    if cores.is_empty() {
        cores.push(robot.core(highest)?);
    }
    let plain = |place: usize| tried(robot, &cores[place], pilots, Choice::default());
    let own = |place: usize| {
        let choice = form::choose(robot, &cores[place], terms, pilots, &|_| false);
        tried(robot, &cores[place], pilots, choice)
    };
    let all: Vec<Option<Tried>> = (0..cores.len()).into_par_iter().map(plain).collect();
    let first = lowest_good_enough(&all).unwrap_or(0);
    let mut asked: Vec<Option<Tried>> = cores.iter().map(|_| None).collect();
    asked[first] = own(first);
    if asked[first].as_ref().is_some_and(|tried| tried.choice.form != Form::default()) {
        let others: Vec<usize> = (0..cores.len()).step_by(OCTAVE).filter(|place| *place != first).collect();
        let found: Vec<Option<Tried>> = others.par_iter().map(|&place| own(place)).collect();
        for (place, found) in others.into_iter().zip(found) {
            asked[place] = found;
        }
    }
    let chosen = lowest_good_enough(&asked).unwrap_or(first);
    let choice = asked[chosen].take().map(|tried| tried.choice).unwrap_or_default();
    Ok((cores[chosen].cutoff_hz, choice))
}

/// The form of the model behind a candidate, and what that leaves.
struct Tried {
    choice: Choice,
    lost: Lost,
}

/// `None` where a log is too slow for it.
fn tried<const N: usize>(
    robot: &Robot,
    core: &CoreRobot<f64, N>,
    pilots: &Pilots<N>,
    choice: Choice,
) -> Option<Tried> {
    let lost = lost(robot, core, pilots, &choice.form)?;
    Some(Tried { choice, lost })
}

/// The lowest cutoff that does not lose more than the best by more than one standard error of their
/// difference: the less passes the filter, the less noise the predicted power is compared with.
fn lowest_good_enough(tried: &[Option<Tried>]) -> Option<usize> {
    let best = tried.iter().flatten().min_by(|a, b| a.lost.mean().total_cmp(&b.lost.mean()))?;
    tried.iter().position(|own| own.as_ref().is_some_and(|own| own.lost.not_worse_than(&best.lost)))
}

/// What mass and energy lose, as shares of both; `None` where a log is too slow for the cutoff.
fn lost<const N: usize>(
    robot: &Robot,
    core: &CoreRobot<f64, N>,
    pilots: &Pilots<N>,
    form: &Form,
) -> Option<Lost> {
    let core = CoreRobot { conditioning: form.conditioning, ..*core };
    let mut dataset = Dataset::empty(core, Gate::Signed);
    dataset.unequal_sides = form.unequal_sides;
    dataset.store = pilots.condition(&core, MOST_ROWS)?;
    let model = Model::Signed { torque: physical::solve(&dataset, robot).torque, drive: robot.drive() };
    let linear_beyond = assess::noise(&dataset, &model).linear_beyond(core.cutoff_hz);
    let first = dataset.store.first()?.mass;
    let one_payload = dataset.store.iter().all(|row| row.mass == first);
    let mut lost = Lost::default();
    for row in &dataset.store {
        let error = row.power - model.power(&row.motion, row.mass)?;
        let response = model.response(&row.motion, &core.range);
        // Of one payload the fit knows no slope.
        let slope = if response.may_clamp || one_payload {
            0.0
        } else {
            row.mass * response.polynomial.slope(row.mass - core.range.middle())
        };
        let weighted = huber(error, linear_beyond) * slope;
        lost.add(
            (row.run, (row.time / BLOCK_S).floor() as i64),
            [weighted * error, weighted * slope],
            [error, row.power],
        );
    }
    Some(lost).filter(|lost| lost.mean().is_finite())
}

/// By blocks, what mass and energy lose. Sizes, not squares: the few blocks with the hardest starts
/// and stops must not decide alone.
#[derive(Default)]
struct Lost {
    /// Σ w g e, W², and Σ e, W, g being the power's slope by the logarithm of the mass.
    blocks: BTreeMap<(u32, i64), [f64; 2]>,
    /// Σ w g², W², and Σ |P|, W.
    all: [f64; 2],
}

impl Lost {
    fn add(&mut self, block: (u32, i64), [score, information]: [f64; 2], [error, power]: [f64; 2]) {
        let [scores, errors] = self.blocks.entry(block).or_default();
        *scores += score;
        *errors += error;
        let [all_information, all_power] = &mut self.all;
        *all_information += information;
        *all_power += power.abs();
    }

    /// The share of the mass by which a block errs, weighed by what it says of it, and that of the
    /// energy.
    fn of(&self, [score, error]: [f64; 2]) -> f64 {
        let [information, power] = self.all.map(|all| all / self.blocks.len() as f64);
        let mass = if information > 0.0 { score.abs() / information } else { 0.0 };
        mass + error.abs() / power
    }

    fn mean(&self) -> f64 {
        self.blocks.values().map(|sums| self.of(*sums)).sum::<f64>() / self.blocks.len() as f64
    }

    /// Compared block by block.
    fn not_worse_than(&self, best: &Self) -> bool {
        let pairs = self.blocks.iter().filter_map(|(block, sums)| Some((sums, best.blocks.get(block)?)));
        let worse: Vec<f64> = pairs.map(|(own, other)| self.of(*own) - best.of(*other)).collect();
        let count = worse.len() as f64;
        let mean = worse.iter().sum::<f64>() / count;
        let variance = worse.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        // Of a single block nothing is known of that: the best alone is good enough.
        mean <= (variance / count).sqrt().max(0.0)
    }
}
