//! Prewhitening: an autoregression that leaves the noise of the power without memory.

use logs::runs::{Row, Runs};

use crate::thresholds::noise::{ORDER, WHITE_FLOOR};

/// Values of one signal: a vector a run, a value a row.
pub type Signal = Vec<Vec<f64>>;

/// x_t − Σ a_k x_{t−k}.
#[derive(Debug, Clone, PartialEq)]
pub struct Whitener {
    /// a_1 … a_p.
    pub coefficients: Vec<f64>,
}

impl Whitener {
    /// From the autocovariance of residuals over some runs, by Levinson and Durbin.
    pub fn estimate(runs: &Runs, residual: &Signal, of: impl Fn(usize) -> bool) -> Self {
        let mut lags = vec![0.0; ORDER + 1];
        let some = runs.runs.iter().zip(residual).enumerate().filter(|(place, _)| of(*place));
        for (_, (run, values)) in some {
            let mut age = 0;
            for (t, row) in run.rows.iter().enumerate() {
                age = if row.starts { 0 } else { age + 1 };
                for (lag, sum) in lags.iter_mut().enumerate().take(ORDER.min(age) + 1) {
                    *sum += values[t] * values[t - lag];
                }
            }
        }
        lags[0] *= 1.0 + WHITE_FLOOR;
        Self { coefficients: levinson(&lags) }
    }

    /// Filters a signal. The first rows of each piece, whose past is not known, become 0 as
    /// [`Self::known`] tells.
    pub fn apply(&self, runs: &Runs, signal: &Signal) -> Signal {
        runs.runs
            .iter()
            .zip(signal)
            .enumerate()
            .map(|(place, (_, values))| self.apply_run(runs, place, values))
            .collect()
    }

    /// As [`apply`](Self::apply) for the values of one run.
    pub fn apply_run(&self, runs: &Runs, place: usize, values: &[f64]) -> Vec<f64> {
        let order = self.coefficients.len();
        let mut out = vec![0.0; values.len()];
        let Some(present) = values.get(order..) else { return out };
        out[order..].copy_from_slice(present);
        for (lag, a) in (1..).zip(&self.coefficients) {
            for (out, past) in out[order..].iter_mut().zip(&values[order - lag..]) {
                *out -= a * past;
            }
        }
        for (out, known) in out.iter_mut().zip(self.known_of(&runs.runs[place].rows)) {
            if !known {
                *out = 0.0;
            }
        }
        out
    }

    /// Whether the past of each row is known.
    pub fn known(&self, runs: &Runs) -> Vec<Vec<bool>> {
        runs.runs.iter().map(|run| self.known_of(&run.rows).collect()).collect()
    }

    fn known_of(&self, rows: &[Row]) -> impl Iterator<Item = bool> {
        let order = self.coefficients.len();
        rows.iter().scan(0, move |age, row| {
            *age = if row.starts { 0 } else { *age + 1 };
            Some(*age >= order)
        })
    }
}

/// Solves the Yule–Walker equations; none where the autocovariance is none.
fn levinson(lags: &[f64]) -> Vec<f64> {
    let order = lags.len() - 1;
    let mut a: Vec<f64> = Vec::with_capacity(order);
    let mut error = lags[0];
    for k in 1..=order {
        if error <= 0.0 || error.is_nan() {
            break;
        }
        let sum: f64 = a.iter().enumerate().map(|(i, a)| a * lags[k - 1 - i]).sum();
        let reflection = (lags[k] - sum) / error;
        let before = a.clone();
        for (i, value) in a.iter_mut().enumerate() {
            *value -= reflection * before[before.len() - 1 - i];
        }
        a.push(reflection);
        error *= 1.0 - reflection * reflection;
    }
    a.resize(order, 0.0);
    a
}

#[cfg(test)]
mod tests {
    use super::{Whitener, levinson};
    use crate::problem::example;

    /// x_t − 0.5 x_{t−1} − 0.2 x_{t−2}; 0 where a piece begins.
    #[test]
    fn a_filter_begins_anew_with_each_piece() {
        let mut runs = example::runs([0.4, 0.9]);
        let mut rows = runs.runs[1].rows.to_vec();
        rows[5].starts = true;
        runs.runs[1].rows = rows.into();
        let values: Vec<f64> = (0..runs.runs[1].rows.len()).map(|t| (0.7 * t as f64).sin() + 2.0).collect();
        let white = Whitener { coefficients: vec![0.5, 0.2] }.apply_run(&runs, 1, &values);
        for (t, white) in white.iter().enumerate() {
            let expected = match t {
                0 | 1 | 5 | 6 => 0.0,
                _ => values[t] - 0.5 * values[t - 1] - 0.2 * values[t - 2],
            };
            assert!((white - expected).abs() < 1e-12, "{t}: {white} {expected}");
        }
    }

    /// An AR(2) process x_t = 0.6 x_{t−1} + 0.3 x_{t−2} + e has autocorrelations ρ1 = 0.6/0.7, ρ_k
    /// = 0.6 ρ_{k−1} + 0.3 ρ_{k−2}.
    #[test]
    fn levinson_finds_the_process_of_its_autocovariance() {
        let mut lags = vec![1.0, 0.6 / 0.7];
        for k in 2..6 {
            lags.push(0.6 * lags[k - 1] + 0.3 * lags[k - 2]);
        }
        let coefficients = levinson(&lags);
        for (value, expected) in coefficients.iter().zip([0.6, 0.3, 0.0, 0.0, 0.0]) {
            assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        }
    }
}
