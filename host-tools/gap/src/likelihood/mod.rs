//! `gmr gap --engine likelihood`: one likelihood in place of thresholds. Experimental.
//!
//! A hierarchical Gaussian model of clean and field runs: the base's parameters, what the model's
//! form gets wrong in all runs alike and from run to run, the noise, and in the field one effect of
//! the dictionary, or something else. All but the effect is integrated out; causes are compared by
//! what is left, and [`priors`] has every prior with its reason. All field runs take part: none is
//! locked.

pub mod delay;
pub mod evidence;
pub mod functions;
pub mod gate;
pub mod noise;
pub mod normal;
pub mod own_masses;
pub mod own_times;
pub mod posterior;
pub mod precision;
pub mod predicted;
pub mod predictive;
pub mod priors;
pub mod products;
pub mod relinearise;
pub mod rows;
pub mod scored;
#[cfg(test)]
mod tests;
pub mod variances;
pub mod ways;

pub use gate::Gate;
pub use posterior::{Cause, Posterior};

use logs::runs::Runs;
use model::effects::Regressor;
use nalgebra::DMatrix;
use numerics::intervals::MeanInterval;
use rayon::prelude::*;
use support::error::{Error, Result};

use self::priors::{BENT, BENT_WAYS, NEAR, NEAR_SHARE};
use self::products::{Posed, anywhere};
use self::scored::{Scales, Scored};
use crate::confirm;
use crate::identifiable::unidentifiable;
use crate::investigate::{joint, named_effects};
use crate::problem::lag;
use crate::problem::open::{open_problem, precision};
use crate::report::localise;
use crate::report::{Basis, Report, Rival};
use crate::scope::candidates;
use crate::split;
use crate::thresholds::calibrate::LEAST_RUNS;
use crate::twin::{State, Twin};
use crate::types::{self, Base, Options, Round, Status, Verdict};

/// The level of the gate, where none is asked for.
pub const LEVEL: f64 = 0.02;

/// What the likelihood says beside the verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Probabilities.
    pub posterior: Posterior,
    /// Relabelled runs, where they were asked.
    pub gate: Option<Gate>,
    /// By how much likelier a field run is with the first name told of the others, nats.
    pub predictive: Option<MeanInterval>,
    /// What is less sure than it might be, and why.
    pub notes: Vec<String>,
}

