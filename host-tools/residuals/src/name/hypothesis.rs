//! Hypotheses: candidates with their non-linear fits, the search for their shapes, and ties.
use model::effects::{Candidate, Detail, Regressor, Runs};
use numerics::intervals::mean_interval;
use numerics::robust::ONE_SIDED_95;
use numerics::search::golden_section;

use crate::predictor::State;
use crate::problem::Problem;
use crate::problem::fit::Fitted;
use crate::problem::times::cost_of_a_time;
use crate::thresholds::detect::{INEXACT, NO_DIFFERENCE};
use crate::thresholds::name::{SEARCH_TOLERANCE, SHARPENED};
use crate::thresholds::problem::MOST_FIT_STEPS;

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

    /// Whether sign and size of the coefficients are those that the effect can have. Of several
    /// columns only the size counts.
    pub fn is_plausible(&self) -> bool {
        let (low, high) = self.candidate.range;
        match self.coefficients()[..] {
            [only] if self.candidate.least.is_empty() => only >= low && only <= high,
            // Effects of single runs are judged run by run, components of a direction by their
            // length.
            _ if self.lives_in_single_runs() => self.plausible_runs().into_iter().all(|plausible| plausible),
            [size, with] if let Some((least, most)) = self.candidate.regressors[1].range() => {
                (low..=high).contains(&size) && (least..=most).contains(&with)
            }
            ref several => several.iter().map(|c| c * c).sum::<f64>().sqrt() <= high,
        }
    }
}

impl Hypothesis {
    fn lives_in_single_runs(&self) -> bool {
        self.candidate.regressors.iter().all(|regressor| regressor.run().is_some())
    }

    /// Of an effect of single runs, whether the coefficient of each is one that it can have there.
    fn plausible_runs(&self) -> Vec<bool> {
        let (low, high) = self.candidate.range;
        let least = |place: usize| self.candidate.least.get(place).map_or(low, |least| least.max(low));
        let coefficients = self.coefficients().into_iter().enumerate();
        coefficients.map(|(place, c)| c >= least(place) && c <= high).collect()
    }

    /// An implausible hypothesis of single runs, without the runs in which it is implausible. An
    /// impossible mass may be a model error of one run; others may still be noted wrongly.
    pub(super) fn without_implausible_runs(&self, problem: &Problem<'_>, state: &State) -> Option<Self> {
        if !self.lives_in_single_runs() {
            return None;
        }
        let kept = self.plausible_runs();
        let count = kept.iter().filter(|kept| **kept).count();
        if count == 0 || count == kept.len() {
            return None;
        }
        fit_hypothesis(problem, state, &kept_of(&self.candidate, &kept))
    }
}

/// A candidate of single runs, kept in some of them; its search costs less accordingly.
fn kept_of(candidate: &Candidate, kept: &[bool]) -> Candidate {
    let mut candidate = candidate.clone();
    candidate.search *= kept.iter().filter(|kept| **kept).count() as f64 / kept.len() as f64;
    candidate.keep(kept);
    candidate
}

