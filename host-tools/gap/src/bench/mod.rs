//! `gmr gap-bench`: hidden effects from the plant, and what the workflow makes of them.

pub mod coverage;
pub mod manoeuvre;
pub mod sets;

use std::time::Instant;

use indicatif::ProgressBar;
use logs::robot::Robot;
use logs::runs::Runs;
use model::effects::ENTRIES;
use plant::effects::Effect;
use rayon::prelude::*;
use support::error::Result;

use self::sets::{NoiseKind, noises};
use crate::investigate::investigate;
use crate::types::{Options, Verdict};

/// What is hidden, and in how large a set.
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
}

/// Effects of a case in a typical strength: sizes are then scaled.
///
/// # Errors
/// An id that the plant does not know.
pub fn typical() -> Result<Vec<Effect>> {
    ENTRIES.iter().flat_map(|entry| entry.typical).map(|effect| Effect::parse(effect)).collect()
}

/// Runs the cases on all cores.
///
/// # Errors
/// What plant, fit and workflow refuse.
pub fn run(robot: &Robot, cases: Vec<Case>, bar: &ProgressBar) -> Result<Vec<Outcome>> {
    all(&cases, bar, |case| one(robot, case))
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
    let mut effects = Vec::new();
    for effect in &case.effects {
        effects.push(sets::scaled(effect, case.size, case.seed)?);
    }
    let raw = sets::record(&sets::field(&effects, case.noise.noise).field(case.seed), columns)?;
    let runs = Runs::condition(&clean.core, raw)?;
    let options = Options { removed: case.removed.clone(), ..Options::default() };
    let started = Instant::now();
    let report = investigate(&runs, Some(&clean.runs), &clean.base, &options)?;
    let seconds = started.elapsed().as_secs_f64();
    Ok(Outcome {
        case: Case { effects, ..case.clone() },
        verdict: report.verdict,
        named: report.effects.iter().map(|effect| effect.candidate.id.clone()).collect(),
        ties: report.ambiguous_with.clone(),
        closed: report.confirmed.closed,
        seconds,
        note: report.rounds.last().map_or(String::new(), |round| round.outcome.clone()),
    })
}

/// The columns that a case's logs have beside speed, power and mass.
fn columns(case: &Case) -> &'static [&'static str] {
    let needs_processor = case.effects.iter().any(|effect| effect.id() == "compute-load");
    if needs_processor { &["cpu_percent"] } else { &[] }
}

/// A case without effects, one noise after the other.
pub fn effect_free(seed: u64) -> Case {
    let noise = noises()[seed as usize % noises().len()];
    Case { effects: Vec::new(), size: 0.0, seed, noise, removed: Vec::new() }
}
