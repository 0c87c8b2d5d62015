//! Whether coefficients can be those of a robot at all: a valid checksum says only that they arrived as they were sent.

use crate::coefficients::{Coefficients, Robot};
use crate::model::Model;
use crate::motion::Motion;
use crate::payload::Noise;
use crate::real::Real;
use crate::slip::Slip;

/// More than any robot on wheels draws at ordinary speed, W.
pub const MOST_POWER: f64 = 1e5;
/// No robot is heavier, kg.
pub const MOST_MASS: f64 = 1e5;
/// Nor lighter, kg. It also keeps the polynomials of the mass within single precision.
pub const LEAST_MASS: f64 = 1e-3;
/// Wheels that turn this fast are in motion whatever the robot, rad/s: dead bands are below.
pub const MOST_DEAD_BAND: f64 = 1.0;
/// No wheel's radius, nor radius of gyration, is longer, m.
pub const MOST_LENGTH: f64 = 100.0;

/// A turn on nearly the spot, dimensionless: scrub that is only half there at such a slip is none.
pub const MOST_HALF_SLIP: f64 = 10.0;
/// A tyre that rolls so far before its side force is there is none, rad of the wheel.
pub const MOST_RELAXATION: f64 = 1e3;
/// No sensor is later, s.
pub const MOST_DELAY: f64 = 10.0;

/// Wheel speeds at which the power is asked for, rad/s.
const SPEEDS: [f64; 2] = [1.0, 10.0];
/// Wheel accelerations at which it is, rad/s².
const ACCELERATIONS: [f64; 3] = [-1.0, 0.0, 1.0];

impl<T: Real, const N: usize> Coefficients<T, N> {
    /// Whether lengths, masses and noise are those of some robot, and so are the powers that the model gives for slow and
    /// fast wheels, straight and on the spot, at both ends of the mass range. Overflow is not plausible.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        self.robot.is_plausible()
            && self.noise.is_plausible()
            && self.has_plausible_sides()
            && self.has_plausible_powers()
    }

    /// Friction drives no wheel on either side, whatever the robot carries.
    fn has_plausible_sides(&self) -> bool {
        match &self.model {
            Model::Signed { torque, .. } => {
                torque.imbalance == T::ZERO
                    || (torque.drags_on_both_sides(self.robot.range.no_load())
                        && self.robot.mass_matrix.sides().is_some())
            }
            Model::Eq18 { .. } => true,
        }
    }

    fn has_plausible_powers(&self) -> bool {
        let [_, _, turn] = self.robot.kinematics.rows();
        let straight = [T::ONE; N];
        let spin = turn.map(T::sign);
        let masses = [self.robot.range.no_load(), self.robot.range.full_load()];
        [straight, spin].iter().all(|pattern| {
            SPEEDS.iter().all(|speed| {
                ACCELERATIONS.iter().all(|acceleration| {
                    let motion = self.robot.settled_motion(
                        &pattern.map(|sign| sign * T::from_f64(*speed)),
                        &pattern.map(|sign| sign * T::from_f64(*acceleration)),
                    );
                    masses.iter().all(|mass| {
                        let power = self.model.power(&motion, *mass);
                        power.is_some_and(|power| is_within(power, MOST_POWER))
                            && self.has_plausible_effects(&motion, *mass)
                    })
                })
            })
        })
    }
}

impl<T: Real, const N: usize> Coefficients<T, N> {
    /// The same with effects, steep uphill, hot and late.
    fn has_plausible_effects(&self, motion: &Motion<T, N>, mass: T) -> bool {
        match self.model {
            Model::Signed { torque, drive } => {
                let worst = self.robot.powers_at_worst(torque, drive, &self.columns, motion, mass);
                self.columns.is_empty() || worst.iter().all(|power| is_within(*power, MOST_POWER))
            }
            Model::Eq18 { .. } => self.columns.is_empty(),
        }
    }
}

impl<T: Real, const N: usize> Robot<T, N> {
    /// The motion where it has lasted: scrub is all there.
    fn settled_motion(&self, speed: &[T; N], acceleration: &[T; N]) -> Motion<T, N> {
        let memory = self.conditioning.slip;
        match self.mass_matrix.sides() {
            Some(sides) if !memory.is_off() => {
                let scrub =
                    sides.scrub(memory.settle(&mut Slip::default(), &sides.rims(speed, self.dead_band)));
                Motion::with_scrub(speed, acceleration, &scrub, &self.mass_matrix, self.dead_band)
            }
            _ => Motion::new(speed, acceleration, &self.mass_matrix, self.dead_band),
        }
    }

    fn is_plausible(&self) -> bool {
        let slip = self.conditioning.slip;
        let lengths = self.kinematics.rows().iter().flatten();
        lengths.copied().all(|entry| is_within(entry, MOST_LENGTH))
            && is_within(self.gyration_radius, MOST_LENGTH)
            && self.dead_band < T::from_f64(MOST_DEAD_BAND)
            && self.range.no_load() >= T::from_f64(LEAST_MASS)
            && self.range.full_load() <= T::from_f64(MOST_MASS)
            && is_within(self.static_power, MOST_POWER)
            && is_within(slip.half_slip, MOST_HALF_SLIP)
            && is_within(slip.relaxation, MOST_RELAXATION)
            && (slip.is_off() || self.mass_matrix.sides().is_some())
            && is_within(self.conditioning.delay, MOST_DELAY)
    }
}

impl<T: Real> Noise<T> {
    /// A residual as large as the largest power, for as long as a window may be, is no model's.
    fn is_plausible(&self) -> bool {
        let largest = MOST_POWER * MOST_POWER;
        is_within(self.density, largest)
            && is_within(self.model_std, MOST_POWER)
            && is_within(self.tail, MOST_POWER)
    }
}

/// |value| ≤ most; false for NaN.
fn is_within<T: Real>(value: T, most: f64) -> bool {
    value.abs() <= T::from_f64(most)
}