/// Fits a candidate, without those of its runs that show nothing.
pub(super) fn fit_hypothesis(
    problem: &Problem<'_>,
    state: &State,
    candidate: &Candidate,
) -> Option<Hypothesis> {
    let fit = |candidate: &Candidate| {
        if candidate.regressors == [Regressor::Delay] {
            return problem.fit_delay(state, candidate.range);
        }
        let zeros: Vec<_> = candidate.regressors.iter().map(|regressor| (regressor.clone(), 0.0)).collect();
        problem.fit(state, &zeros, MOST_FIT_STEPS)
    };
    let mut candidate = candidate.clone();
    let mut fitted = fit(&candidate)?;
    if candidate.regressors.iter().any(|regressor| regressor.run().is_some()) {
        let first = problem.first_further(state);
        let shows: Vec<bool> = (0..candidate.regressors.len())
            .map(|place| {
                let (_, coefficient) = fitted.state.effects[state.effects.len() + place];
                let error = fitted.covariance[(first + place, first + place)].max(0.0).sqrt();
                coefficient.abs() > NO_DIFFERENCE * error
            })
            .collect();
        let all = shows.len();
        let kept = shows.iter().filter(|shows| **shows).count();
        if kept > 0 && kept < all {
            candidate = kept_of(&candidate, &shows);
            fitted = fit(&candidate)?;
        }
    }
    problem.sharpen_times(&mut fitted);
    let runs = problem.predictor.runs.runs.iter().filter(|run| !run.clean).count();
    if let Some((regressor, _)) = fitted.state.effects.last()
        && let [searched] = &mut candidate.regressors[..]
        && let (Regressor::Switch(..), Regressor::Switch(_, times)) = (&*searched, regressor)
    {
        let at: Vec<_> = times.iter().take(runs).map(|at| at.is_finite().then_some(*at)).collect();
        candidate.search = cost_of_a_time(runs) * at.iter().flatten().count() as f64;
        candidate.detail = Detail::InRuns { runs: Runs::All, at_s: Some(at) };
        *searched = regressor.clone();
    }
    let penalised = problem.loss_as_delay(state, &fitted) + problem.price(&candidate);
    Some(Hypothesis { candidate, fitted, penalised })
}

/// Searches the shapes of the best hypotheses: widths, time constants and times between those of
/// the dictionary.
pub(super) fn sharpen(problem: &Problem<'_>, state: &State, hypotheses: &mut [Hypothesis]) {
    let mut seen: Vec<String> = Vec::new();
    for hypothesis in hypotheses.iter_mut() {
        let [regressor] = &hypothesis.candidate.regressors[..] else { continue };
        let Some((low, high)) = regressor.interval() else { continue };
        if seen.len() >= SHARPENED || seen.contains(&hypothesis.candidate.id) {
            continue;
        }
        seen.push(hypothesis.candidate.id.clone());
        let coefficient = hypothesis.coefficients()[0];
        let regressor = regressor.clone();
        let mut best: Option<(f64, Fitted)> = None;
        golden_section(low, high, SEARCH_TOLERANCE, |shape| {
            let tried = problem.fit(state, &[(regressor.with_shape(shape), coefficient)], 2);
            let loss = tried.as_ref().map_or(f64::INFINITY, |tried| tried.loss);
            if let Some(tried) = tried
                && best.as_ref().is_none_or(|(_, best)| tried.loss < best.loss)
            {
                best = Some((shape, tried));
            }
            loss
        });
        if let Some((shape, fitted)) = best
            && fitted.loss < hypothesis.fitted.loss
        {
            hypothesis.candidate.set_shape(shape);
            hypothesis.penalised = fitted.loss + problem.price(&hypothesis.candidate);
            hypothesis.fitted = fitted;
        }
    }
    hypotheses.sort_by(|a, b| a.penalised.total_cmp(&b.penalised));
}

/// Difference in χ² up to which a hypothesis ties. It grows with the variance by which runs
/// [`disagree`] about the winner, or clean runs about anything. A [share](INEXACT) of the gain
/// comes on top: no term of the model is exact.
pub(super) fn tie_width(gain: f64, disagreement: f64, misfit: f64) -> f64 {
    NO_DIFFERENCE.powi(2) * disagreement.max(misfit) + INEXACT * gain
}

/// Whether a hypothesis is not significantly worse: by less than a [width](tie_width), and by less
/// than runs differ about it.
pub(super) fn is_tie(winner: &Hypothesis, hypothesis: &Hypothesis, width: f64) -> bool {
    let differences: Vec<f64> =
        hypothesis.fitted.run_losses.iter().zip(&winner.fitted.run_losses).map(|(r, w)| r - w).collect();
    let error = mean_interval(&differences).std_err().unwrap_or(0.0) * differences.len() as f64;
    let worse = hypothesis.penalised - winner.penalised;
    worse < width && worse < ONE_SIDED_95 * error.max(1e-9)
}

