//! Candidates fitted with all that they bend, their shapes searched, and when two of them are no different.
use crate::effects::{Candidate, Detail, Regressor, Runs};
use crate::gap::problem::Problem;
use crate::gap::problem::fit::Fitted;
use crate::gap::thresholds::name::{IN_RUN_ERRORS, SEARCH_STEPS, SHARPENED, TIE, TIE_ERRORS, TIE_SHARE};
use crate::gap::twin::State;
use crate::gap::types::penalty;

/// A candidate with its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// What was added.
    pub candidate: Candidate,
    /// The fit with it.
    pub fitted: Fitted,
    /// Loss with what its search costs.
    pub penalised: f64,
}

impl Hypothesis {
    /// Coefficients of what was added.
    pub fn coefficients(&self) -> Vec<f64> {
        let effects = &self.fitted.state.effects;
        let from = effects.len() - self.candidate.regressors.len();
        effects[from..].iter().map(|(_, coefficient)| *coefficient).collect()
    }

    /// Whether sign and size of the coefficients are those that the effect can have. Of several columns only the size counts.
    pub fn is_plausible(&self) -> bool {
        let (low, high) = self.candidate.range;
        match self.coefficients()[..] {
            [only] => only >= low && only <= high,
            // Of single runs each is one of its own, of one run its own; the parts of a direction make up one.
            ref several if self.candidate.regressors.iter().all(|regressor| regressor.run().is_some()) => {
                several.iter().all(|c| *c >= low && *c <= high)
            }
            ref several => several.iter().map(|c| c * c).sum::<f64>().sqrt() <= high,
        }
    }
}

/// Fits a candidate; runs of it that turn out to show nothing are left to themselves.
pub(super) fn fit_hypothesis<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    candidate: &Candidate,
) -> Option<Hypothesis> {
    let fit = |candidate: &Candidate| {
        let zeros: Vec<_> = candidate.regressors.iter().map(|regressor| (regressor.clone(), 0.0)).collect();
        problem.fit(state, &zeros, 3)
    };
    let mut candidate = candidate.clone();
    let mut fitted = fit(&candidate)?;
    if candidate.regressors.iter().any(|regressor| regressor.run().is_some()) {
        let first = problem.first_further(state);
        let shows: Vec<bool> = (0..candidate.regressors.len())
            .map(|place| {
                let (_, coefficient) = fitted.state.effects[state.effects.len() + place];
                let error = fitted.covariance[(first + place, first + place)].max(0.0).sqrt();
                coefficient.abs() > IN_RUN_ERRORS * error
            })
            .collect();
        let all = shows.len();
        let kept = shows.iter().filter(|shows| **shows).count();
        if kept > 0 && kept < all {
            candidate.keep(&shows);
            candidate.search *= kept as f64 / all as f64;
            fitted = fit(&candidate)?;
        }
    }
    problem.sharpen_times(&mut fitted);
    let runs = problem.twin.runs.runs.iter().filter(|run| !run.clean).count();
    if let Some((regressor, _)) = fitted.state.effects.last()
        && let [own] = &mut candidate.regressors[..]
        && let (Regressor::Switch(..), Regressor::Switch(_, times)) = (&*own, regressor)
    {
        let at: Vec<_> = times.iter().take(runs).map(|at| at.is_finite().then_some(*at)).collect();
        candidate.detail = Detail::InRuns { runs: Runs::All, at_s: Some(at) };
        *own = regressor.clone();
    }
    let penalised = fitted.loss + penalty(&candidate);
    Some(Hypothesis { candidate, fitted, penalised })
}

/// Searches the shapes of the best hypotheses: widths, time constants and times between those of the dictionary.
pub(super) fn sharpen<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    hypotheses: &mut [Hypothesis],
) {
    let mut seen: Vec<String> = Vec::new();
    for hypothesis in hypotheses.iter_mut() {
        let [regressor] = &hypothesis.candidate.regressors[..] else { continue };
        let Some((mut low, mut high)) = regressor.interval() else { continue };
        if seen.len() >= SHARPENED || seen.contains(&hypothesis.candidate.id) {
            continue;
        }
        seen.push(hypothesis.candidate.id.clone());
        let coefficient = hypothesis.coefficients()[0];
        let regressor = regressor.clone();
        let mut best: Option<(f64, Fitted)> = None;
        for _ in 0..SEARCH_STEPS {
            let (left, right) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
            let at = |shape: f64| problem.fit(state, &[(regressor.with_shape(shape), coefficient)], 2);
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
            && fitted.loss < hypothesis.fitted.loss
        {
            hypothesis.candidate.set_shape(shape);
            hypothesis.penalised = fitted.loss + penalty(&hypothesis.candidate);
            hypothesis.fitted = fitted;
        }
    }
    hypotheses.sort_by(|a, b| a.penalised.total_cmp(&b.penalised));
}

/// Whether a hypothesis is not significantly worse.
pub(super) fn is_tie(winner: &Hypothesis, hypothesis: &Hypothesis, gain: f64) -> bool {
    let differences: Vec<f64> =
        hypothesis.fitted.run_losses.iter().zip(&winner.fitted.run_losses).map(|(r, w)| r - w).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    let error = (count * variance).sqrt();
    let worse = hypothesis.penalised - winner.penalised;
    worse < TIE + TIE_SHARE * gain && worse < TIE_ERRORS * error.max(1e-9)
}

/// Whether a candidate is no better than its own limit, see [`Regressor::limit`]: what makes it this effect does not show then. Where the
/// dictionary has the limit as an effect it is a hypothesis, and in a tie.
pub(super) fn shows_no_shape<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    winner: &Hypothesis,
    gain: f64,
) -> bool {
    let [regressor] = &winner.candidate.regressors[..] else { return false };
    let Some(limit) = regressor.limit() else { return false };
    let candidate = Candidate { regressors: vec![limit], search: 0.0, ..winner.candidate.clone() };
    fit_hypothesis(problem, state, &candidate).is_some_and(|limit| is_tie(winner, &limit, gain))
}
