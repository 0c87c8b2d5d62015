//! The gap on the locked runs, before and after.

use std::sync::Arc;

use logs::runs::Runs;
use model::effects::Regressor;
use model_core::torque::TorqueModel;
use numerics::intervals::{MeanInterval, mean_interval, student_95};
use numerics::robust::{NORMAL_95, ONE_SIDED_95};

use residuals::noise::whiten::Signal;
use residuals::noise::{Memory, Noise};
use residuals::predictor::{Predictor, State};
use residuals::problem::Problem;
use residuals::smooth;
use residuals::split::Split;
use residuals::thresholds::confirm::LEAST_CLOSED;
use residuals::thresholds::detect::MOST_TIMES;
use residuals::types::Base;

/// What the locked runs say.
#[derive(Debug, Clone, PartialEq)]
pub struct Confirmed {
    /// Names of the locked runs.
    pub runs: Vec<String>,
    /// RMS of measured less predicted power before, W.
    pub before_w: f64,
    /// After.
    pub after_w: f64,
    /// What no effect can remove, W: the residual of the locked runs without its smooth content,
    /// and the base's error on its own clean runs.
    pub floor_w: f64,
    /// The same before it was limited to `after_w`: above that, the estimate is too high, W.
    pub floor_unclipped_w: f64,
    /// RMS of measured less predicted power on the clean runs, W.
    pub clean_w: Option<f64>,
    /// How the floor was estimated, for users.
    pub floor_how: &'static str,
    /// Share of the gap that is closed; `None` without a gap, or where no locked run has the
    /// effect.
    pub closed: Option<f64>,
    /// How much of what was added the locked runs show. `None` as above, and where nothing was
    /// added.
    pub share: Option<ConfirmedShare>,
    /// Mean square before less after, W²: mean over the runs, with its 95 % interval.
    pub gain_w2: MeanInterval,
    /// Mean square before and after, run by run, W².
    pub by_run: Vec<(f64, f64)>,
    /// Measured less predicted power before and after, run by run, W.
    pub residuals: [Signal; 2],
}

/// How the noise floor is estimated with the clean runs of the base.
const FLOOR_WITH_CLEAN: &str = "RMS left on the locked runs when all that varies smoothly with the drive is regressed out, \
                                and what the base gets wrong on its own clean runs";

/// The same with a simulator.
const FLOOR_WITH_SIMULATOR: &str = "RMS left on the locked runs when all that varies smoothly with the drive is regressed out, \
                                    and what the base gets wrong of the simulator";

/// The same without.
const FLOOR_ALONE: &str = "RMS left on the locked runs when all that varies smoothly with the drive is regressed out; what \
                           the base gets wrong on clean runs is not known";

/// How much of the added effects the locked and clean runs alone show: 1 for all, 0 for nothing.
/// The base's error on any run is fitted, too, as it was for naming.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConfirmedShare {
    /// The share.
    pub share: f64,
    /// Its standard error.
    pub std_err: f64,
    /// Number of locked runs.
    pub runs: usize,
}

impl ConfirmedShare {
    /// 95 % interval: by Student's t over the runs; of one run by the scatter within it.
    pub fn interval(&self) -> (f64, f64) {
        let half = student_95(self.runs as f64 - 1.0).unwrap_or(NORMAL_95) * self.std_err;
        (self.share - half, self.share + half)
    }

    /// Less than half of it is there, or it might be none.
    fn is_missing(&self) -> bool {
        let too_small = self.share < LEAST_CLOSED && self.share + ONE_SIDED_95 * self.std_err < 1.0;
        too_small || self.interval().0 <= 0.0
    }

    /// From a problem of locked runs, then clean ones, and the residuals of the locked runs before
    /// and after.
    pub fn of(locked: &Problem<'_>, residuals: &[Signal; 2]) -> Option<Self> {
        let runs = &locked.predictor.runs.runs;
        let [before, after] = residuals;
        let added = (0..runs.len()).map(|place| match (before.get(place), after.get(place)) {
            (Some(before), Some(after)) if !runs[place].clean => {
                let added: Vec<f64> =
                    before.iter().zip(after).map(|(before, after)| before - after).collect();
                locked.noise.whiten(locked.predictor.runs, place, &added)
            }
            _ => vec![0.0; runs[place].rows.len()],
        });
        let start = locked.start();
        let linear = locked.linear(&start, &[], &[added.collect()])?;
        let score = linear.score(0)?;
        let count = runs.iter().filter(|run| !run.clean).count();
        Some(Self { share: score.value, std_err: score.std_err, runs: count })
    }
}

