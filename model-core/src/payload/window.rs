//! The default estimator: least squares of power over the mass, on all samples of the window at
//! once.
//!
//! Minimises Σ (P_k − a_k d² − b_k d − c_k)² over d = m − m₀ within the robot's masses. The sum is
//! a quartic in d whose coefficients are sums over samples, so a window of any length is a few sums
//! per second of it: constant memory, no samples kept. Each sample weighs by how much it says about
//! the mass, and the curvature gives an interval.
//!
//! A sample whose residual at the mass known now is beyond the noise counts less (Huber): a square
//! loss lets ten samples at the corners of the acceleration move the mass by percents. Such a
//! sample says on which side of it the mass lies, but no longer how far: the mass is as uncertain
//! as the samples within the noise leave it.

use crate::model::{MassRange, Response};
use crate::real::Real;

use super::interval::{Scatter, within};
use super::{Bucket, MassEstimate, Method, Noise, Unknown, huber};

/// Sums over the samples of a bucket, r being measured power minus c.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sums<T> {
    rb: T,
    ra: T,
    bb: T,
    /// What of `bb` is of samples beyond the noise: most add nothing.
    outer: T,
    ab: T,
    aa: T,
    b: T,
    a: T,
}

impl<T: Real> Sums<T> {
    #[inline]
    fn add(&mut self, power: T, response: &Response<T>, linear_beyond: T, d: T) {
        if response.may_clamp {
            return;
        }
        let p = &response.polynomial;
        let r = power - p.c;
        let (mut weighted_a, mut weighted_b) = (p.a, p.b);
        let mut sums = T::read(self);
        let weight = huber(power - p.at(d), linear_beyond);
        // Most samples count in full, and are multiplied by nothing.
        if weight < T::ONE {
            weighted_a = weight * p.a;
            weighted_b = weight * p.b;
            sums.outer += p.b * weighted_b;
        }
        sums.rb += r * weighted_b;
        sums.ra += r * weighted_a;
        sums.bb += p.b * weighted_b;
        sums.ab += p.a * weighted_b;
        sums.aa += p.a * weighted_a;
        sums.b += weighted_b;
        sums.a += weighted_a;
        T::write(self, sums);
    }

    /// Σ g e: minus half the slope of the sum of squares at d, W²/kg, with g = 2 a d + b and e the
    /// residual.
    #[inline]
    pub fn score(&self, d: T) -> T {
        // Powers of d first: they are the same for all buckets.
        let (twice, square) = (T::TWO * d, d * d);
        let three = T::from_f64(3.0);
        self.rb + twice * self.ra - d * self.bb - three * square * self.ab - twice * square * self.aa
    }

    /// Σ g²: how much the samples say about the mass at d, W²/kg².
    #[inline]
    pub fn information(&self, d: T) -> T {
        let twice = T::TWO * d;
        self.bb + T::TWO * twice * self.ab + twice * twice * self.aa
    }

    /// Σ g, W/kg: what an error of 1 W that lasts adds to the score.
    #[inline]
    pub fn slope_sum(&self, d: T) -> T {
        self.b + T::TWO * d * self.a
    }
}

impl<T: Real> Bucket<T> for Sums<T> {
    #[inline]
    fn merge(&mut self, other: &Self) {
        self.rb += other.rb;
        self.ra += other.ra;
        self.bb += other.bb;
        self.outer += other.outer;
        self.ab += other.ab;
        self.aa += other.aa;
        self.b += other.b;
        self.a += other.a;
    }

    fn all_within(self) -> Self {
        Self { outer: T::ZERO, ..self }
    }
}

/// The windowed least-squares estimator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window<T> {
    /// The masses in question.
    pub range: MassRange<T>,
    /// The fit's residuals.
    pub noise: Noise<T>,
    /// Time between samples, s.
    pub period: T,
    /// Residuals beyond this count linearly, W ([`Noise::linear_beyond`]).
    pub linear_beyond: T,
}

/// How many buckets of scatter the fit's own noise level counts for.
const PRIOR_BUCKETS: f64 = 6.0;

/// How far below the middle the minimum is sought, in units of the range's half: as far as to no
/// mass at all, or this where that is farther. What strays a little beyond a bound is cut to it,
/// with the interval that it had.
const BELOW: f64 = 1.5;

/// How far above the middle, in the same units: so far a robot is said to be overloaded by how
/// much.
const ABOVE: f64 = 16.0;

