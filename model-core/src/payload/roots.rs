//! The paper's estimator: the root of Eq. 24 at every sample, averaged (Eq. 25 and 26).

use crate::model::{MassRange, Response};
use crate::quadratic;
use crate::real::Real;

use super::interval::{Scatter, within};
use super::{Bucket, MassEstimate, Method, Unknown};

/// Sums over the samples of a bucket.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums<T> {
    weight: T,
    weighted: T,
}

impl<T: Real> Sums<T> {
    /// The root within the mass range, if there is one (Eq. 25), weighted by the wheels' absolute
    /// speed in rad/s (Eq. 26).
    #[inline]
    fn add(&mut self, power: T, response: &Response<T>, range: &MassRange<T>, weight: T) {
        if response.may_clamp || weight <= T::ZERO {
            return;
        }
        let p = &response.polynomial;
        // Power grows with mass between the two roots of a parabola: with both inside, the upper is
        // on that branch.
        let root = quadratic::root_within(p.a, p.b, p.c - power, range.reach());
        if let Some(root) = root {
            self.weight += weight;
            self.weighted += weight * root;
        }
    }
}

impl<T: Real> Bucket<T> for Sums<T> {
    fn merge(&mut self, other: &Self) {
        self.weight += other.weight;
        self.weighted += other.weighted;
    }
}

/// The averaged-roots estimator. Its interval is that of a weighted mean: it knows the roots'
/// scatter, but not that roots cut to the range lean towards its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootMean<T> {
    /// The masses in question.
    pub range: MassRange<T>,
}

impl<T: Real> Method<T> for RootMean<T> {
    type Sums = Sums<T>;

    #[inline]
    fn add(&self, sums: &mut Sums<T>, power: T, response: &Response<T>, speed: T, _: T) {
        sums.add(power, response, &self.range, speed);
    }

    // A function of its own, so that its loop over the buckets is compiled alone: inlined, it has
    // too few registers.
    #[inline(never)]
    fn estimate_of<'a, P>(&self, total: &Sums<T>, parts: impl IntoIterator<Item = P>, _: T) -> MassEstimate<T>
    where
        P: IntoIterator<Item = &'a Sums<T>>,
    {
        if !(total.weight.is_finite() && total.weighted.is_finite()) {
            return MassEstimate::Unknown(Unknown::NotFinite);
        }
        if total.weight <= T::ZERO {
            return MassEstimate::Unknown(Unknown::NoMotion);
        }
        let d = total.weighted / total.weight;
        let mut scatter = Scatter::default();
        for buckets in parts {
            for bucket in buckets {
                scatter.add(bucket.weighted - bucket.weight * d, bucket.weight);
            }
        }
        within(&self.range, d, scatter.half_width(total.weight, T::ONE, T::ZERO, T::ZERO, T::ZERO))
    }

    /// The paper restarts at known times or periodically; roots have no scale to be surprised on.
    fn surprise(&self, _sums: &Sums<T>, _mass: T) -> Option<T> {
        None
    }
}
