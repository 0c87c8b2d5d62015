//! A delay, fitted from zero and from the best start on a grid.

use model::effects::Regressor;

use super::Problem;
use super::fit::Fitted;
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
        let far = self.best_start(state, &Regressor::Delay, starts).and_then(from);
        let is_far =
            |fitted: &Fitted| fitted.state.effects.last().is_some_and(|(_, delay)| delay.abs() > sample);
        Some(far.filter(|far| is_far(far) && far.loss < near.loss).unwrap_or(near))
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
