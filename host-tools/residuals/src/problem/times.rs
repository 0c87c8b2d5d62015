//! Times of an effect's steps, run by run.

use model::effects::{Regressor, Switched};

use super::Problem;
use super::fit::{Fitted, RunLoss};
use crate::predictor::State;
use crate::thresholds::detect::{MOST_TIMES, RUN_ENDS, TIME_GRID_S};
use crate::thresholds::name::{CHANCE, TIME_STEPS_S};
use crate::thresholds::noise::ROUNDS;

/// χ² that the search for a step's time gains by chance in one of `runs` runs: that of the best of
/// all times in all runs.
pub(crate) fn cost_of_a_time(runs: usize) -> f64 {
    2.0 * (MOST_TIMES * runs as f64).ln()
}

impl Problem<'_> {
    /// Refines the times of the last effect's steps, run by run. Runs without a step are searched,
    /// too: steps of other runs may have hidden theirs. No step moves to where none is looked for.
    pub fn sharpen_times(&self, fitted: &mut Fitted) {
        let Some((Regressor::Switch(what, times), _)) = fitted.state.effects.last().cloned() else {
            return;
        };
        let mut times = times.to_vec();
        let field: Vec<usize> =
            (0..times.len()).filter(|&run| !self.predictor.runs.runs[run].clean).collect();
        for _ in 0..ROUNDS {
            let before = fitted.loss;
            let mut search = Search::new(self, &fitted.state, what, times);
            let mut moved = false;
            for &run in &field {
                let end = self.predictor.runs.runs[run].rows.last().map_or(0.0, |row| row.time);
                let inside = RUN_ENDS * end..(1.0 - RUN_ENDS) * end;
                if search.times[run].is_infinite() {
                    let step = TIME_GRID_S.max(end / MOST_TIMES);
                    let grid = (1..).map(|k| step * f64::from(k)).take_while(|at| *at < end);
                    for at in grid.filter(|at| inside.contains(at)) {
                        moved |= search.moves(run, at, cost_of_a_time(field.len()));
                    }
                }
                for by in TIME_STEPS_S.into_iter().flat_map(|step| [-step, step]) {
                    let at = search.times[run] + by;
                    moved |= inside.contains(&at) && search.moves(run, at, 0.0);
                }
            }
            times = search.times;
            if moved && let Some(again) = self.fit(&with_times(&fitted.state, what, &times), &[], 2) {
                *fitted = again;
            }
            if before - fitted.loss < CHANCE {
                break;
            }
        }
    }

    fn joint_loss(&self, runs: &[RunLoss]) -> f64 {
        self.without_discrepancy(runs.iter().map(|run| run.square).sum(), &self.along(runs))
    }
}

/// Step times on trial, and their loss.
struct Search<'p> {
    problem: &'p Problem<'p>,
    state: &'p State,
    what: Switched,
    times: Vec<f64>,
    run_losses: Vec<RunLoss>,
    loss: f64,
}

impl<'p> Search<'p> {
    fn new(problem: &'p Problem<'p>, state: &'p State, what: Switched, times: Vec<f64>) -> Self {
        let now = with_times(state, what, &times);
        let run_losses: Vec<RunLoss> = (0..times.len()).map(|run| problem.run_loss(&now, run)).collect();
        let loss = problem.joint_loss(&run_losses);
        Self { problem, state, what, times, run_losses, loss }
    }

    /// Sets the time of a run if that lowers the loss: by `cost` at least where the run had none.
    fn moves(&mut self, run: usize, at: f64, cost: f64) -> bool {
        let kept = std::mem::replace(&mut self.times[run], at);
        let tried = self.problem.run_loss(&with_times(self.state, self.what, &self.times), run);
        let before = std::mem::replace(&mut self.run_losses[run], tried);
        let loss = self.problem.joint_loss(&self.run_losses);
        let cost = if kept.is_infinite() { cost } else { 0.0 };
        let better = loss < self.loss - cost;
        if better {
            self.loss = loss;
        } else {
            self.times[run] = kept;
            self.run_losses[run] = before;
        }
        better
    }
}

/// The state with other times of its last effect's steps.
fn with_times(state: &State, what: Switched, times: &[f64]) -> State {
    let mut state = state.clone();
    if let Some((regressor, _)) = state.effects.last_mut() {
        *regressor = Regressor::Switch(what, times.into());
    }
    state
}

#[cfg(test)]
mod tests {
    use model_core::torque::{Drive, TorqueModel};

    use super::*;
    use crate::predictor::Predictor;
    use crate::problem::example;
    use crate::thresholds::problem::MOST_FIT_STEPS;

    /// Steps of 0.5 W at 8 and 17 s; the second is not among the starts. In a run without a step
    /// none is detected.
    #[test]
    fn a_step_is_found_in_a_run_in_which_there_was_none() {
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let sharpened = |hidden: [f64; 2]| {
            let step = |times: [f64; 2]| Regressor::Switch(Switched::Static, times.to_vec().into());
            let truth = State { torque, effects: vec![(step(hidden), 0.5)] };
            let runs = example::runs([0.8, 0.3]);
            let runs = example::simulated(&runs, Drive::Dissipative, |_| truth.clone());
            let predictor = Predictor::new(&runs, Drive::Dissipative);
            let problem = example::bare(predictor, torque, 0);
            let none = State { torque, effects: Vec::new() };
            let start = step([hidden[0], f64::INFINITY]);
            let mut fitted = problem.fit(&none, &[(start, 0.0)], MOST_FIT_STEPS).unwrap();
            problem.sharpen_times(&mut fitted);
            let Some((Regressor::Switch(_, times), size)) = fitted.state.effects.pop() else { panic!() };
            (times.to_vec(), size)
        };
        let (times, size) = sharpened([8.0, 17.0]);
        assert!((times[0] - 8.0).abs() < 0.2 && (times[1] - 17.0).abs() < 0.2, "{times:?}");
        assert!((size - 0.5).abs() < 0.02, "{size}");
        assert!(sharpened([8.0, f64::INFINITY]).0[1].is_infinite());
    }
}