/// Rivals of other effects that are no worse than a winner, and better than nothing.
pub(super) fn as_good<'a>(
    null: &Fitted,
    winner: &Hypothesis,
    rivals: &[&'a Hypothesis],
    width: f64,
) -> Vec<&'a Hypothesis> {
    let is_as_good = |rival: &&&Hypothesis| {
        rival.candidate.id != winner.candidate.id
            && is_tie(winner, rival, width)
            && null.loss - rival.penalised > 0.0
    };
    rivals.iter().filter(is_as_good).copied().collect()
}

/// Variance between runs of what a hypothesis adds, relative to that of the equations. 1 for
/// effects of single runs: no other run could agree.
pub(super) fn disagree(problem: &Problem<'_>, hypothesis: &Hypothesis) -> f64 {
    let regressors = &hypothesis.candidate.regressors;
    if regressors.iter().any(|regressor| regressor.run().is_some()) {
        return 1.0;
    }
    problem.disagreement(&hypothesis.fitted, regressors.len())
}

/// The best hypothesis, if it is implausible and beats the best plausible one of another effect by
/// more than the [width of a tie](tie_width) of runs that agree. `hypotheses` are sorted, the best
/// first.
pub(super) fn implausible_and_better(hypotheses: &[Hypothesis], null_loss: f64) -> Option<&Hypothesis> {
    let first = hypotheses.first().filter(|first| !first.is_plausible())?;
    let winner = hypotheses.iter().find(|hypothesis| hypothesis.is_plausible())?;
    let worse = winner.penalised - first.penalised;
    let gain = null_loss - winner.penalised;
    (first.candidate.id != winner.candidate.id && worse > tie_width(gain, 1.0, 1.0)).then_some(first)
}

/// Whether a winner is no better than the limit of its shape, see [`Regressor::limit`]: its own
/// shape does not show then. A limit that is in the dictionary is a hypothesis, and in a tie.
pub(super) fn shows_no_shape(problem: &Problem<'_>, state: &State, winner: &Hypothesis, width: f64) -> bool {
    let [regressor] = &winner.candidate.regressors[..] else { return false };
    let Some(limit) = regressor.limit() else { return false };
    let candidate = Candidate { regressors: vec![limit], search: 0.0, ..winner.candidate.clone() };
    fit_hypothesis(problem, state, &candidate).is_some_and(|limit| is_tie(winner, &limit, width))
}

#[cfg(test)]
mod tests {
    use model_core::effects::Term;
    use model_core::torque::{Drive, TorqueModel};
    use nalgebra::DMatrix;

    use super::*;
    use crate::late::with_power;
    use crate::predictor::Predictor;
    use crate::problem::example;
    use crate::problem::panel::Products;

    /// An effect with a loss, and a coefficient within its range of 0 to 1 or not.
    fn hypothesis(id: &str, loss: f64, coefficient: f64) -> Hypothesis {
        let regressor = Regressor::Term(Term::Rolling);
        let torque = TorqueModel::from_array([0.01; 7]);
        Hypothesis {
            candidate: example::candidate(id, vec![regressor.clone()], (0.0, 1.0)),
            fitted: Fitted {
                state: State { torque, effects: vec![(regressor, coefficient)] },
                loss,
                run_losses: Vec::new(),
                products: Products { runs: Vec::new() },
                covariance: DMatrix::zeros(0, 0),
            },
            penalised: loss,
        }
    }

