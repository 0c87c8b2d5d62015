//! Where the wheels are, as far as effects care.

use crate::kinematics::Kinematics;
use crate::motion::Motion;
use crate::real::Real;
use crate::slip::{Rims, Slip, SlipMemory};

/// Wheels of a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// All.
    Both,
    /// Left of the centre.
    Left,
    /// Right of the centre.
    Right,
}

/// Where the wheels are, as far as effects care.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout<T, const N: usize> {
    /// Row vx of R, m: what a wheel's speed adds to the forward speed.
    pub forward: [T; N],
    /// −1 for wheels left of the centre, 1 for those right of it, 0 where a wheel is on neither
    /// side.
    pub side: [T; N],
    /// Row ω of R over its largest entry.
    pub turn: [T; N],
}

impl<T: Real, const N: usize> Layout<T, N> {
    /// From R.
    pub fn new(kinematics: &Kinematics<T, N>) -> Self {
        let [forward, _, turn] = *kinematics.rows();
        let most = turn.iter().fold(T::ZERO, |most, entry| most.at_least(entry.abs()));
        let turn = turn.map(|entry| if most > T::ZERO { entry / most } else { T::ZERO });
        // Forward turning wheels on the left turn the robot clockwise: their entry is negative.
        let mut side = [T::ZERO; N];
        for ((side, turn), forward) in side.iter_mut().zip(&turn).zip(&forward) {
            if *forward != T::ZERO {
                *side = (*turn * *forward).sign();
            }
        }
        Self { forward, side, turn }
    }

    /// Share of a scrub that is there where sliding in the turn shares the ground's grip with
    /// rolling: Δ / √((c v̄)² + Δ² + r²), as
    /// [`slip`](crate::slip) has it without its memory, c being `half_slip`. 0 where nothing turns.
    #[inline]
    pub(super) fn sliding(&self, motion: &Motion<T, N>, half_slip: T, dead_band: T) -> T {
        let memory = SlipMemory { half_slip, ..SlipMemory::OFF };
        memory.settle(&mut Slip::default(), &self.rims(motion, dead_band))
    }

    /// What the scrub of a motion is where half of it takes a slip that is greater by `share` of
    /// the fitted one.
    #[inline]
    pub fn soften(&self, motion: &mut Motion<T, N>, fitted: &SlipMemory<T>, share: T, dead_band: T) {
        let times = fitted.softened(&self.rims(motion, fitted.rest_of(dead_band)), share);
        for wheel in &mut motion.wheels {
            wheel.scrub = times * wheel.scrub;
        }
    }

    /// Δ and v̄ of [`slip`](crate::slip) by the wheels' speeds.
    #[inline]
    fn rims(&self, motion: &Motion<T, N>, rest: T) -> Rims<T> {
        let (mut turned, mut rolled) = (T::NOTHING, T::NOTHING);
        for ((turn, forward), wheel) in self.turn.iter().zip(&self.forward).zip(&motion.wheels) {
            turned += *turn * wheel.speed;
            rolled += forward.sign() * wheel.speed;
        }
        Rims { difference: turned, mean: T::HALF * rolled.abs(), rest }
    }

    /// Adds `share` to the factors of the wheels on a side.
    pub fn scale(&self, factors: &mut [T; N], side: Side, share: T) {
        for (factor, wheel_side) in factors.iter_mut().zip(&self.side) {
            let is_there = match side {
                Side::Both => true,
                Side::Left => *wheel_side < T::ZERO,
                Side::Right => *wheel_side > T::ZERO,
            };
            if is_there {
                *factor += share;
            }
        }
    }
}
