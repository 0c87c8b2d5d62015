//! Predicted power, and its slopes, with delays that are [free of
//! interpolation](super::delay).

use model::effects::Regressor;

use super::delay::later;
use residuals::predictor::{Predictor, State};

/// Step of a slope by a delay, s. Derived: small against a row, large against rounding.
const STEP_S: f64 = 1e-3;

/// A predictor whose clean delay is kept apart.
#[derive(Debug, Clone, Copy)]
pub struct Predicted<'a> {
    /// Without any delay.
    pub predictor: Predictor<'a>,
    /// By how much power is later than speed in clean runs already, s.
    pub clean_delay: f64,
}

impl<'a> Predicted<'a> {
    /// Of a predictor with its clean delay.
    pub fn new(predictor: Predictor<'a>) -> Self {
        Self { predictor: Predictor { clean_delay: 0.0, ..predictor }, clean_delay: predictor.clean_delay }
    }

    fn shifted(&self, values: &[f64], delay: f64) -> Vec<f64> {
        later(values, delay, self.predictor.runs.period_s)
    }

    /// The delay of a state, and the state without it.
    fn parted(&self, state: &State) -> (f64, State) {
        let is_delay = |(regressor, _): &&(Regressor, f64)| *regressor == Regressor::Delay;
        let delay: f64 = state.effects.iter().filter(is_delay).map(|(_, delay)| delay).sum();
        let others = state.effects.iter().filter(|effect| !is_delay(effect)).cloned().collect();
        (self.clean_delay + delay, State { effects: others, ..state.clone() })
    }

    /// Power of one run, W.
    pub fn power(&self, run: usize, state: &State) -> Vec<f64> {
        let (delay, state) = self.parted(state);
        self.shifted(&self.predictor.predict(run, &state), delay)
    }

    /// ∂P/∂ the first parameters of the base.
    pub fn base_slopes(&self, run: usize, state: &State, parameters: usize) -> Vec<Vec<f64>> {
        let (delay, state) = self.parted(state);
        let at = self.predictor.predict(run, &state);
        let slopes = self.predictor.base_slopes(run, &state, &at, parameters);
        slopes.iter().map(|slope| self.shifted(slope, delay)).collect()
    }

    /// ∂P/∂ coefficients of effects that are in the state already, or of further ones.
    pub fn slopes(&self, run: usize, state: &State, regressors: &[Regressor]) -> Vec<Vec<f64>> {
        let (delay, state) = self.parted(state);
        let at = self.predictor.predict(run, &state);
        let slope = |regressor: &Regressor| match regressor {
            Regressor::Delay => {
                let [more, less] = [STEP_S, -STEP_S].map(|step| self.shifted(&at, delay + step));
                more.iter().zip(&less).map(|(more, less)| (more - less) / (2.0 * STEP_S)).collect()
            }
            other => self.shifted(&self.predictor.effect_slope(run, &state, other, &at), delay),
        };
        regressors.iter().map(slope).collect()
    }
}
