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
    /// q: how much of the scrub a rad/s of true slip adds, s/rad ([`crate::gyro`]); boards have
    /// none.
    pub true_slip: T,
}

impl<T: Real> Conditioning<T> {
    /// Nothing but the filter.
    pub const PLAIN: Self = Self { slip: SlipMemory::OFF, delay: T::ZERO, true_slip: T::ZERO };

    /// Finite, and not negative where that has no meaning.
    pub fn is_sound(&self) -> bool {
        self.slip.is_sound()
            && self.delay.is_finite()
            && self.true_slip.is_finite()
            && self.true_slip >= T::ZERO
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> Conditioning<U> {
        let number = |value: T| U::from_f64(value.to_f64());
        Conditioning {
            slip: self.slip.convert(),
            delay: number(self.delay),
            true_slip: number(self.true_slip),
        }
    }
}
