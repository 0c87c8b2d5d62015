//! What the filter remembers of a clamp.
//!
//! A drive takes nothing back where its wheel brakes: its power stays 0. The filter spreads this
//! clamp over some time, while the filtered speeds have long gone on. The model then expects more
//! power than is measured, or less. That would bias the mass, by a tenth and more on a robot that
//! reverses every second, so samples count for the mass only once the filter has forgotten the
//! clamp. Ground that adapts ([`crate::adapt`]) keeps them: without them the samples distinguish
//! floor and mass less well, and the mass comes out worse.

use crate::real::Real;

/// How long the filter remembers, in periods of its cutoff: a step has come through by then. Tuned
/// on `cargo xtask bench coverage`: 0.4 and 0.7 leave masses of jerky drives two to ten percent
/// off, and 2 is no better than this.
const MEMORY: f64 = 1.0;

/// Whether the filter still remembers a clamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampMemory<T> {
    /// How long the filter remembers, s.
    length: T,
    /// How much longer it remembers the last clamp, s.
    remaining: T,
}

impl<T: Real> ClampMemory<T> {
    /// For a filter with this cutoff, Hz.
    pub fn new(cutoff_hz: T) -> Self {
        Self { length: T::from_f64(MEMORY) / cutoff_hz, remaining: T::ZERO }
    }

    /// A wheel may be clamped in this sample.
    #[inline]
    pub fn clamped(&mut self) {
        self.remaining = self.length;
    }

    /// Takes a sample without a clamp, `elapsed` s after the one before: whether the filter still
    /// remembers one. Time that is no number counts as 0. The remaining time is rounded to whole
    /// samples: a length that is a multiple of the period ends with the same sample in any
    /// precision.
    #[inline]
    pub fn remembers(&mut self, elapsed: T) -> bool {
        if self.remaining == T::ZERO {
            return false;
        }
        let elapsed = T::ZERO.at_least(elapsed);
        self.remaining = T::ZERO.at_least(self.remaining - elapsed);
        self.remaining > T::HALF * elapsed
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