    /// 60 behind in χ² of 400 with a run-level scatter that hides it: no tie where the equations'
    /// error is right (9 + 1 % of 400 = 13), one where runs disagree ten times as much (90 + 4).
    #[test]
    fn a_tie_is_as_wide_as_runs_disagree() {
        let runs = |losses: [f64; 4]| {
            let total = losses.iter().sum();
            let mut rival = hypothesis("effect", total, 0.5);
            rival.fitted.run_losses = losses.into();
            rival
        };
        let (winner, rival) = (runs([100.0; 4]), runs([20.0, 250.0, 30.0, 160.0]));
        let width = |disagreement| tie_width(400.0, disagreement, 1.0);
        assert!(!is_tie(&winner, &rival, width(1.0)));
        assert!(is_tie(&winner, &rival, width(10.0)));
        // What every run says is said, however they scatter about the size.
        assert!(!is_tie(&winner, &runs([115.0; 4]), width(10.0)));
    }

    /// Gains of 2184 and 2126, as a Husky on another floor had them: the next best name was a wrong
    /// one. A tie would be within 9 + 1 % of 2126 = 30.
    #[test]
    fn the_next_best_takes_no_name_that_an_implausible_one_explains_better() {
        let null = 10_000.0;
        let next = hypothesis("wheel-drag", null - 2126.0, 0.5);
        let better = |gain: f64, coefficient: f64, id: &str| {
            let all = [hypothesis(id, null - gain, coefficient), next.clone()];
            implausible_and_better(&all, null).map(|first| first.candidate.id.clone())
        };
        assert_eq!(
            better(2184.0, 1.5, "rolling-resistance-change"),
            Some("rolling-resistance-change".to_owned())
        );
        // Within a tie; plausible; another way of the same effect.
        assert_eq!(better(2150.0, 1.5, "rolling-resistance-change"), None);
        assert_eq!(better(2184.0, 0.9, "rolling-resistance-change"), None);
        assert_eq!(better(2184.0, 1.5, "wheel-drag"), None);
    }

    /// Of two runs noted with 1.4 and 5 kg on a robot of 1 kg the second may be 2 kg lighter, the
    /// first may not.
    #[test]
    fn a_mass_is_plausible_by_what_its_own_run_noted() {
        let of = |shifts: [f64; 2]| {
            let mut wrong = hypothesis("payload-mislabel", 0.0, 0.5);
            wrong.candidate.regressors = vec![Regressor::Mass(0), Regressor::Mass(1)];
            wrong.candidate.range = (-5.0, 5.0);
            wrong.candidate.least = vec![-0.4, -4.0];
            let effects = wrong.candidate.regressors.iter().cloned().zip(shifts);
            wrong.fitted.state.effects = effects.collect();
            wrong
        };
        assert!(of([2.0, -2.0]).is_plausible());
        assert!(!of([-2.0, 2.0]).is_plausible());
        let mut second = of([-2.0, -2.0]);
        second.candidate.keep(&[false, true]);
        second.fitted.state.effects.remove(0);
        assert!(second.is_plausible());
    }

    /// Runs noted with 1 and 4 kg whose power is that of 0.5 and 2.4 kg: a robot of 1 kg is never
    /// as light as the first, but the second is wrong. Where clean runs show twice the variance of
    /// noise, that costs twice as much.
    #[test]
    fn a_mass_that_no_robot_has_leaves_the_others() {
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let masses = [Regressor::Mass(0), Regressor::Mass(1)];
        let truth = State { torque, effects: masses.iter().cloned().zip([-0.5, -1.6]).collect() };
        let runs = example::simulated(&example::runs([5.0, 7.0]), Drive::Dissipative, |_| truth.clone());
        let predictor = Predictor::new(&runs, Drive::Dissipative);
        let mut problem = example::bare(predictor, torque, 0);
        let state = State { torque, effects: Vec::new() };
        let candidate = Candidate {
            regressors: masses.into(),
            range: (-4.0, 4.0),
            least: vec![-0.1, -3.1],
            search: 20.0,
            ..hypothesis("payload-mislabel", 0.0, 0.0).candidate
        };
        let both = fit_hypothesis(&problem, &state, &candidate).unwrap();
        assert!(!both.is_plausible(), "{:?}", both.coefficients());
        let rest = both.without_implausible_runs(&problem, &state).unwrap();
        assert!(rest.is_plausible() && rest.candidate.regressors == [Regressor::Mass(1)]);
        assert!((rest.coefficients()[0] + 1.6).abs() < 1e-3, "{:?}", rest.coefficients());
        assert!((rest.penalised - rest.fitted.loss - 10.0).abs() < 1e-9);
        assert!(rest.without_implausible_runs(&problem, &state).is_none());
        problem.misfit = 2.0;
        let dearer = fit_hypothesis(&problem, &state, &rest.candidate).unwrap();
        assert!((dearer.penalised - dearer.fitted.loss - 20.0).abs() < 1e-9);
    }

