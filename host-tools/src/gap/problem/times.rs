//! Times of an effect's steps, run by run.

use nalgebra::DVector;

use super::Problem;
use super::fit::Fitted;
use crate::effects::{Regressor, Switched};
use crate::gap::thresholds::name::{LEAST_ROUND, TIME_ROUNDS, TIME_STEPS_S};
use crate::gap::twin::State;

impl<const N: usize> Problem<'_, N> {
    /// Looks for the times of the last effect's steps between those that were tried, run by run.
    pub fn sharpen_times(&self, fitted: &mut Fitted) {
        let Some((Regressor::Switch(what, times), _)) = fitted.state.effects.last().cloned() else {
            return;
        };
        let mut times = times.to_vec();
        for _ in 0..TIME_ROUNDS {
            let before = fitted.loss;
            let mut parts: Vec<Part> = (0..times.len())
                .map(|run| self.part(&with_times(&fitted.state, what, &times), run))
                .collect();
            let mut loss = self.joint_loss(&parts);
            let mut moved = false;
            for run in (0..times.len()).filter(|&run| !self.twin.runs.runs[run].clean) {
                let end = self.twin.runs.runs[run].rows.last().map_or(0.0, |row| row.time);
                for by in TIME_STEPS_S.into_iter().flat_map(|step| [-step, step]) {
                    let at = times[run] + by;
                    if !(0.0..end).contains(&at) {
                        continue;
                    }
                    let kept = std::mem::replace(&mut times[run], at);
                    let part = self.part(&with_times(&fitted.state, what, &times), run);
                    let part = std::mem::replace(&mut parts[run], part);
                    let tried = self.joint_loss(&parts);
                    if tried < loss {
                        (loss, moved) = (tried, true);
                    } else {
                        times[run] = kept;
                        parts[run] = part;
                    }
                }
            }
            if moved && let Some(again) = self.fit(&with_times(&fitted.state, what, &times), &[], 2) {
                *fitted = again;
            }
            if before - fitted.loss < LEAST_ROUND {
                break;
            }
        }
    }

    /// What one run adds to the sum of squares.
    fn part(&self, state: &State, run: usize) -> Part {
        let predicted = self.twin.predict(run, state);
        let rows = &self.twin.runs.runs[run].rows;
        let left: Vec<f64> = rows.iter().zip(predicted).map(|(row, p)| row.power - p).collect();
        let white = DVector::from_vec(self.noise.whiten(self.twin.runs, run, &left));
        let along =
            self.discrepancy.runs.get(run).map_or(DVector::zeros(0), |signals| signals.tr_mul(&white));
        Part { square: white.norm_squared(), along }
    }

    /// Sum of squares of all runs, the discrepancy taken out; without the prior's penalty.
    fn joint_loss(&self, parts: &[Part]) -> f64 {
        let square: f64 = parts.iter().map(|part| part.square).sum();
        let Some(factor) = &self.factor else { return square };
        let mut along = DVector::zeros(self.discrepancy.len());
        for part in parts {
            along += &part.along;
        }
        square - along.dot(&factor.solve(&along))
    }
}

/// Of one run: its sum of squares, and its products with the discrepancy.
struct Part {
    square: f64,
    along: DVector<f64>,
}

/// The state with other times of its last effect's steps.
fn with_times(state: &State, what: Switched, times: &[f64]) -> State {
    let mut state = state.clone();
    if let Some((regressor, _)) = state.effects.last_mut() {
        *regressor = Regressor::Switch(what, times.into());
    }
    state
}
