//! One round: every cause beside what is known already.

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};
use nalgebra::DMatrix;
use numerics::intervals::{MeanInterval, mean_interval};
use rayon::prelude::*;

use super::gate::Gate;
use super::posterior::{Cause, Posterior};
use super::priors::{BENT, BENT_WAYS, NEAR, NEAR_SHARE};
use super::products::Posed;
use super::relinearise::Bent;
use super::scored::{Scales, Scored};
use super::ways::Way;
use super::{posterior, relinearise, scored};
use residuals::predictor::{Predictor, State};
use residuals::types::{self, Base, Options, Status, Verdict};

/// What is asked of some runs, round after round.
pub struct Asked<'a> {
    /// Clean and field runs with the model.
    pub predictor: Predictor<'a>,
    /// The same runs, all of which may have effects.
    pub free: &'a Runs,
    /// The base, and how many of its parameters are in question.
    pub base: (&'a Base, usize),
    /// As the user set them.
    pub options: &'a Options,
    /// Effects that may show.
    pub list: &'a [Candidate],
    /// Ids of steps and masses that are not asked for.
    pub removed: &'a [String],
    /// Of the gate.
    pub level: f64,
}

/// An effect that was named, with its coefficients.
pub type Known = (Candidate, Vec<f64>);

/// Every effect beside what is known, weighed.
pub struct Weighed<'a> {
    posed: Posed<'a>,
    scales: Scales,
    scored: Vec<Scored>,
    covariances: Vec<Option<DMatrix<f64>>>,
}

impl Weighed<'_> {
    /// Of nothing new, something else and every effect.
    fn posterior(&self) -> Posterior {
        Posterior::of(&self.scored, &scored::something_else(&self.posed, &self.scales))
    }

    /// Of every effect, if it is one of them.
    pub fn among_effects(&self) -> Vec<(String, f64)> {
        let field = (0..self.posed.runs.len()).filter(|&run| self.posed.is_field(run)).count();
        posterior::among_effects(&self.scored, field)
    }
}

/// What a round says.
pub struct Round<'a> {
    weighed: Weighed<'a>,
    /// Every cause.
    pub posterior: Posterior,
    /// The verdict of this round alone.
    pub verdict: Verdict,
    /// Causes that are named: several are a tie.
    pub names: Vec<Cause>,
    /// Relabelled runs, where they were asked.
    pub gate: Option<Gate>,
    /// What is less sure than it might be, and why.
    pub note: Option<String>,
    outcome: &'static str,
}