/// Asks field runs what they have that clean ones lack.
///
/// # Errors
/// Too few runs, or runs without steady rows.
pub fn investigate<const N: usize>(
    runs: &Runs<N>,
    clean: Option<&Runs<N>>,
    base: &Base,
    options: &Options,
    level: f64,
) -> Result<Report> {
    let split = split::by_run(runs)?;
    let all = runs.with_clean(clean);
    let lag = clean.map_or(0.0, |clean| lag::of_clean(clean, base));
    let parameters = base.torque.to_array().len() - usize::from(!runs.robot.scrubs());
    let (mut list, mut not_testable) = candidates(runs, base);
    list.extend_from_slice(&options.user.candidates);
    not_testable.extend_from_slice(&options.user.not_testable);
    let mut removed = options.removed.clone();
    for missing in unidentifiable(&base.masses_kg, runs) {
        removed.push(missing.id.clone());
        not_testable.push(missing);
    }
    list.retain(|candidate| !removed.contains(&candidate.id));
    let twin = Twin { runs: &all, drive: base.drive, lag, early: 0.0 };
    let free = anywhere(&all);
    let untold = || {
        Error::failed("too few steady rows to tell the noise of the power; expected runs of a minute or so")
    };
    let posed =
        Posed::new(twin, &free, base, parameters, options.slack, &list, &removed).ok_or_else(untold)?;
    let scales = Scales::told(&posed).ok_or_else(untold)?;
    let mut scored = scored::ways(&posed, &scales);
    scored.extend(scored::in_runs(&posed, &scales, &removed));
    let covariances = bend(&posed, &scales, &mut scored);
    let other = scored::something_else(&posed, &scales);
    let posterior = Posterior::of(&scored, normal::log_mean(other));
    let (mut verdict, names) = posterior.verdict();
    if names.first().is_some_and(|cause| covariances[cause.best].is_none()) {
        // Steps to its own size led nowhere: nothing is known of it.
        verdict = Verdict::Unexplained;
    }
    let mut notes = few_clean_runs(clean.map_or(0, |clean| clean.runs.len()));
    let in_runs = names.first().is_some_and(|cause| scored[cause.best].in_runs);
    // Labels say nothing of what lives in single runs, or begins at times of their own.
    let gate = if verdict == Verdict::None || in_runs { None } else { Gate::of(&posed, level) };
    if gate.is_none() && !in_runs && verdict != Verdict::None {
        notes.push(format!(
            "these runs can be relabelled in too few ways for a level of {level}: whether they would show as much was not asked"
        ));
    }
    let outcome = if gate.is_some_and(Gate::is_shut) {
        verdict = Verdict::None;
        "relabelled runs show as much: no more than what clean runs show of each other"
    } else {
        match verdict {
            Verdict::None => "that nothing is new is too probable",
            Verdict::Unexplained => "something that the dictionary lacks is too probable",
            Verdict::Named => "one cause is sure",
            Verdict::Ambiguous => "one of several causes is sure",
        }
    };
    let names: Vec<&Cause> = if verdict.stands() { names } else { Vec::new() };
    let round = round(&scored, &posterior, &names, outcome);
    let best = names.first().map(|cause| cause.best);
    let start = State { torque: base.torque, effects: Vec::new() };
    let state_of = |best: usize| {
        let own = &scored[best];
        let regressors = own.way.candidate.regressors.iter().cloned();
        State { effects: regressors.zip(own.coefficients.iter().copied()).collect(), ..start.clone() }
    };
    // What lives in single runs is told of no other run.
    let shared = best.filter(|&best| !scored[best].in_runs);
    let predictive = shared
        .and_then(|best| predictive::score(&posed, &scales, &scored[best].way, &scored[best].coefficients));
    if best.is_some() && predictive.is_none() {
        notes.push("it lives in single runs: no run tells of another, and none confirms it".to_owned());
    }
    let state = best.map_or_else(|| start.clone(), state_of);
    let own = best.and_then(|best| covariances[best].clone());
    // The base stays where it was: its own uncertainty is in that of the effects.
    let joined = own.as_ref().and_then(|own| joint(own, false, base));
    let known = joined.as_ref().or(own.as_ref());
    let named: Vec<_> = best.map(|best| scored[best].way.candidate.clone()).into_iter().collect();
    let effects = known.map_or(Vec::new(), |known| {
        named_effects(&named, &state, known, &runs.robot.kinematics, options.slack)
    });
    let open = runs.subset(&split.open).with_clean(clean);
    let open_twin = Twin { runs: &open, ..twin };
    let problem = open_problem(open_twin, &[], base, parameters, &list, options);
    let of_open = |state: &State| State { effects: at_places(state, &split.open), ..state.clone() };
    let of_locked = |state: &State| State { effects: at_places(state, &split.locked), ..state.clone() };
    let confirmed = confirm::on_locked(runs, &split, clean, base, &of_locked(&state), &problem, parameters);
    let sides = [(open_twin.residual(&start), 0), (open_twin.residual(&of_open(&state)), 1)];
    let [before, after] = sides.map(|(open, side)| split.in_order(&open, &confirmed.residuals[side]));
    let mut localisation = localise::cells(runs, &before);
    if verdict.stands() {
        localise::fill_after(runs, &mut localisation, &after);
    }
    let rival = |cause: &&Cause| Rival {
        candidate: scored[cause.best].way.candidate.clone(),
        state: of_open(&state_of(cause.best)),
    };
    let ties = match verdict {
        Verdict::Ambiguous => vec![names.iter().map(rival).collect()],
        _ => Vec::new(),
    };
    let mut ambiguous_with: Vec<String> = names.iter().skip(1).map(|cause| cause.id.clone()).collect();
    ambiguous_with.sort();
    Ok(Report {
        verdict,
        effects,
        ambiguous_with,
        not_testable,
        rounds: vec![round],
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
            lag,
            whitener: problem.noise.whitener.clone(),
            std_w: problem.noise.usual_w(),
            precision: precision(base, parameters, options.slack),
        }),
        likelihood: Some(Found { posterior, gate, predictive, notes }),
    })
}

