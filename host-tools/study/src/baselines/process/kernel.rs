//! Gaussian-process regression with a squared-exponential kernel, exact.
//!
//! Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), Algorithm 2.1, with the
//! signal's variance s² factored out of the covariance, K = s² (C + ν 1): for given lengths and
//! noise ratio ν its most likely value has a closed form, s² = yᵀ (C + ν 1)⁻¹ y / n, and need not
//! be searched.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Inputs of the process.
pub(super) const INPUTS: usize = 4;

/// Inputs without units, and the value there.
pub(super) type Sample = ([f64; INPUTS], f64);

/// Parameters of the kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hyper {
    /// Length of each input, in its unit; infinite where it has no influence.
    pub(super) lengths: [f64; INPUTS],
    /// Variance of the noise over that of the signal, ν.
    pub(super) noise: f64,
}

impl Hyper {
    fn scale(&self, inputs: &[f64; INPUTS]) -> [f64; INPUTS] {
        std::array::from_fn(|place| inputs[place] / self.lengths[place])
    }
}

/// exp(-½ |a - b|²) for inputs in lengths.
fn correlation(a: &[f64; INPUTS], b: &[f64; INPUTS]) -> f64 {
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (-0.5 * square).exp()
}

/// Samples, and their weights in a prediction.
#[derive(Debug, Clone)]
pub(super) struct Process {
    hyper: Hyper,
    /// Inputs of the samples, in lengths.
    scaled: Vec<[f64; INPUTS]>,
    weights: DVector<f64>,
    signal_variance: f64,
}

impl Process {
    /// `None` where the covariance is not positive definite, or not finite.
    pub(super) fn new(samples: &[Sample], hyper: Hyper) -> Option<Self> {
        let Solved { scaled, weights, signal_variance, .. } = Solved::new(samples, &hyper)?;
        Some(Self { hyper, scaled, weights, signal_variance })
    }

    /// The process's mean at these inputs.
    pub(super) fn mean(&self, inputs: &[f64; INPUTS]) -> f64 {
        let inputs = self.hyper.scale(inputs);
        self.scaled
            .iter()
            .zip(&self.weights)
            .map(|(sample, weight)| weight * correlation(sample, &inputs))
            .sum()
    }

    pub(super) fn hyper(&self) -> &Hyper {
        &self.hyper
    }

    /// Standard deviation of signal and noise, in the unit of the values.
    pub(super) fn spreads(&self) -> (f64, f64) {
        (self.signal_variance.sqrt(), (self.signal_variance * self.hyper.noise).sqrt())
    }
}

/// Log marginal likelihood of the samples, at the most likely variance of the signal (Eq. 5.8
/// there). `None` as for [`Process::new`].
pub(super) fn log_likelihood(samples: &[Sample], hyper: &Hyper) -> Option<f64> {
    let Solved { factor, signal_variance, .. } = Solved::new(samples, hyper)?;
    let count = samples.len() as f64;
    // ½ ln det of L Lᵀ.
    let half_log_det: f64 = factor.l_dirty().diagonal().iter().map(|entry| entry.ln()).sum();
    let likelihood = -0.5 * count * (1.0 + (std::f64::consts::TAU * signal_variance).ln()) - half_log_det;
    likelihood.is_finite().then_some(likelihood)
}

struct Solved {
    scaled: Vec<[f64; INPUTS]>,
    factor: Cholesky<f64, Dyn>,
    /// (C + ν 1)⁻¹ y
    weights: DVector<f64>,
    signal_variance: f64,
}

impl Solved {
    fn new(samples: &[Sample], hyper: &Hyper) -> Option<Self> {
        let count = samples.len();
        let scaled: Vec<_> = samples.iter().map(|(inputs, _)| hyper.scale(inputs)).collect();
        let mut covariance = DMatrix::zeros(count, count);
        for (column, inputs) in scaled.iter().enumerate() {
            covariance[(column, column)] = 1.0 + hyper.noise;
            // The factor is made from the lower triangle alone.
            for (row, other) in scaled.iter().enumerate().skip(column + 1) {
                covariance[(row, column)] = correlation(inputs, other);
            }
        }
        let factor = covariance.cholesky()?;
        let values = DVector::from_iterator(count, samples.iter().map(|(_, value)| *value));
        let weights = factor.solve(&values);
        let signal_variance = values.dot(&weights) / count as f64;
        (signal_variance > 0.0 && signal_variance.is_finite()).then_some(Self {
            scaled,
            factor,
            weights,
            signal_variance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Hyper, INPUTS, Process, log_likelihood};

    const HYPER: Hyper = Hyper { lengths: [0.5, 2.0, f64::INFINITY, f64::INFINITY], noise: 0.1 };
    const SAMPLES: [([f64; INPUTS], f64); 2] = [([0.0, 0.0, 3.0, 0.0], 1.0), ([0.5, 2.0, -7.0, 0.0], -0.5)];

    /// Two samples by hand: both inputs are one length apart, so c = exp(-1); a = 1.1. (C + ν)⁻¹ y
    /// = (a y1 - c y2, a y2 - c y1) / (a² - c²), ln det = ln(a² - c²), and the density of N(0, s²
    /// (C + ν)) at y.
    #[test]
    fn two_samples_are_as_by_hand() {
        let (a, c) = (1.1_f64, (-1.0_f64).exp());
        let det = a * a - c * c;
        let weights = [(a - -0.5 * c) / det, (-0.5 * a - c) / det];
        let signal = (weights[0] - 0.5 * weights[1]) / 2.0;
        let quadratic = (weights[0] - 0.5 * weights[1]) / signal;
        let log_det = det.ln() + 2.0 * signal.ln();
        let expected = -0.5 * quadratic - 0.5 * log_det - std::f64::consts::TAU.ln();
        assert!((log_likelihood(&SAMPLES, &HYPER).unwrap() - expected).abs() < 1e-12);
        let process = Process::new(&SAMPLES, HYPER).unwrap();
        assert!((process.spreads().0 - signal.sqrt()).abs() < 1e-12);
        // At the first sample: correlation 1 with itself, c with the other.
        assert!((process.mean(&SAMPLES[0].0) - (weights[0] + c * weights[1])).abs() < 1e-12);
    }

    /// Far from every sample nothing is known: the mean is that of the prior.
    #[test]
    fn far_away_the_mean_is_zero() {
        let process = Process::new(&SAMPLES, HYPER).unwrap();
        assert!(process.mean(&[50.0, 0.0, 0.0, 0.0]).abs() < 1e-12);
    }

    /// Not a number, or nothing to explain.
    #[test]
    fn refuses_what_has_no_likelihood() {
        let with = |value: f64| [SAMPLES[0], ([0.1; INPUTS], value)];
        assert!(log_likelihood(&with(f64::NAN), &HYPER).is_none());
        assert!(Process::new(&[([0.0; INPUTS], 0.0)], HYPER).is_none());
    }
}