impl<'a> Asked<'a> {
    /// Columns and sums beside what is known; `None` where too few rows tell of the noise.
    pub fn posed(&self, known: &[Known]) -> Option<Posed<'a>> {
        let is_known = |id: &str| known.iter().any(|(candidate, _)| candidate.id == id);
        let list: Vec<Candidate> = self.list.iter().filter(|effect| !is_known(&effect.id)).cloned().collect();
        let effects = state_of(self.base.0, known).effects;
        let (slack, removed) = (self.options.slack, self.removed_beside(known));
        Posed::new(self.predictor, self.free, self.base, slack, &list, &removed, &effects)
    }

    fn removed_beside(&self, known: &[Known]) -> Vec<String> {
        let known = known.iter().map(|(effect, _)| effect.id.clone());
        self.removed.iter().cloned().chain(known).collect()
    }

    /// Weighs every effect beside what is known; `None` where too few rows tell of the noise.
    pub fn weighed(&self, known: &[Known]) -> Option<Weighed<'a>> {
        let removed = self.removed_beside(known);
        let posed = self.posed(known)?;
        let scales = Scales::told(&posed)?;
        let mut scored = scored::ways(&posed, &scales);
        scored.extend(scored::of_single_runs(&posed, &scales, &removed));
        let covariances = bend(&posed, &scales, &mut scored);
        Some(Weighed { posed, scales, scored, covariances })
    }

    /// Asks beside what is known; `None` where too few rows tell of the noise.
    pub fn round(&self, known: &[Known]) -> Option<Round<'a>> {
        let weighed = self.weighed(known)?;
        let posterior = weighed.posterior();
        let Weighed { posed, scales, scored, covariances } = &weighed;
        let (mut verdict, names) = posterior.verdict();
        let mut names: Vec<Cause> = names.into_iter().cloned().collect();
        if names.first().is_some_and(|cause| covariances[cause.best].is_none()) {
            // Steps to its own size led nowhere: nothing is known of it.
            verdict = Verdict::Unexplained;
        }
        // Labels say nothing of what lives in single runs, or begins at times of their own.
        let in_single_runs = names.first().is_some_and(|cause| scored[cause.best].in_single_runs);
        let is_asked = verdict != Verdict::None && !in_single_runs;
        let bent = names
            .iter()
            .filter(|cause| covariances[cause.best].is_some() && !scored[cause.best].in_single_runs);
        let bent: Vec<_> =
            bent.map(|cause| (&scored[cause.best].way, &scored[cause.best].coefficients[..])).collect();
        let (gate, note) = match is_asked.then(|| Gate::of(posed, &bent, scales, self.level)) {
            Some(Ok(gate)) => (Some(gate), None),
            Some(Err(why)) => {
                (None, Some(format!("{why}: whether relabelled runs would show as much was not asked")))
            }
            None => (None, None),
        };
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
        if !verdict.stands() {
            names.clear();
        }
        Some(Round { weighed, posterior, verdict, names, gate, note, outcome })
    }
}

/// The base with effects.
pub fn state_of(base: &Base, known: &[Known]) -> State {
    let of = |(candidate, coefficients): &Known| {
        candidate.regressors.iter().cloned().zip(coefficients.iter().copied()).collect::<Vec<_>>()
    };
    State { torque: base.torque, effects: known.iter().flat_map(of).collect() }
}

impl Round<'_> {
    /// Each cause that is named, the likeliest first.
    pub fn named(&self) -> Vec<Known> {
        let of = |cause: &Cause| {
            let scored = &self.weighed.scored[cause.best];
            (scored.way.candidate.clone(), scored.coefficients.clone())
        };
        self.names.iter().map(of).collect()
    }

    /// How much likelier a field run is with the first name told of the others, nats; `None` where
    /// it lives in single runs, which tell of no other.
    pub fn predictive(&self) -> Option<MeanInterval> {
        let best = &self.weighed.scored[self.names.first()?.best];
        (!best.in_single_runs && !best.by_run.is_empty()).then(|| mean_interval(&best.by_run))
    }

    /// Several effects at once, each as it is beside the others, and their covariance.
    pub fn together(&self, known: &[Known]) -> Option<(Vec<Known>, DMatrix<f64>)> {
        if let [only] = known {
            let covariance = self.weighed.covariances[self.names.first()?.best].clone()?;
            return Some((vec![only.clone()], covariance));
        }
        let (first, _) = known.first()?;
        let effects = known.iter().flat_map(|(candidate, _)| candidate.regressors.iter().cloned());
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        let candidate =
            Candidate { regressors: effects.collect(), range: any, least: Vec::new(), ..first.clone() };
        let start: Vec<f64> = known.iter().flat_map(|(_, coefficients)| coefficients).copied().collect();
        let way = Way::about(&self.weighed.posed, &candidate, &start);
        let bent = relinearise::about(&self.weighed.posed, &self.weighed.scales, &way, &start)?;
        let mut remaining = bent.coefficients.into_iter();
        let with = |(candidate, coefficients): &Known| {
            (candidate.clone(), remaining.by_ref().take(coefficients.len()).collect())
        };
        Some((known.iter().map(with).collect(), bent.covariance))
    }

    /// Every way with what it gains, the best first.
    pub fn record(&self) -> types::Round {
        let status = |place: usize, scored: &Scored| {
            let rank = self.names.iter().position(|cause| cause.id == scored.way.candidate.id);
            let is_best = self.posterior.effects.iter().any(|cause| cause.best == place);
            match rank {
                Some(0) if is_best => Status::Winner,
                Some(rank) if rank > 0 && is_best => Status::Tie,
                _ if scored.evidence == f64::NEG_INFINITY => Status::Implausible,
                _ => Status::Worse,
            }
        };
        let of = |(place, scored): (usize, &Scored)| types::Scored {
            id: scored.way.candidate.id.clone(),
            detail: scored.way.candidate.detail.clone(),
            gain: 2.0 * scored.evidence,
            coefficients: scored.coefficients.clone(),
            status: status(place, scored),
        };
        let mut candidates: Vec<types::Scored> = self.weighed.scored.iter().enumerate().map(of).collect();
        candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let structure = candidates.first().map_or(0.0, |best| best.gain.max(0.0).sqrt());
        types::Round { structure, allowed: 0.0, candidates, outcome: self.outcome.to_owned() }
    }
}