/// Enough to halve the bracket below single precision's last digit.
const BISECTIONS: u32 = 30;

impl<T: Real> Window<T> {
    /// Variance of the score of samples that hold this much information, (W²/kg)².
    fn expected_scatter(&self, information: T) -> T {
        self.noise.density / self.period * information
    }

    /// Where Σ e² is least, in kg about the middle of the range.
    fn minimum(&self, total: &Sums<T>) -> T {
        let reach = self.range.reach();
        let least = self.range.middle().at_least(reach * T::from_f64(BELOW));
        let (mut low, mut high) = (-least, reach * T::from_f64(ABOVE));
        // [`Sums::score`] and [`Sums::information`] in powers of d: their coefficients are the same
        // at every step.
        let (linear, square, cube) =
            (T::TWO * total.ra - total.bb, T::from_f64(-3.0) * total.ab, -T::TWO * total.aa);
        let score = |d: T| ((cube * d + square) * d + linear) * d + total.rb;
        let (by_d, by_square) = (T::from_f64(4.0) * total.ab, T::from_f64(4.0) * total.aa);
        let information = |d: T| (by_square * d + by_d) * d + total.bb;
        if score(low) <= T::ZERO {
            return low;
        }
        if score(high) >= T::ZERO {
            return high;
        }
        // Newton's step from the current point, or the middle of the bracket where that would leave
        // it.
        let mut d = T::ZERO;
        for _ in 0..BISECTIONS {
            let score = score(d);
            if score > T::ZERO {
                low = d;
            } else {
                high = d;
            }
            let step = score / information(d);
            let newton = d + step;
            // A step below the last digit ends on the bracket's end: that is the minimum, not a way
            // out.
            let next = if newton >= low && newton <= high { newton } else { (low + high) * T::HALF };
            if (next - d).abs() <= T::TWO * T::EPSILON * least {
                return next;
            }
            d = next;
        }
        d
    }
}

impl<T: Real> Method<T> for Window<T> {
    type Sums = Sums<T>;

    #[inline]
    fn add(&self, sums: &mut Sums<T>, power: T, response: &Response<T>, speed: T, d: T) {
        // Eq. 18's β1 and β2 act at rest too, where no payload can be told from the standing
        // robot's other losses.
        let at_rest = speed <= T::ZERO;
        if !at_rest {
            sums.add(power, response, self.linear_beyond, d);
        }
    }

    fn weighs_by_mass(&self) -> bool {
        self.linear_beyond.is_finite()
    }

    // A function of its own, so that its loop over the buckets is compiled alone: inlined, it has
    // too few registers.
    #[inline(never)]
    fn estimate_of<'a, P>(
        &self,
        total: &Sums<T>,
        parts: impl IntoIterator<Item = P>,
        excess: T,
    ) -> MassEstimate<T>
    where
        P: IntoIterator<Item = &'a Sums<T>>,
    {
        // Zero times what is not finite is NaN.
        if T::ZERO * total.rb + T::ZERO * total.bb + T::ZERO * total.aa != T::ZERO {
            return MassEstimate::Unknown(Unknown::NotFinite);
        }
        if total.bb <= T::ZERO {
            return MassEstimate::Unknown(Unknown::NoMotion);
        }
        let d = self.minimum(total);
        let mut scatter = Scatter::default();
        for buckets in parts {
            for bucket in buckets {
                scatter.add(bucket.score(d), bucket.information(d));
            }
        }
        let information = total.information(d);
        if information <= T::ZERO {
            return MassEstimate::Unknown(Unknown::NoMotion);
        }
        let lasting = self.noise.model_std * total.slope_sum(d) / information;
        within(
            &self.range,
            d,
            scatter.half_width(
                information,
                T::ONE - total.outer / total.bb,
                T::from_f64(PRIOR_BUCKETS),
                excess * self.expected_scatter(information),
                lasting * lasting,
            ),
        )
    }

    fn surprise(&self, sums: &Sums<T>, mass: T) -> Option<T> {
        let d = mass - self.range.middle();
        let lasting = self.noise.model_std * sums.slope_sum(d);
        let variance = self.expected_scatter(sums.information(d)) + lasting * lasting;
        let surprise = sums.score(d) / (variance.sqrt() * self.noise.tail.at_least(T::ONE));
        surprise.is_finite().then_some(surprise)
    }
}
