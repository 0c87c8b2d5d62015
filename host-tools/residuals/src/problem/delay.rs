//! A delay, fitted from zero and from the best start on a grid.

use model::effects::Regressor;
use nalgebra::{DMatrix, DVector};

use super::Problem;
use super::fit::{Fitted, RunLoss};
use crate::predictor::State;
use crate::thresholds::name::DELAY_GRID_ROWS;
use crate::thresholds::problem::MOST_FIT_STEPS;

impl Problem<'_> {
    /// The delay in a range, s, with the least loss.
    ///
    /// Gauss–Newton converges from nearby only: a delay of more than a quarter of the filter's
    /// period looks like a negative one, and interpolation between rows gives the loss a local
    /// minimum at every row. So the fit also starts from the best point of a grid. Starts within a
    /// sample of zero are left out: a delay of a fraction of a row smooths the power, too, and
    /// would be named for that.
    pub(crate) fn fit_delay(&self, state: &State, (low, high): (f64, f64)) -> Option<Fitted> {
        let from = |start: f64| self.fit(state, &[(Regressor::Delay, start)], MOST_FIT_STEPS);
        let near = from(0.0)?;
        let sample = self.predictor.runs.step.period_s();
        let step = DELAY_GRID_ROWS * self.predictor.runs.period_s;
        let count = ((high - low) / step).ceil();
        let grid = (0..=count as u32).map(|k| (low + step * f64::from(k)).min(high));
        let starts = grid.chain([self.predictor.removed_delay]).filter(|start| start.abs() > sample);
        let far = self.best_start(state, starts.collect()).and_then(from);
        let is_far =
            |fitted: &Fitted| fitted.state.effects.last().is_some_and(|(_, delay)| delay.abs() > sample);
        Some(far.filter(|far| is_far(far) && far.loss < near.loss).unwrap_or(near))
    }

    /// The delay with the least loss, s; `None` where the loss is less without any.
    fn best_start(&self, state: &State, mut by: Vec<f64>) -> Option<f64> {
        by.insert(0, 0.0);
        let mut squares = vec![0.0; by.len()];
        let mut along = DMatrix::zeros(self.discrepancy.len(), by.len());
        for (run, of) in self.predictor.runs.runs.iter().enumerate() {
            if of.clean {
                let RunLoss { square, along: of_run, .. } = self.run_loss(state, run);
                squares.iter_mut().for_each(|sum| *sum += square);
                along.column_iter_mut().for_each(|mut sum| sum += &of_run);
                continue;
            }
            let predicted = self.predictor.predict_later(run, state, by.iter().copied());
            let white: Vec<DVector<f64>> = predicted.map(|power| self.white(run, &power)).collect();
            squares.iter_mut().zip(&white).for_each(|(sum, white)| *sum += white.norm_squared());
            if let Some(signals) = self.discrepancy.runs.get(run) {
                along += signals.transpose() * DMatrix::from_columns(&white);
            }
        }
        let loss = |k: usize| self.without_discrepancy(squares[k], &along.column(k).into_owned());
        let (best, least) =
            (1..by.len()).map(|k| (k, loss(k))).min_by(|a: &(usize, f64), b| a.1.total_cmp(&b.1))?;
        (least < loss(0)).then_some(by[best])
    }

    /// Loss of a fitted delay, the last of its effects, without what smoothing gains.
    ///
    /// Interpolation between rows smooths the power, whatever the sign of the delay. Where the
    /// power is smoother than predicted, smoothing alone would earn the delay a name. The loss is
    /// quadratic near its minimum: the delay itself gains a quarter of the difference between the
    /// losses of the opposite delay and of the delay. Beyond a sample the loss is no longer
    /// quadratic, and the whole gain counts.
    pub(crate) fn loss_as_delay(&self, state: &State, fitted: &Fitted) -> f64 {
        let mut opposite = fitted.state.clone();
        match opposite.effects.last_mut() {
            Some((Regressor::Delay, delay)) if delay.abs() < self.predictor.runs.step.period_s() => {
                *delay = -*delay
            }
            _ => return fitted.loss,
        }
        let gain = 0.25 * (self.losses(&opposite).0 - fitted.loss);
        (self.losses(state).0 - gain).max(fitted.loss)
    }
}