impl Confirmed {
    /// Whether the locked runs contradict the added effects, or do not surely show them. A known
    /// share decides: the base's error may be larger than the effect, and move single runs either
    /// way. But predictions that get worse on the whole confirm nothing, unless no locked run can
    /// have what was added.
    pub fn refuted(&self, in_single_runs: bool) -> bool {
        if !in_single_runs && self.gain_w2.mean < 0.0 {
            return true;
        }
        if let Some(share) = self.share {
            return share.is_missing() || self.gain_w2.mean <= 0.0;
        }
        let (shrunk, grown) = self.by_run.iter().fold((0, 0), |(shrunk, grown), (before, after)| {
            (shrunk + usize::from(after < before), grown + usize::from(after > before))
        });
        self.closed.is_some() && shrunk <= grown
    }

    /// Share of the excess over clean runs that is closed; `None` without clean runs or an excess.
    pub fn closed_to_clean(&self) -> Option<f64> {
        let [before, after] = [self.before_w, self.after_w].map(|gap| gap * gap);
        let open = before - self.clean_w?.powi(2);
        (open > 0.0).then(|| (before - after) / open)
    }
}

/// Predicts the locked runs before and after, from the fit to the open ones.
pub fn on_locked(
    runs: &Runs,
    split: &Split,
    clean: Option<&Runs>,
    base: &Base,
    state: &State,
    open: &Problem<'_>,
    parameters: usize,
) -> Confirmed {
    let locked = runs.subset(&split.locked);
    let predictor =
        Predictor { clean_delay: open.predictor.clean_delay, ..Predictor::new(&locked, base.drive) };
    let start = State { torque: base.torque, effects: Vec::new() };
    let before = predictor.residual(&start);
    // Effects of single runs were detected in open runs: no locked run has them.
    let common: Vec<(Regressor, f64)> =
        state.effects.iter().filter(|(regressor, _)| regressor.run().is_none()).cloned().collect();
    let common = with_run_times(&predictor, state.torque, common);
    let after = predictor.residual(&State { torque: state.torque, effects: common.clone() });
    let square = |run: &Vec<f64>| run.iter().map(|x| x * x).sum::<f64>() / run.len() as f64;
    let by_run: Vec<(f64, f64)> = before.iter().zip(&after).map(|(b, a)| (square(b), square(a))).collect();
    let rows = before.iter().map(Vec::len).sum::<usize>() as f64;
    let mean = |all: &[Vec<f64>]| all.iter().flatten().map(|x| x * x).sum::<f64>() / rows;
    let (before_w2, after_w2) = (mean(&before), mean(&after));
    let extended = State { torque: state.torque, effects: common.clone() };
    let noise = noise(&predictor, &extended, parameters, Memory::Known(&open.noise.whitener));
    let misfit = clean.map(|clean| Misfit::of(clean, base, predictor.clean_delay, parameters));
    // A simulator has no noise to multiply by the misfit: its misfit is added to the runs' noise.
    let floor_unclipped_w2 = match misfit {
        Some(misfit) if base.of_simulator => noise.floor_w2 + misfit.whole_w2,
        Some(misfit) => noise.floor_w2 * misfit.factor,
        None => noise.floor_w2,
    };
    let floor_w2 = floor_unclipped_w2.min(after_w2);
    let only_single = !state.effects.is_empty() && common.is_empty();
    let gap = before_w2 - floor_w2;
    let closed =
        (!state.effects.is_empty() && !only_single && gap > 0.0).then(|| (before_w2 - after_w2) / gap);
    let gains: Vec<f64> = by_run.iter().map(|(b, a)| b - a).collect();
    Confirmed {
        runs: locked.runs.iter().map(|run| run.name.clone()).collect(),
        before_w: before_w2.sqrt(),
        after_w: after_w2.sqrt(),
        floor_w: floor_w2.sqrt(),
        floor_unclipped_w: floor_unclipped_w2.sqrt(),
        clean_w: misfit.map(|misfit| misfit.whole_w2.sqrt()),
        floor_how: match clean {
            Some(_) if base.of_simulator => FLOOR_WITH_SIMULATOR,
            Some(_) => FLOOR_WITH_CLEAN,
            None => FLOOR_ALONE,
        },
        closed,
        share: None,
        gain_w2: mean_interval(&gains),
        by_run,
        residuals: [before, after],
    }
}

/// The noise about a state, which the smooth functions do not explain.
fn noise(predictor: &Predictor<'_>, state: &State, parameters: usize, memory: Memory<'_>) -> Noise {
    let functions = smooth::functions(predictor.runs);
    let regressors: Vec<Regressor> = state.effects.iter().map(|(regressor, _)| regressor.clone()).collect();
    let columns = (0..predictor.runs.runs.len()).map(|place| {
        let mut columns = predictor.columns(place, state, parameters, &regressors);
        let residual = columns.len() - 1;
        columns.splice(residual..residual, functions.iter().map(|function| function[place].clone()));
        columns
    });
    Noise::estimate(predictor.runs, &columns.collect::<Vec<_>>(), memory)
}