/// What a state has of some runs, by their places among these.
fn at_places(state: &State, places: &[usize]) -> Vec<(Regressor, f64)> {
    let place_of = |run: usize| places.iter().position(|own| *own == run);
    let moved = |(regressor, coefficient): &(Regressor, f64)| {
        let regressor = match regressor {
            Regressor::Mass(run) => Regressor::Mass(place_of(*run)?),
            Regressor::InRun(run, term) => Regressor::InRun(place_of(*run)?, *term),
            Regressor::Switch(what, times) => {
                let own = places.iter().filter_map(|run| times.get(*run).copied());
                Regressor::Switch(*what, own.collect::<Vec<f64>>().into())
            }
            other => other.clone(),
        };
        Some((regressor, *coefficient))
    };
    state.effects.iter().filter_map(moved).collect()
}

/// The best few about their own sizes; the covariance of each that was asked.
fn bend<const N: usize>(
    posed: &Posed<'_, N>,
    scales: &Scales,
    scored: &mut [Scored],
) -> Vec<Option<DMatrix<f64>>> {
    let mut order: Vec<usize> = (0..scored.len()).collect();
    order.sort_by(|a, b| scored[*b].evidence.total_cmp(&scored[*a].evidence));
    let top = order.first().map_or(0.0, |best| scored[*best].evidence);
    let least = (top - NEAR.max(NEAR_SHARE * top)).max(0.0);
    let mut chosen: Vec<usize> = Vec::new();
    for place in order {
        let own = &scored[place];
        let same = chosen.iter().filter(|&&k| scored[k].way.candidate.id == own.way.candidate.id).count();
        // What a delay's slope says is next to nothing: it bends within a part of a period.
        let is_delay = own.way.candidate.regressors == [Regressor::Delay];
        if is_delay || own.evidence > least && chosen.len() < BENT && same < BENT_WAYS {
            chosen.push(place);
        }
    }
    let bent: Vec<_> = chosen
        .par_iter()
        .map(|&place| {
            let own = &scored[place];
            let start = match own.way.candidate.regressors[..] {
                [Regressor::Delay] => vec![relinearise::delay(posed, scales, own.way.candidate.range)],
                _ => own.coefficients.clone(),
            };
            let about = |start: &[f64]| relinearise::about(posed, scales, &own.way, start);
            // Where steps from there lead nowhere they may from none at all.
            (place, about(&start).or_else(|| about(&vec![0.0; start.len()])))
        })
        .collect();
    let mut covariances = vec![None; scored.len()];
    for (place, bent) in bent {
        let own = &mut scored[place];
        match bent {
            Some(bent) => {
                own.evidence = bent.evidence + own.searched;
                own.coefficients = bent.coefficients;
                covariances[place] = Some(bent.covariance);
            }
            None => own.evidence = f64::NEG_INFINITY,
        }
    }
    covariances
}

/// Every way with what it gains, the best first.
fn round(scored: &[Scored], posterior: &Posterior, names: &[&Cause], outcome: &str) -> Round {
    let mut candidates: Vec<types::Scored> = scored
        .iter()
        .enumerate()
        .map(|(place, own)| {
            let candidate = &own.way.candidate;
            let rank = names.iter().position(|cause| cause.id == candidate.id);
            let is_best = posterior.effects.iter().any(|cause| cause.best == place);
            types::Scored {
                id: candidate.id.clone(),
                detail: candidate.detail.clone(),
                gain: 2.0 * own.evidence,
                coefficients: own.coefficients.clone(),
                status: match rank {
                    Some(0) if is_best => Status::Winner,
                    Some(rank) if rank > 0 && is_best => Status::Tie,
                    _ if own.evidence == f64::NEG_INFINITY => Status::Implausible,
                    _ => Status::Worse,
                },
            }
        })
        .collect();
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let structure = candidates.first().map_or(0.0, |best| best.gain.max(0.0).sqrt());
    Round { structure, allowed: 0.0, candidates, outcome: outcome.to_owned() }
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
