//! Candidates fitted with all that they bend, their shapes searched, and when two of them are no different.
use super::inquiry::{Fitted, Inquiry, Rival};
use super::twin::State;
use crate::effects::{Candidate, Regressor};
use serde_json::{Value, json};

/// Losses closer than this are no difference: χ² of three standard errors.
pub(super) const TIE_LOSS: f64 = 9.0;

/// What comes on top, as a share of the winner's gain: no term of the model is exact.
const TIE_SHARE: f64 = 0.01;

/// One-sided 95 % of a normal variable.
const TIE_ERRORS: f64 = 1.64;

/// What a candidate's search and its further columns cost, in χ².
pub(super) fn charge(candidate: &Candidate) -> f64 {
    let single = candidate.regressors.iter().any(|regressor| regressor.run().is_some());
    let further = candidate.regressors.len().saturating_sub(1) as f64;
    candidate.search + if single { 0.0 } else { 2.0 * further }
}

/// As [`charge`] when a run is left out: what it was searched for in that run costs nothing.
pub(super) fn charge_without(candidate: &Candidate, run: usize) -> f64 {
    let there = candidate.regressors.iter().filter(|regressor| regressor.run() == Some(run)).count() as f64;
    charge(candidate) * (1.0 - there / candidate.regressors.len().max(1) as f64)
}

/// Coefficients of single runs below this many standard errors are taken for none, when others of the candidate are not.
const LEAST_IN_RUN: f64 = 2.5;

/// Fits a candidate; runs of it that turn out to show nothing are left to themselves.
pub(super) fn fit_rival<const N: usize>(
    inquiry: &Inquiry<'_, N>,
    state: &State,
    candidate: &Candidate,
) -> Option<Rival> {
    let fit = |candidate: &Candidate| {
        let zeros: Vec<_> = candidate.regressors.iter().map(|regressor| (regressor.clone(), 0.0)).collect();
        inquiry.fit(state, &zeros, 3)
    };
    let mut candidate = candidate.clone();
    let mut fitted = fit(&candidate)?;
    if candidate.regressors.iter().any(|regressor| regressor.run().is_some()) {
        let first = inquiry.first_further(state);
        let shows: Vec<bool> = (0..candidate.regressors.len())
            .map(|place| {
                let (_, coefficient) = fitted.state.effects[state.effects.len() + place];
                let error = fitted.covariance[(first + place, first + place)].max(0.0).sqrt();
                coefficient.abs() > LEAST_IN_RUN * error
            })
            .collect();
        let all = shows.len();
        let kept = shows.iter().filter(|shows| **shows).count();
        if kept > 0 && kept < all {
            let mut shown = shows.iter();
            candidate.regressors.retain(|_| shown.next().copied().unwrap_or(true));
            for value in candidate.detail.values_mut() {
                if let Value::Array(entries) = value
                    && entries.len() == all
                {
                    let mut shown = shows.iter();
                    entries.retain(|_| shown.next().copied().unwrap_or(true));
                }
            }
            candidate.search *= kept as f64 / all as f64;
            fitted = fit(&candidate)?;
        }
    }
    inquiry.sharpen_times(&mut fitted);
    let runs = inquiry.twin.runs.runs.iter().filter(|run| !run.clean).count();
    if let Some((regressor, _)) = fitted.state.effects.last()
        && let [own] = &mut candidate.regressors[..]
        && let (Regressor::Switch(..), Regressor::Switch(_, times)) = (&*own, regressor)
    {
        let at: Vec<_> = times.iter().take(runs).map(|at| at.is_finite().then_some(at)).collect();
        candidate.detail.insert("at_s".to_owned(), json!(at));
        *own = regressor.clone();
    }
    let charged = fitted.loss + charge(&candidate);
    Some(Rival { candidate, fitted, charged })
}

/// Rivals whose shape is searched for between those of the dictionary.
const SHARPENED: usize = 3;

/// Steps of the search: each leaves two thirds of the interval.
const SEARCH_STEPS: usize = 5;

/// Searches the shapes of the best rivals: widths, time constants and times between those of the dictionary.
pub(super) fn sharpen<const N: usize>(inquiry: &Inquiry<'_, N>, state: &State, rivals: &mut [Rival]) {
    let mut seen: Vec<String> = Vec::new();
    for rival in rivals.iter_mut() {
        let ([regressor], Some(key)) = (&rival.candidate.regressors[..], rival.candidate.shape) else {
            continue;
        };
        let Some(shape) = regressor.shape() else { continue };
        if seen.len() >= SHARPENED || seen.contains(&rival.candidate.id) {
            continue;
        }
        seen.push(rival.candidate.id.clone());
        let coefficient = rival.coefficients()[0];
        let regressor = regressor.clone();
        // Times are known to their grid, the others to a factor of two.
        let (mut low, mut high) = match key {
            "at_s" => (shape - 1.5, shape + 1.5),
            "hold_s" => (0.5 * shape - 0.5, 2.0 * shape + 0.5),
            _ => (0.5 * shape, 2.0 * shape),
        };
        let mut best: Option<(f64, Fitted)> = None;
        for _ in 0..SEARCH_STEPS {
            let (left, right) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
            let at = |shape: f64| inquiry.fit(state, &[(regressor.with_shape(shape), coefficient)], 2);
            let (Some(at_left), Some(at_right)) = (at(left), at(right)) else { break };
            if at_left.loss < at_right.loss {
                high = right
            } else {
                low = left
            }
            for (shape, fitted) in [(left, at_left), (right, at_right)] {
                if best.as_ref().is_none_or(|(_, best)| fitted.loss < best.loss) {
                    best = Some((shape, fitted));
                }
            }
        }
        if let Some((shape, fitted)) = best
            && fitted.loss < rival.fitted.loss
        {
            rival.candidate.regressors = vec![regressor.with_shape(shape)];
            rival.candidate.detail.insert(key.to_owned(), json!(shape));
            rival.charged = fitted.loss + charge(&rival.candidate);
            rival.fitted = fitted;
        }
    }
    rivals.sort_by(|a, b| a.charged.total_cmp(&b.charged));
}

/// Whether a rival is not significantly worse.
pub(super) fn is_tie(winner: &Rival, rival: &Rival, gain: f64) -> bool {
    let differences: Vec<f64> =
        rival.fitted.run_losses.iter().zip(&winner.fitted.run_losses).map(|(r, w)| r - w).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    let error = (count * variance).sqrt();
    let worse = rival.charged - winner.charged;
    worse < TIE_LOSS + TIE_SHARE * gain && worse < TIE_ERRORS * error.max(1e-9)
}

/// Whether a candidate is no better than its own limit, see [`Regressor::limit`]: what makes it this effect does not show then. Where the
/// dictionary has the limit as an effect it is a rival, and in a tie.
pub(super) fn shows_no_shape<const N: usize>(
    inquiry: &Inquiry<'_, N>,
    state: &State,
    winner: &Rival,
    gain: f64,
) -> bool {
    let [regressor] = &winner.candidate.regressors[..] else { return false };
    let Some(limit) = regressor.limit() else { return false };
    let candidate =
        Candidate { regressors: vec![limit], search: 0.0, shape: None, ..winner.candidate.clone() };
    fit_rival(inquiry, state, &candidate).is_some_and(|limit| is_tie(winner, &limit, gain))
}
