//! `gmr gap --engine likelihood`: one likelihood in place of thresholds. Experimental.
//!
//! A hierarchical Gaussian model of clean and field runs: the base's parameters, what the model's
//! form gets wrong in all runs alike and from run to run, the noise, and in the field one effect of
//! the dictionary, or something else. All but the effect is integrated out; causes are compared by
//! what is left, and [`priors`] has every prior with its reason. All field runs take part: none is
//! locked.

pub mod bagged;
pub mod delay;
pub mod evidence;
pub mod extended;
pub mod functions;
pub mod gate;
pub mod noise;
pub mod normal;
pub mod posterior;
pub mod precision;
pub mod predicted;
pub mod priors;
pub mod products;
pub mod question;
pub mod relinearise;
pub mod round;
pub mod rows;
pub mod scored;
pub mod step_times;
#[cfg(test)]
mod tests;
pub mod variances;
pub mod ways;
pub mod wrong_masses;

pub use gate::Gate;
pub use posterior::{Cause, Posterior};

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};
use numerics::intervals::MeanInterval;
use support::error::{Error, Result};

use self::question::Question;
use self::round::{Known, state_of};
use crate::confirm;
use crate::investigate::{joint, named_effects};
use crate::report::localise;
use crate::report::{Basis, Report, Rival};
use residuals::predictor::{Predictor, State};
use residuals::problem::open::{open_problem, precision};
use residuals::split;
use residuals::thresholds::calibrate::LEAST_RUNS;
use residuals::types::{Base, Options, Verdict};

/// The level of the gate, where none is asked for.
pub const LEVEL: f64 = 0.02;

/// What the likelihood says beside the verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Likelihood {
    /// Probabilities.
    pub posterior: Posterior,
    /// By how much likelier a field run is with the first name told of the others, nats.
    pub predictive: Option<MeanInterval>,
}

