//! `gmr gap-bench`: hidden effects from the plant, and what the workflow makes of them.

pub mod count;
pub mod coverage;
pub mod manoeuvre;
pub mod sets;

use std::time::Instant;

use indicatif::ProgressBar;
use logs::robot::Robot;
use model::effects::ENTRIES;
use plant::effects::Effect;
use rayon::prelude::*;
use support::error::{Error, Result};

use self::sets::{NoiseKind, noises};
use crate::likelihood::LEVEL;
use crate::weighed;
use residuals::types::{Options, Verdict};

/// The effects that are hidden in a set of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Effects before scaling.
    pub effects: Vec<Effect>,
    /// RMS of what each adds, in standard deviations of the noise.
    pub size: f64,
    /// Seed of the set.
    pub seed: u64,
    /// Noise of the power.
    pub noise: NoiseKind,
    /// Ids that are taken out of the dictionary.
    pub removed: Vec<String>,
}

impl Case {
    /// Its effects, scaled.
    fn scaled(&self) -> Result<Vec<Effect>> {
        self.effects.iter().map(|effect| sets::scaled(effect, self.size, self.seed)).collect()
    }
}

/// Which cases are asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// Only these effects; all where none is named.
    pub only: &'a [String],
    /// As [`Case::size`].
    pub sizes: &'a [f64],
    /// How many of every effect and size.
    pub seeds: u64,
    /// The first one.
    pub first_seed: u64,
    /// Cases without effects.
    pub free: u64,
    /// Cases whose effect is taken out of the dictionary, of every effect.
    pub removed: u64,
    /// Cases with two effects.
    pub pairs: usize,
}

impl Request<'_> {
    /// The cases.
    ///
    /// # Errors
    /// There is none.
    pub fn cases(&self) -> Result<Vec<Case>> {
        let Self { only, sizes, seeds, first_seed, free, removed, pairs } = *self;
        let is_asked = |effect: &Effect| only.is_empty() || only.iter().any(|only| only == effect.id());
        let effects: Vec<Effect> = typical()?.into_iter().filter(is_asked).collect();
        let case = |effects: Vec<Effect>, size, seed| Case {
            effects,
            size,
            seed,
            noise: noises()[0],
            removed: Vec::new(),
        };
        let mut cases = Vec::new();
        for effect in &effects {
            for &size in sizes {
                let seeds = first_seed..first_seed + seeds;
                cases.extend(seeds.map(|seed| case(vec![effect.clone()], size, seed)));
            }
            for seed in first_seed..first_seed + removed {
                let removed = vec![effect.id().to_owned()];
                cases.push(Case { removed, ..case(vec![effect.clone()], 1.0, seed) });
            }
        }
        for pair in 0..pairs {
            let (first, step) =
                (pair % effects.len(), 1 + pair / effects.len() * 3 % (effects.len() - 1).max(1));
            let second = (first + step) % effects.len();
            if effects[first].id() != effects[second].id() {
                let both = vec![effects[first].clone(), effects[second].clone()];
                cases.push(case(both, 1.0, first_seed + pair as u64));
            }
        }
        cases.extend((0..free).map(|k| effect_free(1000 * first_seed + k)));
        if cases.is_empty() {
            return Err(Error::usage("no set is asked for"));
        }
        Ok(cases)
    }
}

/// What became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// The answer.
    pub verdict: Verdict,
    /// Names given.
    pub named: Vec<String>,
    /// Hypotheses in a tie.
    pub ties: Vec<String>,
    /// Gap closed on locked runs.
    pub closed: Option<f64>,
    /// Time for the workflow alone, s.
    pub seconds: f64,
    /// How the last round ended.
    pub note: String,
    /// How probable the first name is among the listed effects.
    pub probability: Option<f64>,
}

/// Effects of a case in a typical strength: sizes are then scaled.
///
/// # Errors
/// An id that the plant does not know.
pub fn typical() -> Result<Vec<Effect>> {
    ENTRIES.iter().flat_map(|entry| entry.typical).map(|effect| Effect::parse(effect)).collect()
}

/// Runs the cases on all cores; the outcomes are ordered by what was hidden.
///
/// # Errors
/// What plant, fit and workflow refuse.
pub fn run(robot: &Robot, cases: &[Case], bar: &ProgressBar) -> Result<Vec<Outcome>> {
    let mut outcomes = all(cases, bar, |case| one(robot, case))?;
    outcomes.sort_by_key(|outcome| (count::label(outcome), outcome.case.size.to_bits(), outcome.case.seed));
    Ok(outcomes)
}

/// Works on the cases on all cores; the outcomes are in the order of the cases.
fn all<T: Send>(
    cases: &[Case],
    bar: &ProgressBar,
    work: impl Fn(&Case) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    cases.par_iter().map(|case| work(case).inspect(|_| bar.inc(1))).collect()
}

/// One case.
///
/// # Errors
/// As [`run`].
pub fn one(robot: &Robot, case: &Case) -> Result<Outcome> {
    let columns = columns(case);
    let clean = sets::clean(robot, case.seed, case.noise.noise, columns)?;
    let effects = case.scaled()?;
    let raw = sets::record(&sets::field(&effects, case.noise.noise).field(case.seed), columns)?;
    let runs = clean.runs.condition_alike(&clean.runs.robot, raw)?;
    let options = Options { removed: case.removed.clone(), ..Options::default() };
    let started = Instant::now();
    let report = weighed::investigate(&runs, Some(&clean.runs), &clean.base, &options, LEVEL)?;
    let seconds = started.elapsed().as_secs_f64();
    Ok(Outcome {
        case: Case { effects, ..case.clone() },
        verdict: report.verdict,
        named: report.effects.iter().map(|effect| effect.candidate.id.clone()).collect(),
        ties: report.ambiguous_with.clone(),
        closed: report.confirmed.closed,
        seconds,
        probability: report.effects.first().and_then(|named| {
            let rival = report.rivals.iter().find(|(id, _)| *id == named.candidate.id)?;
            Some(rival.1)
        }),
        note: report.rounds.last().map_or(String::new(), |round| round.outcome.clone()),
    })
}

/// The columns that a case's logs have beside speed, power and mass.
fn columns(case: &Case) -> &'static [&'static str] {
    let needs_processor = case.effects.iter().any(|effect| effect.id() == "compute-load");
    if needs_processor { &["cpu_percent"] } else { &[] }
}

/// A case without effects; the kinds of noise take turns.
pub fn effect_free(seed: u64) -> Case {
    let noise = noises()[seed as usize % noises().len()];
    Case { effects: Vec::new(), size: 0.0, seed, noise, removed: Vec::new() }
}
