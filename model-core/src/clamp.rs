//! What the filter remembers of a clamp.
//!
//! Where a wheel brakes its drive takes nothing back, and its power stays at nothing. Behind the
//! filter that part of the power is spread over some time, in which the filtered speeds have long
//! gone on: the model expects more there than is measured, or less, and the mass would pay for it,
//! by a tenth and more on a robot that reverses every second. So samples tell of the mass only once
//! the filter has let go of the clamp. Not so on ground that adapts ([`crate::adapt`]): of what
//! samples are left there, floor and mass are told apart less well, and the mass comes out worse
//! than with them.

use crate::real::Real;

/// How long the filter remembers, in periods of its cutoff: a step has come through by then. Tuned
/// on `cargo xtask bench coverage`: with 0.4 and 0.7 masses of jerky drives are still two to ten
/// percent off, with 2 no less than with this.
const MEMORY: f64 = 1.0;

/// Whether the filter still remembers a clamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampMemory<T> {
    /// How long it does, s.
    length: T,
    /// How much longer, s.
    left: T,
}

impl<T: Real> ClampMemory<T> {
    /// For a filter with this cutoff, Hz.
    pub fn new(cutoff_hz: T) -> Self {
        Self { length: T::from_f64(MEMORY) / cutoff_hz, left: T::ZERO }
    }

    /// A wheel may be clamped in this sample.
    #[inline]
    pub fn clamped(&mut self) {
        self.left = self.length;
    }

    /// Takes a sample in which no wheel is, `elapsed` s after the one before: whether one was so
    /// shortly before that the filter remembers. Time that is no number passes none. What is left
    /// is rounded to whole samples: a length that is a multiple of the period ends with the same
    /// sample in any precision.
    #[inline]
    pub fn remembers(&mut self, elapsed: T) -> bool {
        if self.left == T::ZERO {
            return false;
        }
        let elapsed = T::ZERO.at_least(elapsed);
        self.left = T::ZERO.at_least(self.left - elapsed);
        self.left > T::HALF * elapsed
    }
}

#[cfg(test)]
mod tests {
    use super::ClampMemory;

    /// A quarter of a second at 4 Hz, from the last clamp on; a gap ends it.
    #[test]
    fn a_clamp_is_remembered_for_a_period_of_the_cutoff() {
        let mut memory = ClampMemory::new(4.0_f32);
        assert!(!memory.remembers(0.08));
        memory.clamped();
        memory.clamped();
        assert!(memory.remembers(0.08) && memory.remembers(f32::NAN) && memory.remembers(0.08));
        assert!(!memory.remembers(0.08) && !memory.remembers(0.08));
        memory.clamped();
        assert!(!memory.remembers(f32::MAX));
    }
}