/// Asks field runs what they have that clean ones lack.
///
/// # Errors
/// Too few runs, or runs without steady rows.
pub fn investigate(
    runs: &Runs,
    clean: Option<&Runs>,
    base: &Base,
    options: &Options,
    level: f64,
) -> Result<Report> {
    let split = split::by_run(runs)?;
    let question = Question::of(runs, clean, base, options);
    let asked = question.asked(base, options, level);
    let Question { clean_delay, parameters, ref testable, .. } = question;
    let first = asked.round(&[]).ok_or_else(|| {
        Error::failed("too few steady rows to tell the noise of the power; expected runs of a minute or so")
    })?;
    let mut notes = few_clean_runs(clean.map_or(0, |clean| clean.runs.len()));
    notes.extend(first.note.clone());
    let mut verdict = first.verdict;
    let mut rounds = vec![first.record()];
    let mut tied = first.named();
    let mut known: Vec<Known> = tied.first().cloned().into_iter().collect();
    // One after the other: what a name explains hides what is beside it.
    while verdict == Verdict::Named && rounds.len() == known.len() && known.len() < options.most_effects {
        let Some(next) = asked.round(&known) else { break };
        rounds.push(next.record());
        if next.verdict == Verdict::Unexplained {
            notes.push("something is left beside it that no effect of the list explains".to_owned());
        }
        if next.verdict.stands() {
            (verdict, tied) = (next.verdict, next.named());
            known.extend(tied.first().cloned());
        }
    }
    let predictive = first.predictive();
    if !known.is_empty() && predictive.is_none() {
        notes.push("it lives in single runs: no run tells of another, and none confirms it".to_owned());
    }
    let together = first.together(&known);
    let covariance = together.as_ref().map(|(_, covariance)| covariance.clone());
    let others = known.split_last().map_or(Vec::new(), |(_, others)| others.to_vec());
    let known = together.map_or(known, |(known, _)| known);
    let state = state_of(base, &known);
    // The base stays where it was: its own uncertainty is in that of the effects.
    let joined = covariance.as_ref().and_then(|covariance| joint(covariance, false, base));
    let named: Vec<Candidate> = known.into_iter().map(|(candidate, _)| candidate).collect();
    let effects = joined.as_ref().or(covariance.as_ref()).map_or(Vec::new(), |covariance| {
        named_effects(&named, &state, covariance, runs.robot.rows(), options.slack)
    });
    let open = runs.subset(&split.open).with_clean(clean);
    let open_predictor = Predictor { runs: &open, ..asked.predictor };
    let problem = open_problem(open_predictor, &[], base, parameters, &testable.list, options);
    let of_open = |state: &State| State { effects: at_places(state, &split.open), ..state.clone() };
    let of_locked = |state: &State| State { effects: at_places(state, &split.locked), ..state.clone() };
    let confirmed = confirm::on_locked(runs, &split, clean, base, &of_locked(&state), &problem, parameters);
    let sides =
        [(open_predictor.residual(&state_of(base, &[])), 0), (open_predictor.residual(&of_open(&state)), 1)];
    let [before, after] = sides.map(|(open, side)| split.in_order(&open, &confirmed.residuals[side]));
    let mut localisation = localise::cells(runs, &before);
    if verdict.stands() {
        localise::fill_after(runs, &mut localisation, &after);
    }
    let rival = |cause: &Known| {
        let state = state_of(base, &others.iter().chain([cause]).cloned().collect::<Vec<_>>());
        Rival { candidate: cause.0.clone(), state: of_open(&state) }
    };
    let ties = match verdict {
        Verdict::Ambiguous => vec![tied.iter().map(rival).collect()],
        _ => Vec::new(),
    };
    let mut ambiguous_with: Vec<String> = match verdict {
        Verdict::Ambiguous => tied.iter().skip(1).map(|(candidate, _)| candidate.id.clone()).collect(),
        _ => Vec::new(),
    };
    ambiguous_with.sort();
    Ok(Report {
        verdict,
        effects,
        ambiguous_with,
        not_testable: testable.not_testable.clone(),
        rounds,
        localisation,
        residuals: (before, verdict.stands().then_some(after)),
        confirmed,
        base: [base.torque; 2],
        state,
        covariance: joined,
        split,
        over_dispersion: None,
        clean_structure: None,
        refit: Vec::new(),
        ties,
        basis: Some(Basis {
            drive: base.drive,
            clean_delay,
            whitener: problem.noise.whitener.clone(),
            std_w: problem.noise.usual_w(),
            precision: precision(base, parameters, options.slack),
        }),
        rivals: Vec::new(),
        likelihood: Some(Likelihood { posterior: first.posterior, predictive }),
        relabelled: first.gate,
        notes,
    })
}

/// What a state has of some runs, by their places among these.
fn at_places(state: &State, places: &[usize]) -> Vec<(Regressor, f64)> {
    let place_of = |run: usize| places.iter().position(|place| *place == run);
    let moved = |(regressor, coefficient): &(Regressor, f64)| {
        let regressor = match regressor {
            Regressor::Mass(run) => Regressor::Mass(place_of(*run)?),
            Regressor::InRun(run, term) => Regressor::InRun(place_of(*run)?, *term),
            Regressor::Switch(what, times) => {
                let kept = places.iter().filter_map(|run| times.get(*run).copied());
                Regressor::Switch(*what, kept.collect::<Vec<f64>>().into())
            }
            other => other.clone(),
        };
        Some((regressor, *coefficient))
    };
    state.effects.iter().filter_map(moved).collect()
}

/// What few clean runs cost.
fn few_clean_runs(count: usize) -> Vec<String> {
    match count {
        0 => vec!["without clean runs nothing tells what the model gets wrong without any effect: probabilities are too sure".to_owned()],
        _ if count < LEAST_RUNS => vec![format!(
            "{count} clean run{}: how much runs differ is hardly known, and small effects are not seen; {LEAST_RUNS} tell it to a factor of \
             three",
            if count == 1 { "" } else { "s" }
        )],
        _ => Vec::new(),
    }
}