    /// Runs whose power is the predictor's, late by `delay`, s, and passed through `sensor`.
    fn late(torque: TorqueModel<f64>, delay: f64, sensor: impl Fn(&[f64]) -> Vec<f64>) -> logs::runs::Runs {
        let runs = example::runs([5.0, 7.0]);
        let state = State { torque, effects: vec![(Regressor::Delay, delay)] };
        let predictor = Predictor::new(&runs, Drive::Regenerative);
        let powers = (0..runs.runs.len()).map(|run| sensor(&predictor.predict(run, &state)));
        with_power(&runs, powers.collect())
    }

    /// A delay fitted to runs of [`late`], and what it gains: as it counts, and in χ².
    fn delay_of(runs: &logs::runs::Runs, torque: TorqueModel<f64>) -> (f64, [f64; 2]) {
        let predictor = Predictor::new(runs, Drive::Regenerative);
        let problem = example::bare(predictor, torque, 0);
        let mut candidate = hypothesis("sensor-delay", 0.0, 0.0).candidate;
        candidate.regressors = vec![Regressor::Delay];
        candidate.range = (-1.0, 1.0);
        let none = State { torque, effects: Vec::new() };
        let null = problem.fit(&none, &[], MOST_FIT_STEPS).unwrap().loss;
        let late = fit_hypothesis(&problem, &none, &candidate).unwrap();
        let counts = null - (late.penalised - problem.price(&candidate));
        (late.coefficients()[0], [counts, null - late.fitted.loss])
    }

    /// Behind a filter of 2 Hz a quarter of a period is 0.125 s. Power that is 0.4 s late is found
    /// there, though its slope at no delay leads elsewhere; power that is in time is not late.
    #[test]
    fn a_delay_of_more_than_a_quarter_period_is_found() {
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let fitted = |delay: f64| delay_of(&late(torque, delay, <[f64]>::to_vec), torque).0;
        for delay in [0.4, 0.14, -0.22] {
            assert!((fitted(delay) - delay).abs() < 1e-3, "{delay}: {}", fitted(delay));
        }
        assert!(fitted(0.0).abs() < 1e-3, "{}", fitted(0.0));
    }

    /// A sensor with a little of the rows beside each makes no delay worth a name, though one of
    /// part of a row explains some of it. Of what is late by less than a row, and smoothed as far
    /// as that takes interpolation, most counts.
    #[test]
    fn what_is_smoothed_is_not_late() {
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let smoothed = |powers: &[f64]| -> Vec<f64> {
            let row = |k: usize| powers[k.min(powers.len() - 1)];
            (0..powers.len()).map(|k| (row(k.saturating_sub(1)) + 6.0 * row(k) + row(k + 1)) / 8.0).collect()
        };
        let (delay, [counts, gain]) = delay_of(&late(torque, 0.002, smoothed), torque);
        assert!(delay.abs() > 0.01 && counts < 0.3 * gain, "{delay} s: {counts} of {gain}");
        let (delay, [counts, gain]) = delay_of(&late(torque, 0.02, <[f64]>::to_vec), torque);
        assert!((delay - 0.02).abs() < 1e-3 && counts > 0.6 * gain, "{delay} s: {counts} of {gain}");
    }
}