/// The base's error without any effect.
#[derive(Debug, Clone, Copy)]
struct Misfit {
    /// Mean square of the clean runs' residual, W².
    whole_w2: f64,
    /// The same relative to the residual without its smooth content; at least 1. No effect explains
    /// that.
    factor: f64,
}

impl Misfit {
    fn of(clean: &Runs, base: &Base, clean_delay: f64, parameters: usize) -> Self {
        let predictor = Predictor { clean_delay, ..Predictor::new(clean, base.drive) };
        let state = State { torque: base.torque, effects: Vec::new() };
        let residual = predictor.residual(&state);
        let rows = residual.iter().map(Vec::len).sum::<usize>() as f64;
        let whole_w2 = residual.iter().flatten().map(|x| x * x).sum::<f64>() / rows;
        let noise = noise(&predictor, &state, parameters, Memory::OfAll);
        let factor = if noise.floor_w2 > 0.0 { (whole_w2 / noise.floor_w2).max(1.0) } else { 1.0 };
        Self { whole_w2, factor }
    }
}

/// Each run has its own time of a step: it is searched in locked runs, too. The size stays.
pub(super) fn with_run_times(
    predictor: &Predictor<'_>,
    torque: TorqueModel<f64>,
    mut effects: Vec<(Regressor, f64)>,
) -> Vec<(Regressor, f64)> {
    for place in 0..effects.len() {
        let (Regressor::Switch(what, _), coefficient) = &effects[place] else { continue };
        let (what, coefficient) = (*what, *coefficient);
        let mut others = effects.clone();
        others.remove(place);
        let times = (0..predictor.runs.runs.len()).map(|run| {
            let rows = &predictor.runs.runs[run].rows;
            let error = |at: f64| {
                let mut state = State { torque, effects: others.clone() };
                let mut alone = vec![f64::INFINITY; predictor.runs.runs.len()];
                alone[run] = at;
                state.effects.push((Regressor::Switch(what, alone.into()), coefficient));
                let predicted = predictor.predict(run, &state);
                rows.iter().zip(predicted).map(|(row, p)| (row.power - p).powi(2)).sum::<f64>()
            };
            let end = rows.last().map_or(0.0, |row| row.time);
            let candidates =
                (0..MOST_TIMES as u32).map(|k| end * f64::from(k) / MOST_TIMES).chain([f64::INFINITY]);
            candidates
                .map(|at| (at, error(at)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .map_or(f64::INFINITY, |best| best.0)
        });
        let times: Arc<[f64]> = times.collect();
        effects[place].0 = Regressor::Switch(what, times);
    }
    effects
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::report;
    use residuals::types::Verdict;

    /// Four locked runs that show a share of the added effects, and the decrease of their mean
    /// squares.
    fn confirmed(share: f64, std_err: f64, gains: [f64; 4]) -> Confirmed {
        Confirmed {
            share: Some(ConfirmedShare { share, std_err, runs: 4 }),
            gain_w2: mean_interval(&gains),
            ..report(Verdict::Named).confirmed
        }
    }

    /// t(0.975, 3) = 3.182: 1 ± 0.3 leaves out zero, 1 ± 0.35 does not.
    #[test]
    fn a_name_needs_a_locked_gain_whose_interval_leaves_out_zero() {
        assert!(!confirmed(1.0, 0.3, [0.1; 4]).refuted(false));
        assert!(confirmed(1.0, 0.35, [0.1; 4]).refuted(false));
        assert!(confirmed(0.3, 0.05, [0.1; 4]).refuted(false), "surely less than half of it");
        assert!(confirmed(1.0, 0.1, [-0.3, 0.1, 0.05, 0.1]).refuted(false), "the locked runs got worse");
    }

    /// The floor lies above the gap before: no share is asked for.
    #[test]
    fn what_makes_locked_runs_worse_is_no_name_unless_it_is_of_single_open_runs() {
        let worse = Confirmed { share: None, closed: None, ..confirmed(1.0, 0.1, [-0.1; 4]) };
        assert!(worse.refuted(false) && !worse.refuted(true));
    }

    /// The base's error makes two of four runs worse, but the effect is there.
    #[test]
    fn what_the_base_gets_wrong_does_not_hide_what_the_effect_adds() {
        assert!(!confirmed(1.0, 0.1, [-0.1, 0.5, -0.1, 0.5]).refuted(false));
    }
}
