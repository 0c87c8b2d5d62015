//! Whether there is structure in what is left, and which candidates see it.
pub mod over_dispersion;
mod scan;
mod shape_test;

use super::problem::Problem;
use super::thresholds::detect::MORE_LOOKS;
use super::twin::State;
use super::types::{Scored, Status, penalty};
use crate::effects::Candidate;
use crate::gap::problem::solve::solve;

/// What the detector sees.
pub(super) struct Structure {
    pub(super) greatest: f64,
    /// Scores of all candidates, made linear at the state.
    pub(super) scored: Vec<Scored>,
    /// Their places in the list with their gains, best first.
    pub(super) order: Vec<(usize, f64)>,
    /// Of single runs and unknown times.
    pub(super) further: Vec<Candidate>,
}

pub(super) fn structure<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    list: &[Candidate],
    named: &[Candidate],
) -> Structure {
    let regressors: Vec<_> = list
        .iter()
        .flat_map(|candidate| candidate.regressors.iter().cloned())
        .filter(|regressor| state.effects.iter().all(|(own, _)| own != regressor))
        .collect();
    let panel = problem.panel(state, &regressors, true);
    let total = panel.products().total(None);
    let base = problem.base;
    let active = problem.active(state);
    let first = problem.first_further(state);
    let offset = problem.offset(state);
    let alone = solve(&total, base, &problem.prior, &offset, &active);
    let null = alone.as_ref().map_or(f64::INFINITY, |solved| solved.loss);
    let mut greatest = 0.0_f64;
    let smooth_from = first + regressors.len();
    for column in smooth_from..total.ncols() - 1 {
        if let Some(score) = problem.score(&panel, &total, state, &active, column) {
            greatest = greatest.max(score.z.abs());
        }
    }
    let mut scored = Vec::new();
    let mut order = Vec::new();
    for (place, candidate) in list.iter().enumerate() {
        if named.iter().any(|own| own.id == candidate.id) {
            continue;
        }
        let own: Vec<usize> = candidate
            .regressors
            .iter()
            .filter_map(|regressor| regressors.iter().position(|other| other == regressor))
            .map(|at| first + at)
            .collect();
        let scores: Vec<_> =
            own.iter().map(|&column| problem.score(&panel, &total, state, &active, column)).collect();
        let all: Vec<usize> = active.iter().chain(&own).copied().collect();
        let solved = solve(&total, base, &problem.prior, &offset, &all);
        let (gain, coefficients, status) = match solved {
            Some(solved) if scores.iter().any(Option::is_some) => {
                let values: Vec<f64> = solved.values.iter().skip(base + active.len()).copied().collect();
                (null - solved.loss - penalty(candidate), values, Status::NotNeeded)
            }
            _ => (0.0, Vec::new(), Status::Unidentifiable),
        };
        if let [Some(score)] = scores[..] {
            greatest = greatest.max(score.z.abs());
        }
        order.push((place, gain));
        let detail = candidate.detail.clone();
        scored.push(Scored { id: candidate.id.clone(), detail, gain, coefficients, status });
    }
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut further = Vec::new();
    for (candidate, z) in scan::candidates(problem, state) {
        if named.iter().all(|own| own.id != candidate.id) {
            // More times and runs were looked at than smooth functions: their scores count for less.
            greatest = greatest.max(z - MORE_LOOKS);
            further.push(candidate);
        }
    }
    Structure { greatest, scored, order, further }
}

/// Greatest |z| of the effects' own columns times something else; 0 without effects.
pub(super) fn shape_test<const N: usize>(problem: &Problem<'_, N>, state: &State) -> f64 {
    let signals = shape_test::deformations(problem, state);
    let panel = problem.panel_with(state, &[], &signals);
    let total = panel.products().total(None);
    let (first, active) = (problem.first_further(state), problem.active(state));
    (first..first + signals.len())
        .filter_map(|column| problem.score(&panel, &total, state, &active, column))
        .fold(0.0, |most, score| most.max(score.z.abs()))
}
