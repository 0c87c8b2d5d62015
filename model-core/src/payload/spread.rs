//! How much more the residual scatters than the fit found: sensors age, and drives differ.

use crate::real::Real;

/// Buckets for which the fit's own noise stands, at the start.
const PRIOR: f64 = 6.0;

/// Buckets over which the scatter is remembered: a minute and a half of seconds, of which one in a
/// few says nothing.
const MEMORY: f64 = 60.0;

/// A square counts for at most so many times the mean of those before: three standard deviations.
/// One outlier, or the one step between a payload and the next, is no noise.
const MOST: f64 = 9.0;

/// Ratios up to this one are chance: over [`MEMORY`] buckets of normal noise, whose neighbours'
/// differences are correlated, the ratio's own standard deviation is √(3 / 60) = 0.22.
const CHANCE: f64 = 1.5;

/// The ratio of the residual's variance to what the fit's noise makes expect, from the buckets'
/// surprises.
///
/// Half the mean square of the differences of neighbours: a lasting surprise, as another payload
/// brings, adds to one of them only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread<T> {
    ratio: T,
    weight: T,
    /// NaN where no bucket is before this one.
    last: T,
}

impl<T: Real> Default for Spread<T> {
    fn default() -> Self {
        Self { ratio: T::ONE, weight: T::from_f64(PRIOR), last: T::NAN }
    }
}

impl<T: Real> Spread<T> {
    /// Takes the surprise of a bucket, in standard deviations by the fit's noise.
    pub fn push(&mut self, surprise: T) {
        let difference = surprise - self.last;
        let square = T::HALF * difference * difference;
        // The first one has no neighbour.
        let square = if square.is_finite() { square } else { surprise * surprise };
        self.last = surprise;
        if !square.is_finite() {
            return;
        }
        let most = T::from_f64(MOST) * self.ratio;
        self.weight = (self.weight + T::ONE).at_most(T::from_f64(MEMORY));
        self.ratio += (square.at_most(most) - self.ratio) / self.weight;
    }

    /// Does not compare the next surprise with the last: the payload has changed.
    pub fn forget_last(&mut self) {
        self.last = T::NAN;
    }

    /// Enough buckets were seen to detect an excess: as many as the fit's own noise stands for.
    pub fn is_known(&self) -> bool {
        self.weight >= T::from_f64(2.0 * PRIOR)
    }

    /// The ratio of variances where it is above chance, else 1: drives in which little happens are
    /// no better sensors.
    pub fn excess(&self) -> T {
        if self.ratio > T::from_f64(CHANCE) { self.ratio } else { T::ONE }
    }
}
