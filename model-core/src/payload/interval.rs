//! Honest intervals: what the buckets' scatter and the fit's noise say about the error of an estimate.

use crate::real::Real;

use super::{Mass, Payload, Unknown};
use crate::model::MassRange;

/// Sums over the buckets of a window that the variance of a weighted estimate needs.
///
/// With scores s_b (the sum of weight times residual in a bucket) and information i_b, the estimate errs by
/// Σ s_b / Σ i_b. Neighbouring buckets are correlated through the filter, so the variance of Σ s_b counts their
/// products once more (Newey and West's estimator with one lag, without its taper).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scatter<T> {
    squares: T,
    neighbours: T,
    information: T,
    information_squares: T,
    last_score: T,
}

impl<T: Real> Scatter<T> {
    #[inline]
    pub(super) fn add(&mut self, score: T, information: T) {
        self.squares += score * score;
        self.neighbours += score * self.last_score;
        self.last_score = score;
        self.information += information;
        self.information_squares += information * information;
    }

    pub(super) fn information(&self) -> T {
        self.information
    }

    /// Half-width of the 95 % interval.
    ///
    /// `expected` is the variance of Σ s_b by the fit's noise, which counts as `prior` buckets' worth of evidence beside
    /// the scatter seen; `lasting` is the variance of the estimate from errors that outlast the window.
    pub(super) fn half_width(&self, prior: T, expected: T, lasting: T) -> T {
        // Buckets without information tell nothing: this many alike would scatter as these do.
        let buckets = self.information * self.information / self.information_squares;
        let freedom = (buckets - T::ONE).at_least(T::ZERO);
        // One degree of freedom went into the estimate.
        let bias = if freedom > T::HALF { buckets / freedom } else { T::ZERO };
        let seen = (self.squares + T::TWO * self.neighbours).at_least(self.squares * T::HALF) * bias;
        let pooled = (prior * expected + freedom * seen) / (prior + freedom);
        let variance = pooled / (self.information * self.information);
        student_95(prior + freedom) * (variance + lasting).sqrt()
    }
}

/// Two-sided 95 % quantile of Student's t: the Cornish–Fisher expansion to second order, low by 1 % at 5 degrees of
/// freedom. Infinite below 3, where an interval from so little scatter means nothing.
fn student_95<T: Real>(freedom: T) -> T {
    if freedom < T::from_f64(3.0) {
        return T::ONE / T::ZERO;
    }
    let inverse = T::ONE / freedom;
    T::from_f64(1.960) + inverse * (T::from_f64(2.37) + T::from_f64(2.8) * inverse)
}

/// The estimate `d` ± `half_width` (kg about the middle of the range) cut to the range; unknown where it says too
/// little.
pub(super) fn within<T: Real>(range: &MassRange<T>, d: T, half_width: T) -> Payload<T> {
    let (middle, reach) = (range.middle(), range.reach());
    if !d.is_finite() {
        return Payload::Unknown(Unknown::NotFinite);
    }
    if half_width > reach || !half_width.is_finite() {
        return Payload::Unknown(Unknown::TooWide);
    }
    let cut = |x: T| middle + x.at_least(-reach).at_most(reach);
    Payload::Known(Mass { mass: cut(d), low: cut(d - half_width), high: cut(d + half_width) })
}

#[cfg(test)]
mod tests {
    use super::student_95;

    /// Against SciPy's t.ppf(0.975, ν).
    #[test]
    fn student_quantile() {
        for (freedom, quantile) in
            [(5.0, 2.570_582), (8.0, 2.306_004), (12.0, 2.178_813), (30.0, 2.042_272), (1e6, 1.959_966)]
        {
            let error: f64 = student_95(freedom) / quantile - 1.0;
            assert!(error.abs() < 0.01, "{freedom}: {error}");
        }
    }
}
