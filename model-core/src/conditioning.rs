//! What a fit may find about the way from samples to motion, beside the filter's cutoff.

use crate::real::Real;
use crate::slip::SlipMemory;

/// All nested: [`Conditioning::PLAIN`] is the filter alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conditioning<T> {
    /// How the scrub of a turn builds up.
    pub slip: SlipMemory<T>,
    /// By how much the power is later than the speeds, s; negative: earlier.
    pub delay: T,
}

impl<T: Real> Conditioning<T> {
    /// Nothing but the filter.
    pub const PLAIN: Self = Self { slip: SlipMemory::OFF, delay: T::ZERO };

    /// Finite, and not negative where that has no meaning.
    pub fn is_sound(&self) -> bool {
        self.slip.is_sound() && self.delay.is_finite()
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> Conditioning<U> {
        Conditioning { slip: self.slip.convert(), delay: U::from_f64(self.delay.to_f64()) }
    }
}
