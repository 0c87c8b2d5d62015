//! Step two of the paper: the unknown mass, from what the samples say about it.
//!
//! Samples are summed into buckets (a second, say); a [`schedule::Schedule`] decides which buckets
//! count; an estimator turns them into a mass with an interval, or says that it is unknown.
//! [`roots`] is the paper's weighted mean of Eq. 24's roots, [`window`] least squares over all
//! samples of the window. [`change`] detects a new payload.

pub mod change;
pub(crate) mod interval;
pub mod ring;
pub mod roots;
pub mod schedule;
pub mod spread;
pub mod window;

use crate::model::Response;
use crate::real::Real;

/// The total mass, robot and payload, or the reason why there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MassEstimate<T> {
    /// The samples determine the mass.
    Known(Mass<T>),
    /// They say that it lies beyond the robot's range.
    Beyond(Beyond<T>),
    /// They do not.
    Unknown(Unknown),
}

impl<T: Copy> MassEstimate<T> {
    /// The mass, where it is known; the nearest end of the range where it lies beyond.
    pub fn known(&self) -> Option<Mass<T>> {
        match self {
            MassEstimate::Known(mass) => Some(*mass),
            MassEstimate::Beyond(beyond) => Some(beyond.mass),
            MassEstimate::Unknown(_) => None,
        }
    }

    /// What explains the samples best, kg: beyond the range where the mass lies there.
    pub fn best(&self) -> Option<T> {
        match self {
            MassEstimate::Known(mass) => Some(mass.mass),
            MassEstimate::Beyond(beyond) => Some(beyond.best),
            MassEstimate::Unknown(_) => None,
        }
    }

    /// Where the mass lies, where it is known.
    pub fn place(&self) -> Option<Place> {
        match self {
            MassEstimate::Known(_) => Some(Place::Within),
            MassEstimate::Beyond(beyond) => Some(beyond.place),
            MassEstimate::Unknown(_) => None,
        }
    }
}

/// Where a mass lies, seen from the robot's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// In it, as far as the samples can tell.
    Within,
    /// Lighter than without payload.
    Below,
    /// Heavier than with the full one.
    Above,
}

/// A total mass beyond the robot's range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beyond<T> {
    /// On which side.
    pub place: Place,
    /// The nearest end of the range, kg, with an interval from there to as far as the mass may lie
    /// beyond it.
    pub mass: Mass<T>,
    /// What explains the samples best, kg.
    pub best: T,
}

/// A total mass with its 95 % interval, all in kg. The mass is within the robot's range; its
/// interval is, unless the samples are explained better by a mass beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass<T> {
    /// The estimate.
    pub mass: T,
    /// Lower end of the interval.
    pub low: T,
    /// Upper end of the interval.
    pub high: T,
}

/// Why the mass is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// No samples yet, or no coefficients.
    NoSamples,
    /// The robot stood still, or its drives were clamped: nothing in the samples depends on the
    /// mass.
    NoMotion,
    /// The interval would be wider than half the mass range.
    TooWide,
    /// A sum is not finite.
    NotFinite,
    /// The coefficients come from one payload or one speed only:
    /// [`crate::coefficients::Coefficients::identifies_mass`].
    NotIdentifiable,
}

/// How far measured power strays from the model's, as the fit found it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Noise<T> {
    /// Residual's spectral density at frequency 0, W²·s: its variance times twice its correlation
    /// time.
    pub density: T,
    /// Standard deviation of the error that lasts longer than a window, W: what the coefficients'
    /// own uncertainty does to the predicted power.
    pub model_std: T,
    /// How much larger than by the density the rare scatter of a few seconds is, at least 1: a
    /// change of payload has to stand out of that.
    pub tail: T,
    /// Standard deviation of most samples' residuals behind the filter, W; 0 where nobody told it
    /// (coefficients from before): then by the density.
    pub residual_std: T,
}

