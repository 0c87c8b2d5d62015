//! A delay fitted from none at all, and from far.

use super::Problem;
use super::fit::Fitted;
use crate::effects::Regressor;
use crate::gap::thresholds::name::QUARTER;
use crate::gap::thresholds::problem::MOST_FIT_STEPS;
use crate::gap::twin::State;

impl<const N: usize> Problem<'_, N> {
    /// The delay in a range, s, that leaves least.
    pub(crate) fn fit_delay(&self, state: &State, range: (f64, f64)) -> Option<Fitted> {
        let near = self.fit(state, &[(Regressor::Delay, 0.0)], MOST_FIT_STEPS)?;
        let far = self.fit_far_delay(state, range).filter(|far| far.loss < near.loss);
        Some(far.unwrap_or(near))
    }

    /// A delay of more than a quarter of the filter's period, which no step of Gauss and Newton from none at all finds: there what is late
    /// looks as if it were early. Shorter ones are left to these, for a delay of part of a row smooths the power as well, and would be
    /// named for that.
    fn fit_far_delay(&self, state: &State, (low, high): (f64, f64)) -> Option<Fitted> {
        let step = QUARTER / self.twin.runs.robot.cutoff_hz;
        let count = ((high - low) / step).ceil();
        let grid = (0..=count as u32).map(|k| (low + step * f64::from(k)).min(high));
        let starts = grid.chain([self.twin.early]);
        let far = |delay: f64| delay.abs() > step;
        let start = self.best_start(state, &Regressor::Delay, starts.filter(|&start| far(start)))?;
        let fitted = self.fit(state, &[(Regressor::Delay, start)], MOST_FIT_STEPS)?;
        fitted.state.effects.last().is_some_and(|(_, delay)| far(*delay)).then_some(fitted)
    }
}
