//! Disturbance without structure: bursts, a rattle, an uneven floor leave no mean, but they scatter
//! more than clean runs do.

use logs::robot::chassis::Together;
use numerics::intervals::mean_interval;

use crate::noise::spread::Spread;
use crate::predictor::State;
use crate::problem::Problem;
use crate::thresholds::detect::{DISTURBANCE, MOST_SIGMAS, NOTHING_LEFT};

/// Scatter of the field's residuals relative to that of clean runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverDispersion {
    /// Ratio of mean squares of the whitened, weighted residuals: geometric means over runs.
    pub ratio: f64,
    /// Its logarithm per standard error, by the scatter of runs.
    pub z: f64,
}

impl OverDispersion {
    /// Of the runs at a state; `None` without clean runs to compare with, or with fewer than two
    /// runs of either kind.
    pub fn of(problem: &Problem<'_>, state: &State) -> Option<Self> {
        let runs = problem.predictor.runs;
        if !runs.runs.iter().any(|run| run.clean) {
            return None;
        }
        let white = problem.plain(state);
        let known = &problem.noise.weights;
        // How clean runs scatter at each speed, acceleration and jerk is what is usual there.
        let usual = Spread::fit(runs, &white, known, |place| runs.runs[place].clean).of(runs);
        let logarithms = |clean: bool| -> Vec<f64> {
            let places = (0..runs.runs.len()).filter(|&place| runs.runs[place].clean == clean);
            let square = |place: usize| {
                // At rest there is nothing to scatter, and clean runs hardly rest.
                let moves = |row: usize| runs.runs[place].rows[row].wheels.is_moving();
                let rows = (0..white[place].len()).filter(|&row| known[place][row] > 0.0 && moves(row));
                let squares: Vec<f64> = rows
                    .map(|row| (white[place][row] / usual[place][row]).abs().min(MOST_SIGMAS).powi(2))
                    .collect();
                squares.iter().sum::<f64>() / squares.len().max(1) as f64
            };
            places.map(square).filter(|square| *square > 0.0).map(f64::ln).collect()
        };
        let [field, clean] = [false, true].map(|clean| mean_interval(&logarithms(clean)));
        let difference = field.mean - clean.mean;
        let error = field.std_err()?.hypot(clean.std_err()?);
        Some(Self { ratio: difference.exp(), z: difference / error.max(1e-9) })
    }

    /// Whether it exceeds what differences between runs explain.
    pub fn is_beyond_chance(&self) -> bool {
        self.ratio > DISTURBANCE && self.z > NOTHING_LEFT
    }
}
