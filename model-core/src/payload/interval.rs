//! Honest intervals: what the buckets' scatter and the fit's noise say about the error of an
//! estimate.

use crate::real::Real;

use super::{Beyond, Mass, MassEstimate, Place, Unknown};
use crate::model::MassRange;

/// The longest distance, in buckets, at which products of scores count.
const LAGS: usize = 3;

/// Buckets from which on the products 1, 2 and 3 apart count: fewer cannot tell them from chance.
const BUCKETS_FOR_LAG: [f64; LAGS] = [0.0, 12.0, 24.0];

/// What a bucket says: its score and its information.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence<T> {
    score: T,
    information: T,
}

/// Σ x_b y_{b+lag} of scores and of information.
#[derive(Debug, Clone, Copy, Default)]
struct Products<T> {
    scores: T,
    information: T,
}

impl<T: Real> Products<T> {
    #[inline(always)]
    fn add(&mut self, now: &Evidence<T>, earlier: &Evidence<T>) {
        self.scores += now.score * earlier.score;
        self.information += now.information * earlier.information;
    }
}

/// Sums over the buckets of a window that the variance of a weighted estimate needs.
///
/// With scores s_b (the sum of weight times residual in a bucket) and information i_b, the estimate
/// errs by Σ s_b / Σ i_b. Neighbouring buckets are correlated through the filter and through what
/// the model lacks, so the variance of Σ s_b counts their products twice (Newey and West's
/// estimator, without its taper), up to a lag that grows with the window: for an error that lasts
/// two buckets, one lag would see half of its variance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scatter<T> {
    squares: Products<T>,
    lagged: [Products<T>; LAGS],
    /// Latest first.
    last: [Evidence<T>; LAGS],
}

impl<T: Real> Scatter<T> {
    #[inline(always)]
    pub(super) fn add(&mut self, score: T, information: T) {
        let now = Evidence { score, information };
        self.squares.add(&now, &now);
        for (products, earlier) in self.lagged.iter_mut().zip(&self.last) {
            products.add(&now, earlier);
        }
        let [first, second, _] = self.last;
        self.last = [now, first, second];
    }

    /// Half-width of the 95 % interval.
    ///
    /// `information` is that of all buckets, by the weights that their scores have. `share` of it
    /// is of samples whose scores follow the mass: those beyond the noise count by a weight that
    /// takes their residual out again, so by Huber (1964) they are in the scatter of Σ s_b, but not
    /// in what it is divided by. With five times the fit's noise half of the information is of such
    /// samples. `expected` is the variance of Σ s_b by the fit's noise, which counts as `prior`
    /// buckets' worth of evidence besides the scatter seen; `lasting` is the variance of the
    /// estimate from errors that outlast the window. Such errors show in the scatter too as soon as
    /// the robot drives at several speeds, so they are expected beside the noise, not added to the
    /// scatter; at one speed they do not show, and the variance is at least theirs.
    pub(super) fn half_width(&self, information: T, share: T, prior: T, expected: T, lasting: T) -> T {
        let total = information * information;
        let follows = total * share * share;
        // Buckets without information tell nothing: this many alike would scatter as these do.
        let buckets = total / self.squares.information;
        let mut sums = self.squares;
        for (products, least) in self.lagged.iter().zip(BUCKETS_FOR_LAG) {
            if buckets >= T::from_f64(least) {
                sums.scores += T::TWO * products.scores;
                sums.information += T::TWO * products.information;
            }
        }
        // The estimate took its share of the scatter out of every product: for white noise this
        // share remains.
        let remaining = (T::ONE - sums.information / total).at_least(T::ZERO);
        let freedom = buckets * remaining;
        let bias = if freedom > T::HALF { T::ONE / remaining } else { T::ZERO };
        let seen = sums.scores.at_least(self.squares.scores * T::HALF) * bias;
        let expected = expected + lasting * follows;
        let pooled = (prior * expected + freedom * seen) / (prior + freedom);
        let variance = (pooled / follows).at_least(lasting);
        student_95(prior + freedom) * variance.sqrt()
    }
}

/// Two-sided 95 % quantile of Student's t: the Cornish–Fisher expansion to second order, low by 1 %
/// at 5 degrees of freedom. Infinite below 3, where an interval from so little scatter means
/// nothing.
fn student_95<T: Real>(freedom: T) -> T {
    if freedom < T::from_f64(3.0) {
        return T::INFINITY;
    }
    let inverse = T::ONE / freedom;
    T::from_f64(1.960) + inverse * (T::from_f64(2.37) + T::from_f64(2.8) * inverse)
}

/// What the estimate `d` ± `half_width` (kg about the middle of the range) says of the mass.
///
/// Within the range the interval is cut to it. An interval that lies beyond the range altogether
/// says that the mass does; one that reaches in from there leaves it open, and is not cut. Unknown
/// where the interval says too little.
pub(crate) fn within<T: Real>(range: &MassRange<T>, d: T, half_width: T) -> MassEstimate<T> {
    let (middle, reach) = (range.middle(), range.reach());
    if !d.is_finite() {
        return MassEstimate::Unknown(Unknown::NotFinite);
    }
    let cut = |x: T| x.at_least(-reach).at_most(reach);
    let (end, low, high) = (cut(d), d - half_width, d + half_width);
    if half_width > reach || !half_width.is_finite() {
        return MassEstimate::Unknown(Unknown::TooWide);
    }
    let (low, high) = if d == end { (cut(low), cut(high)) } else { (low.at_most(end), high.at_least(end)) };
    let mass = Mass { mass: middle + end, low: middle + low, high: middle + high };
    if (d - end).abs() <= half_width {
        return MassEstimate::Known(mass);
    }
    let place = if d < end { Place::Below } else { Place::Above };
    MassEstimate::Beyond(Beyond { place, mass, best: middle + d })
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
