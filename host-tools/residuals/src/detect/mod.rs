//! Whether the residual has structure, and which candidates show it.
pub mod over_dispersion;
mod scan;

use model::effects::{Candidate, Regressor};

use super::predictor::State;
use super::problem::Problem;
use super::types::{Scored, Status};

/// What the detector sees.
pub struct Structure {
    pub greatest: f64,
    /// Scores of all candidates, made linear at the state.
    pub scored: Vec<Scored>,
    /// Their places in the list with their gains, best first.
    pub order: Vec<(usize, f64)>,
    /// Of single runs and unknown times.
    pub further: Vec<Candidate>,
}

pub fn structure(problem: &Problem<'_>, state: &State, list: &[Candidate], named: &[Candidate]) -> Structure {
    let regressors: Vec<_> = list
        .iter()
        .flat_map(|candidate| candidate.regressors.iter().cloned())
        .filter(|regressor| state.effects.iter().all(|(present, _)| present != regressor))
        .collect();
    let empty =
        || Structure { greatest: f64::INFINITY, scored: Vec::new(), order: Vec::new(), further: Vec::new() };
    let Some(linear) = problem.linear(state, &regressors, &problem.smooth) else { return empty() };
    let null = linear.factored.loss();
    let (active, runs) = (problem.active(state), problem.predictor.runs);
    let mut greatest = 0.0_f64;
    for further in regressors.len()..linear.further() {
        if let Some(score) = linear.score(further) {
            greatest = greatest.max(score.z.abs());
        }
    }
    let mut scored = Vec::new();
    let mut order = Vec::new();
    for (place, candidate) in list.iter().enumerate() {
        if !may_stand_with(named, candidate) {
            continue;
        }
        let places: Vec<usize> = candidate
            .regressors
            .iter()
            .filter_map(|regressor| regressors.iter().position(|other| other == regressor))
            .collect();
        let scores: Vec<_> = places.iter().map(|&further| linear.score(further)).collect();
        let columns = active.clone().chain(places.iter().map(|&further| linear.place(further)));
        let solved = problem.factored(&linear.products, state, columns);
        let (mut gain, coefficients, status) = match solved {
            Some(solved) if scores.iter().any(Option::is_some) => {
                let values = solved.solution().iter().skip(problem.first_further(state)).copied().collect();
                (null - solved.loss() - problem.price(candidate), values, Status::NotNeeded)
            }
            _ => (0.0, Vec::new(), Status::Unidentifiable),
        };
        if let [Some(score)] = scores[..] {
            greatest = greatest.max(score.z.abs());
            // To first order a delay shows only where the power varies slowly against it. A delay
            // within a sample is an artefact of sampling.
            if candidate.regressors == [Regressor::Delay]
                && let Some(fit) = problem.fit_delay(state, candidate.range)
                && fit.state.effects.last().is_some_and(|(_, delay)| delay.abs() > runs.step.period_s())
            {
                gain = gain.max(null - fit.loss - problem.price(candidate));
                let inflation = problem.variance_inflation(state, &candidate.regressors, &fit.state);
                greatest = greatest.max((gain / inflation).max(0.0).sqrt());
            }
        }
        order.push((place, gain));
        let detail = candidate.detail.clone();
        scored.push(Scored { id: candidate.id.clone(), detail, gain, coefficients, status });
    }
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut further = Vec::new();
    for (candidate, z) in scan::candidates(problem, state) {
        if may_stand_with(named, &candidate) {
            greatest = greatest.max(z);
            further.push(candidate);
        }
    }
    Structure { greatest, scored, order, further }
}

/// Whether a candidate differs from the effects named, and no two of them change the half slip.
fn may_stand_with(named: &[Candidate], candidate: &Candidate) -> bool {
    let has_half_slip = |other: &Candidate| other.regressors.contains(&Regressor::HalfSlip);
    named.iter().all(|other| other.id != candidate.id && !(has_half_slip(other) && has_half_slip(candidate)))
}