/// Residuals beyond so many standard deviations count linearly. Derived: with normal noise the
/// estimate has 95 % of the efficiency of least squares (Huber 1964). Hard starts, at which no
/// model of filtered signals is right, lie far beyond.
const HUBER: f64 = 1.345;

/// Bandwidth in which a fifth-order Butterworth filter passes as much white noise as an ideal one,
/// in units of its cutoff: (π / 10) / sin(π / 10).
const NOISE_BANDWIDTH: f64 = 1.016_6;

impl<T: Real> Noise<T> {
    /// What white noise of the density leaves behind a filter of this cutoff, Hz: standard
    /// deviation, W.
    pub fn filtered_std(&self, cutoff_hz: T) -> T {
        (T::from_f64(2.0 * NOISE_BANDWIDTH) * cutoff_hz * self.density).sqrt()
    }

    /// Residuals beyond this count linearly, not squared, W. Where the usual residual is not
    /// known, it is that of white noise. Always squared where neither is known.
    pub fn linear_beyond(&self, cutoff_hz: T) -> T {
        let told = self.residual_std > T::ZERO;
        let std = if told { self.residual_std } else { self.filtered_std(cutoff_hz) };
        if std > T::ZERO { T::from_f64(HUBER) * std } else { T::INFINITY }
    }
}

/// What a sample with this residual counts for, both in W. 1 where the residual is no number:
/// nothing is known to be wrong with it.
#[inline(always)]
pub fn huber<T: Real>(residual: T, linear_beyond: T) -> T {
    let size = residual.abs();
    if size > linear_beyond { linear_beyond / size } else { T::ONE }
}

/// Sums over the samples of a bucket.
pub trait Bucket<T>: Copy + Default {
    /// Adds the other's sums.
    fn merge(&mut self, other: &Self);

    /// The same sums, as if none of their samples had been beyond the noise.
    #[must_use]
    fn all_within(self) -> Self {
        self
    }
}

/// The sums of all these buckets together, given in parts.
#[inline]
pub fn total<'a, T, S, P>(parts: impl IntoIterator<Item = P>) -> S
where
    S: Bucket<T> + 'a,
    P: IntoIterator<Item = &'a S>,
{
    let mut total = S::default();
    for buckets in parts {
        for bucket in buckets {
            total.merge(bucket);
        }
    }
    total
}

/// A way to turn samples into a mass.
pub trait Method<T: Real> {
    /// Its sums over the samples of a bucket.
    type Sums: Bucket<T>;

    /// Adds one sample: filtered power in W, the model's response, the wheels' absolute speeds in
    /// rad/s, their mean or their sum (what they are divided by is divided out again, Eq. 26), and
    /// the mass known now, kg beyond the middle of the range; no number while it is unknown.
    fn add(&self, sums: &mut Self::Sums, power: T, response: &Response<T>, speed: T, d: T);

    /// Whether what a sample counts for depends on the mass known now.
    fn weighs_by_mass(&self) -> bool {
        false
    }

    /// The mass that these buckets, oldest first, say.
    fn estimate<'a>(&self, buckets: impl Iterator<Item = &'a Self::Sums> + Clone) -> MassEstimate<T>
    where
        Self::Sums: 'a,
    {
        self.estimate_of(&total([buckets.clone()]), [buckets], T::ONE)
    }

    /// The same for whoever has the buckets' [`total`] already, and the buckets in consecutive
    /// parts: a loop over a slice costs less than one over two that are chained. `excess` is the
    /// ratio of the residual's variance to that of the fit's noise ([`spread::Spread`]).
    fn estimate_of<'a, P>(
        &self,
        total: &Self::Sums,
        parts: impl IntoIterator<Item = P>,
        excess: T,
    ) -> MassEstimate<T>
    where
        P: IntoIterator<Item = &'a Self::Sums>,
        Self::Sums: 'a;

    /// How many standard deviations of the fit's noise this bucket lies above what `mass` (kg)
    /// makes expect; `None` where it says nothing.
    fn surprise(&self, sums: &Self::Sums, mass: T) -> Option<T>;
}