/// Scores the best few anew, about their own sizes; the covariance of each of these. A way that
/// bends loses evidence: another of the same cause may then lead, and is scored in turn.
fn bend(posed: &Posed<'_>, scales: &Scales, scored: &mut [Scored]) -> Vec<Option<DMatrix<f64>>> {
    let mut order: Vec<usize> = (0..scored.len()).collect();
    order.sort_by(|a, b| scored[*b].evidence.total_cmp(&scored[*a].evidence));
    let top = order.first().map_or(0.0, |best| scored[*best].evidence);
    let least = (top - NEAR.max(NEAR_SHARE * top)).max(0.0);
    let mut chosen: Vec<usize> = Vec::new();
    for place in order {
        let candidate = &scored[place].way.candidate;
        let same = chosen.iter().filter(|&&k| scored[k].way.candidate.id == candidate.id).count();
        // A delay's slope says next to nothing: power bends within a fraction of a period.
        let is_delay = candidate.regressors == [Regressor::Delay];
        if is_delay || scored[place].evidence > least && chosen.len() < BENT && same < BENT_WAYS {
            chosen.push(place);
        }
    }
    let mut covariances = vec![None; scored.len()];
    let mut is_asked = vec![false; scored.len()];
    while !chosen.is_empty() {
        let about = |place: &usize| (*place, bent(posed, scales, &scored[*place]));
        let bent: Vec<_> = chosen.par_iter().map(about).collect();
        for (place, bent) in bent {
            let hypothesis = &mut scored[place];
            is_asked[place] = true;
            match bent {
                Some(bent) => {
                    hypothesis.evidence = bent.evidence + hypothesis.searched;
                    hypothesis.coefficients = bent.coefficients;
                    hypothesis.by_run = bent.by_run;
                    covariances[place] = Some(bent.covariance);
                }
                None => hypothesis.evidence = f64::NEG_INFINITY,
            }
        }
        chosen = leading(scored).filter(|&k| !is_asked[k] && scored[k].evidence > least).collect();
    }
    covariances
}

/// The best way of each cause.
fn leading(scored: &[Scored]) -> impl Iterator<Item = usize> {
    let leads = |a: &Scored, b: &Scored| a.way.candidate.id == b.way.candidate.id && a.evidence > b.evidence;
    (0..scored.len()).filter(move |&k| !scored.iter().any(|other| leads(other, &scored[k])))
}

/// One way about its own size.
fn bent(posed: &Posed<'_>, scales: &Scales, scored: &Scored) -> Option<Bent> {
    let start = match scored.way.candidate.regressors[..] {
        [Regressor::Delay] => vec![relinearise::delay(posed, scales, scored.way.candidate.range)],
        _ => scored.coefficients.clone(),
    };
    let about = |start: &[f64]| relinearise::about(posed, scales, &scored.way, start);
    // Where steps from there lead nowhere they may from none at all.
    about(&start).or_else(|| about(&vec![0.0; start.len()]))
}
