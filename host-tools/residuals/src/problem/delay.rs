//! A delay fitted from none at all, and from wherever along its range least is left.

use model::effects::Regressor;

use super::Problem;
use super::fit::Fitted;
use crate::thresholds::name::DELAY_GRID_ROWS;
use crate::thresholds::problem::MOST_FIT_STEPS;
use crate::twin::State;

impl Problem<'_> {
    /// The delay in a range, s, that leaves least.
    ///
    /// Gauss and Newton do not get far: what is late by more than a quarter of the filter's period
    /// looks as if it were early, and between rows the power is interpolated, which leaves a hollow
    /// about every row. So they begin where a grid finds the least; but not within a sample of none
    /// at all: a delay of part of a row smooths the power as well, and would be named for that.
    pub(crate) fn fit_delay(&self, state: &State, (low, high): (f64, f64)) -> Option<Fitted> {
        let from = |start: f64| self.fit(state, &[(Regressor::Delay, start)], MOST_FIT_STEPS);
        let near = from(0.0)?;
        let sample = self.twin.runs.step.period_s();
        let step = DELAY_GRID_ROWS * self.twin.runs.period_s;
        let count = ((high - low) / step).ceil();
        let grid = (0..=count as u32).map(|k| (low + step * f64::from(k)).min(high));
        let starts = grid.chain([self.twin.early]).filter(|start| start.abs() > sample);
        let far = self.best_start(state, &Regressor::Delay, starts).and_then(from);
        let is_far =
            |fitted: &Fitted| fitted.state.effects.last().is_some_and(|(_, delay)| delay.abs() > sample);
        Some(far.filter(|far| is_far(far) && far.loss < near.loss).unwrap_or(near))
    }

    /// Loss of a fitted delay, the last of its effects, as far as it comes from being late.
    ///
    /// Between rows the power is interpolated, which smooths it, whichever sign the delay has:
    /// where the power is smoother than the base says, that alone is worth a name. About its least
    /// a loss is quadratic, and what being late gains is a quarter of what the delay is better than
    /// its opposite. Beyond a sample it counts whole: the loss is quadratic no longer there.
    pub(crate) fn loss_as_delay(&self, state: &State, fitted: &Fitted) -> f64 {
        let mut opposite = fitted.state.clone();
        match opposite.effects.last_mut() {
            Some((Regressor::Delay, delay)) if delay.abs() < self.twin.runs.step.period_s() => {
                *delay = -*delay
            }
            _ => return fitted.loss,
        }
        let gain = 0.25 * (self.losses(&opposite).0 - fitted.loss);
        (self.losses(state).0 - gain).max(fitted.loss)
    }
}
