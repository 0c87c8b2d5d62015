//! Every cause beside what is known already, weighed.

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};
use rayon::prelude::*;

use super::posterior;
use super::priors::{BENT, BENT_WAYS, NEAR, NEAR_SHARE};
use super::products::Posed;
use super::relinearise::{self, Bent};
use super::scored::{self, Scales, Scored};
use residuals::predictor::Predictor;
use residuals::types::Base;

/// What is asked of some runs.
pub struct Asked<'a> {
    /// Clean and field runs with the model.
    pub predictor: Predictor<'a>,
    /// The same runs, all of which may have effects.
    pub free: &'a Runs,
    /// The base, and how many of its parameters are in question.
    pub base: (&'a Base, usize),
    /// Effects that may show.
    pub list: &'a [Candidate],
    /// Ids of steps and masses that are not asked for.
    pub removed: &'a [String],
    /// Of the gate.
    pub level: f64,
}

/// An effect that was named, with its coefficients.
pub type Known = (Candidate, Vec<f64>);

impl<'a> Asked<'a> {
    /// Columns and sums beside what is known; `None` where too few rows tell of the noise.
    pub fn posed(&self, known: &[Known]) -> Option<Posed<'a>> {
        let is_known = |id: &str| known.iter().any(|(candidate, _)| candidate.id == id);
        let list: Vec<Candidate> = self.list.iter().filter(|effect| !is_known(&effect.id)).cloned().collect();
        let of = |(effect, coefficients): &Known| {
            effect.regressors.iter().cloned().zip(coefficients.iter().copied()).collect::<Vec<_>>()
        };
        let effects: Vec<(Regressor, f64)> = known.iter().flat_map(of).collect();
        let removed = self.removed_beside(known);
        Posed::new(self.predictor, self.free, self.base, &list, &removed, &effects)
    }

    fn removed_beside(&self, known: &[Known]) -> Vec<String> {
        let known = known.iter().map(|(effect, _)| effect.id.clone());
        self.removed.iter().cloned().chain(known).collect()
    }

    /// Of every effect beside what is known, its id and how probable it is if it is one of them, the
    /// likeliest first; `None` where too few rows tell of the noise.
    pub fn among_effects(&self, known: &[Known]) -> Option<Vec<(String, f64)>> {
        let posed = self.posed(known)?;
        let scales = Scales::told(&posed)?;
        let mut scored = scored::ways(&posed, &scales);
        scored.extend(scored::of_single_runs(&posed, &scales, &self.removed_beside(known)));
        bend(&posed, &scales, &mut scored);
        let field = (0..posed.runs.len()).filter(|&run| posed.is_field(run)).count();
        Some(posterior::among_effects(&scored, field))
    }
}

/// Scores the best few anew, about their own sizes. A way that bends loses evidence: another of the
/// same cause may then lead, and is scored in turn.
fn bend(posed: &Posed<'_>, scales: &Scales, scored: &mut [Scored]) {
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
                }
                None => hypothesis.evidence = f64::NEG_INFINITY,
            }
        }
        chosen = leading(scored).filter(|&k| !is_asked[k] && scored[k].evidence > least).collect();
    }
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
