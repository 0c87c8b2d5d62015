//! The inverse covariance of a run's rows: a band.
//!
//! Rows are D (n + s): n the autoregression with precision Q, s spikes of variance V, D the scales.
//! The inverse of D (Q⁻¹ + V) D is D⁻¹ (Q − Q (Q + V⁻¹)⁻¹ Q) D⁻¹.

use nalgebra::DMatrix;

use super::noise::{Noise, innovation};
use super::priors::ORDER;

/// What lies on the diagonal, and beside it.
type Band = Vec<[f64; ORDER + 1]>;

/// Of one run.
#[derive(Debug, Clone)]
pub struct Precision {
    scales: Vec<f64>,
    spikes: Vec<f64>,
    /// Whether the past of each row is known: 1 or 0.
    known: Vec<f64>,
    /// Q: row and what lies behind it.
    autoregression: Band,
    /// The lower factor of Q + V⁻¹: row and what lies before it.
    factor: Band,
}

impl Precision {
    /// Of normal rows.
    pub(super) fn new(noise: &Noise, scales: Vec<f64>, spikes: Vec<f64>, known: Vec<f64>) -> Self {
        let mut precision = Self { scales, spikes, known, autoregression: Vec::new(), factor: Vec::new() };
        let weights = precision.known.clone();
        precision.weigh(noise, &weights);
        precision
    }

    /// With weights of the innovations.
    fn weigh(&mut self, noise: &Noise, weights: &[f64]) {
        let count = self.scales.len();
        let mut filter = [1.0; ORDER + 1];
        for (tap, a) in filter[1..].iter_mut().zip(&noise.memory) {
            *tap = -a;
        }
        let mut band = vec![[0.0; ORDER + 1]; count];
        for t in (0..count).filter(|&t| weights[t] > 0.0) {
            let weight = weights[t] / noise.modelled.powi(2);
            for i in 0..=ORDER {
                for j in 0..=i {
                    band[t - i][i - j] += weight * filter[i] * filter[j];
                }
            }
        }
        let mut factor = vec![[0.0; ORDER + 1]; count];
        for t in 0..count {
            for l in (0..=ORDER.min(t)).rev() {
                let column = t - l;
                let mut sum = band[column][l] + if l == 0 { 1.0 / self.spikes[t] } else { 0.0 };
                for k in 1..=ORDER - l {
                    if k <= column {
                        sum -= factor[t][l + k] * factor[column][k];
                    }
                }
                factor[t][l] =
                    if l == 0 { sum.max(f64::MIN_POSITIVE).sqrt() } else { sum / factor[column][0] };
            }
        }
        (self.autoregression, self.factor) = (band, factor);
    }

    /// Weights of Student's t by what is left of the rows.
    pub(super) fn weigh_by(&mut self, noise: &Noise, residual: &[f64]) {
        let x: Vec<f64> = residual.iter().zip(&self.scales).map(|(x, scale)| x / scale).collect();
        let mut spikes = self.times(&x);
        self.solve(&mut spikes);
        let smooth: Vec<f64> = x.iter().zip(&spikes).map(|(x, spike)| x - spike).collect();
        let weights: Vec<f64> = (0..x.len())
            .map(|t| match self.known[t] > 0.0 {
                true => noise.weight(innovation(&noise.memory, &smooth, t) / noise.innovation),
                false => 0.0,
            })
            .collect();
        self.weigh(noise, &weights);
    }

    /// Q x.
    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for (t, band) in self.autoregression.iter().enumerate() {
            out[t] += band[0] * x[t];
            for (l, value) in band.iter().enumerate().skip(1) {
                if t + l < x.len() {
                    out[t] += value * x[t + l];
                    out[t + l] += value * x[t];
                }
            }
        }
        out
    }

    /// (Q + V⁻¹)⁻¹ x, in place.
    fn solve(&self, x: &mut [f64]) {
        let count = x.len();
        for t in 0..count {
            let band = &self.factor[t];
            let sum = (1..=ORDER.min(t)).fold(x[t], |sum, l| sum - band[l] * x[t - l]);
            x[t] = sum / band[0];
        }
        for t in (0..count).rev() {
            let reach = ORDER.min(count - 1 - t);
            let sum = (1..=reach).fold(x[t], |sum, l| sum - self.factor[t + l][l] * x[t + l]);
            x[t] = sum / self.factor[t][0];
        }
    }

    /// The inverse covariance times columns.
    pub fn inverse_times(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone();
        for mut column in out.column_iter_mut() {
            let x: Vec<f64> = column.iter().zip(&self.scales).map(|(x, scale)| x / scale).collect();
            let product = self.times(&x);
            let mut spikes = product.clone();
            self.solve(&mut spikes);
            let taken = self.times(&spikes);
            for (t, value) in column.iter_mut().enumerate() {
                *value = (product[t] - taken[t]) / self.scales[t];
            }
        }
        out
    }
}
