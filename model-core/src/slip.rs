//! Slip memory: how far the side force of wheels that are dragged through a turn has built up.
//!
//! A tyre's side force grows with its slip angle, saturates, and follows over a distance rolled,
//! the relaxation length. With w_l and w_r the mean speeds of the sides' wheels, Δ = w_r − w_l and
//! v̄ = |w_l + w_r| / 2, one state s, |s| ≤ 1, does both:
//!
//! ```text
//! ds/dt = (Δ − s √((c v̄)² + Δ² + r²)) / (c λ)
//! ```
//!
//! In a steady curve s = Δ / √((c v̄)² + Δ² + r²): rolling and sliding share the ellipse of the
//! contact's friction. It is 1/√2 where the slip |Δ| / v̄ is c, nearly ±1 on the spot. r is the
//! difference below which a turn hardly drags: tyres yield before they slide, so a robot that
//! creeps to its rest is not dragged for the ratio of two speeds that are next to nothing. A fit
//! finds it; without it is the dead band. The implicit step s ← (c λ s + T Δ) / (c λ + T √((c
//! v̄)² + Δ² + r²)) is a mean of the state before and of that end, so it never leaves −1 … 1
//! whatever the step. c → 0 is the sign of the turn; λ → 0 the steady curve at once. (c v̄ + |Δ|
//! instead of the root saturates too slowly: 0.02 of R² on a measured Husky, 0.01 on a robot in
//! MuJoCo.)

use crate::real::Real;

/// The parameters of the memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlipMemory<T> {
    /// c: the slip |Δ| / v̄ at which 1/√2 of the scrub is there, dimensionless; 0 for the sign of
    /// the turn, without memory.
    pub half_slip: T,
    /// λ: how far a wheel turns while the scrub builds up by 1 − 1/e in a gentle curve, rad.
    pub relaxation: T,
    /// r, rad/s; 0 for the robot's dead band.
    pub rest: T,
}

/// How both sides' wheels turn at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rims<T> {
    /// Δ: right less left, rad/s.
    pub difference: T,
    /// v̄: absolute value of their mean, rad/s.
    pub mean: T,
    /// r: a difference within this is hardly a turn, rad/s.
    pub rest: T,
}

/// s: the share of the scrub that is there, −1 … 1, positive to the left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slip<T>(T);

impl<T: Real> SlipMemory<T> {
    /// No memory: the sign of the turn.
    pub const OFF: Self = Self { half_slip: T::ZERO, relaxation: T::ZERO, rest: T::ZERO };

    /// The scrub follows the sign of the turn at once.
    #[inline]
    pub fn is_off(&self) -> bool {
        self.half_slip == T::ZERO
    }

    /// Finite and not negative.
    pub fn is_sound(&self) -> bool {
        let values = [self.half_slip, self.relaxation, self.rest];
        values.iter().all(|value| value.is_finite() && *value >= T::ZERO)
    }

    /// r of a robot with this dead band, rad/s.
    pub fn rest_of(&self, dead_band: T) -> T {
        if self.rest > T::ZERO { self.rest } else { dead_band }
    }

    /// √((c v̄)² + Δ² + r²), rad/s.
    #[inline]
    fn pull(&self, rims: &Rims<T>) -> T {
        let rolled = self.half_slip * rims.mean;
        (rolled * rolled + rims.difference * rims.difference + rims.rest * rims.rest).sqrt()
    }

    /// s after `elapsed` s at these speeds. What is not finite changes nothing.
    #[inline]
    pub fn step(&self, slip: &mut Slip<T>, rims: &Rims<T>, elapsed: T) -> T {
        let inertia = self.half_slip * self.relaxation;
        let next = (inertia * slip.0 + elapsed * rims.difference) / (inertia + elapsed * self.pull(rims));
        // 0 / 0 where nothing rolls, and whatever comes of no number: the tyres stay as they are.
        if next * T::ZERO == T::ZERO {
            slip.0 = next;
        }
        slip.0
    }

    /// s as if it had been at these speeds for ever; 0 at rest.
    #[inline]
    pub fn settle(&self, slip: &mut Slip<T>, rims: &Rims<T>) -> T {
        let steady = rims.difference / self.pull(rims);
        slip.0 = if steady * T::ZERO == T::ZERO { steady } else { T::ZERO };
        slip.0
    }

    /// By how many times more of the scrub is there where c is greater by `share` of itself: as the
    /// ends of steady curves say; 1 where nothing turns, and without a memory.
    #[inline]
    pub fn softened(&self, rims: &Rims<T>, share: T) -> T {
        let softer = Self { half_slip: self.half_slip * (T::ONE + share), ..*self };
        let times = self.pull(rims) / softer.pull(rims);
        if times * T::ZERO == T::ZERO { times } else { T::ONE }
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> SlipMemory<U> {
        let number = |value: T| U::from_f64(value.to_f64());
        SlipMemory {
            half_slip: number(self.half_slip),
            relaxation: number(self.relaxation),
            rest: number(self.rest),
        }
    }
}

impl<T: Real> Slip<T> {
    /// s.
    #[inline]
    pub fn share(&self) -> T {
        self.0
    }
}

/// What a gyro says of one instant, after the filter ([`crate::gyro`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueTurn<T> {
    /// q: share of the scrub per true slip, s/rad.
    pub gain: T,
    /// G, rad/s.
    pub difference: T,
}

impl<T: Real> TrueTurn<T> {
    /// q S where the sides' wheels differ by `difference` (Δ, rad/s).
    #[inline]
    pub fn share(&self, difference: T) -> T {
        self.gain * (difference - self.difference)
    }
}
