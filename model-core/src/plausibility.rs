//! Whether coefficients can be those of a robot at all: a valid checksum says only that they
//! arrived as they were sent.
//!
//! Two questions. Is every number one that some robot has? And can the estimator ever know the mass
//! with them? Where the model does not depend on the mass, or its noise is wider than the payload,
//! it would say "unknown" for ever, and blame the drive.

use crate::coefficients::{Coefficients, Robot};
use crate::effects::{Cause, Columns, Term};
use crate::model::{MassRange, Model};
use crate::motion::Motion;
use crate::payload::Noise;
use crate::real::Real;
use crate::slip::Slip;
use crate::torque::TorqueModel;

/// More than any robot on wheels draws at ordinary speed, W.
pub const MOST_POWER: f64 = 1e5;
/// No robot is heavier, kg.
pub const MOST_MASS: f64 = 1e5;
/// Nor lighter, kg. It also keeps the polynomials of the mass within single precision.
pub const LEAST_MASS: f64 = 1e-3;
/// The full payload is at least this share of the robot's mass: no power sensor resolves less, an
/// INA219 errs by 0.5 % (datasheet, 7.5).
pub const LEAST_PAYLOAD: f64 = 1e-3;
/// Wheels that turn this fast are in motion whatever the robot, rad/s: dead bands are below.
pub const MOST_DEAD_BAND: f64 = 1.0;
/// No wheel's radius, nor radius of gyration, is longer, m.
pub const MOST_LENGTH: f64 = 100.0;
/// No driven wheel moves its robot by less a radian, m; nor is a radius of gyration shorter.
pub const LEAST_LENGTH: f64 = 1e-4;
/// A slower filter settles, two periods of its cutoff, only after most of a window of 25 s, and at
/// 200 Hz single precision loses 0.4 % of the power in it; at half of this, 3 %. Hz.
pub const LEAST_CUTOFF: f64 = 0.1;

/// A gear passes this share of what it gets, at least, in either direction.
pub const LEAST_GEAR_EFFICIENCY: f64 = 0.5;
/// Greatest loss of a gear by its load: with efficiency η, 1 + e of the load is 1 / η of it where
/// the motor drives, and 1 − e is η where the load does, but for a common factor.
pub const MOST_GEAR_LOSS: f64 = (1.0 - LEAST_GEAR_EFFICIENCY * LEAST_GEAR_EFFICIENCY)
    / (1.0 + LEAST_GEAR_EFFICIENCY * LEAST_GEAR_EFFICIENCY);
/// A turn on nearly the spot, dimensionless: scrub that is only half there at such a slip is none.
pub const MOST_HALF_SLIP: f64 = 10.0;
/// A tyre that rolls so far before its side force is there is none, rad of the wheel.
pub const MOST_RELAXATION: f64 = 1e3;
/// No sensor is later, s.
pub const MOST_DELAY: f64 = 10.0;
/// No sensor shows less than a tenth or more than ten times what it measures.
pub const MOST_FACTOR: f64 = 10.0;
/// No power sensor is quieter, W²·s: a digit of an INA219, 0.5 mW at 5 V and 0.1 Ω, is 1e-10 at 200
/// Hz. In single precision the evidence of ground that adapts would overflow.
pub const LEAST_DENSITY: f64 = 1e-12;

/// The window in which a mass is sought, s: the board's.
const WINDOW: f64 = 25.0;

/// What it is that no robot has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Implausible {
    /// A number of the robot, of its noise or of an effect, or a power that no robot draws.
    Value,
    /// A filter slower than [`LEAST_CUTOFF`].
    Cutoff,
    /// The mass would stay unknown however the robot drives: the model does not depend on it, or
    /// its noise is wider than the payload.
    Mass,
}

/// Wheel speeds at which the power is asked for, rad/s.
const SPEEDS: [f64; 2] = [1.0, 10.0];
/// Wheel accelerations at which it is, rad/s².
const ACCELERATIONS: [f64; 3] = [-1.0, 0.0, 1.0];

/// How fast wheels are asked whether their power depends on the mass, rad/s, and how they speed up
/// meanwhile, rad/s²: up to what few robots do, 3 m/s and 1 m/s² on wheels of 0.1 m, so that none
/// is refused for being slow.
const FAST: [[f64; 2]; 4] = [[1.0, 0.0], [10.0, 0.0], [10.0, 10.0], [30.0, 10.0]];

impl<T: Real, const N: usize> Coefficients<T, N> {
    /// Whether lengths, masses and noise are those of some robot, and so are the powers that the
    /// model gives for slow and fast wheels, straight and on the spot, at both ends of the mass
    /// range; and whether the mass can ever be known, where they say that it can. Overflow is not
    /// plausible.
    ///
    /// # Errors
    /// The first thing that no robot has.
    pub fn check_plausible(&self) -> Result<(), Implausible> {
        // Images hold finite numbers.
        if self.robot.cutoff_hz < T::from_f64(LEAST_CUTOFF) {
            return Err(Implausible::Cutoff);
        }
        if !(self.robot.is_plausible()
            && self.noise.is_plausible()
            && self.columns.are_plausible()
            && self.has_plausible_sides()
            && self.has_plausible_gears()
            && self.has_plausible_powers())
        {
            return Err(Implausible::Value);
        }
        // The plain estimator has the buckets' own scatter where the fit tells of no noise; ground
        // that adapts has not.
        if self.ground_adapts && self.noise.density < T::from_f64(LEAST_DENSITY) {
            return Err(Implausible::Value);
        }
        if !self.identifies_mass || self.may_know_the_mass() { Ok(()) } else { Err(Implausible::Mass) }
    }

    /// [`Self::check_plausible`], for whoever does not ask why.
    #[must_use]
    pub fn is_plausible(&self) -> bool {
        self.check_plausible().is_ok()
    }

    /// Whether there is a motion that, kept up for a window, would give the mass with a 95 %
    /// interval within the range: by the noise of that window and by the error that outlasts it.
    fn may_know_the_mass(&self) -> bool {
        let (range, noise) = (&self.robot.range, &self.noise);
        let model = match self.model {
            // What ground may take as well does not part the mass from it.
            Model::Signed { torque, drive } if self.ground_adapts => {
                Model::Signed { torque: TorqueModel { rolling: T::ZERO, scrub: T::ZERO, ..torque }, drive }
            }
            model => model,
        };
        let [_, _, turn] = self.robot.kinematics.rows();
        let patterns = [[T::ONE; N], turn.map(T::sign)];
        patterns.iter().any(|pattern| {
            FAST.iter().any(|&[speed, acceleration]| {
                let motion = self.robot.settled_motion(
                    &pattern.map(|sign| sign * T::from_f64(speed)),
                    &pattern.map(|sign| sign * T::from_f64(acceleration)),
                );
                let power = model.response(&motion, range).polynomial;
                [-range.reach(), T::ZERO, range.reach()].iter().any(|d| {
                    let slope = power.slope(*d);
                    let noisy = noise.density / (slope * slope * T::from_f64(WINDOW));
                    let lasting = noise.model_std / slope;
                    let half_width = T::from_f64(NORMAL_95) * (noisy + lasting * lasting).sqrt();
                    // False where the slope is 0, or no number.
                    half_width <= range.reach()
                })
            })
        })
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

    /// They give back some of what passes them.
    fn has_plausible_gears(&self) -> bool {
        match &self.model {
            Model::Signed { torque, .. } => torque.gear_loss <= T::from_f64(MOST_GEAR_LOSS),
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

/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.96;

impl<T: Real, const N: usize> Robot<T, N> {
    /// The motion where it has lasted: scrub is all there.
    // Asked once an image: not laid out anew in each of its two loops.
    #[inline(never)]
    fn settled_motion(&self, speed: &[T; N], acceleration: &[T; N]) -> Motion<T, N> {
        let memory = self.conditioning.slip;
        match self.mass_matrix.sides() {
            Some(sides) if !memory.is_off() => {
                let rims = sides.rims(speed, memory.rest_of(self.dead_band));
                let scrub = sides.scrub(memory.settle(&mut Slip::default(), &rims));
                Motion::with_scrub(speed, acceleration, &scrub, &self.mass_matrix, self.dead_band)
            }
            _ => Motion::new(speed, acceleration, &self.mass_matrix, self.dead_band),
        }
    }

    fn is_plausible(&self) -> bool {
        let slip = self.conditioning.slip;
        let [ahead, sideways, _] = self.kinematics.rows();
        let farthest = ahead.iter().chain(sideways).fold(T::ZERO, |most, entry| most.at_least(entry.abs()));
        let lengths = self.kinematics.rows().iter().flatten();
        lengths.copied().all(|entry| is_within(entry, MOST_LENGTH))
            && farthest >= T::from_f64(LEAST_LENGTH)
            && is_within(self.gyration_radius, MOST_LENGTH)
            && self.gyration_radius >= T::from_f64(LEAST_LENGTH)
            && self.dead_band < T::from_f64(MOST_DEAD_BAND)
            && self.range.is_plausible()
            && self.static_power >= T::ZERO
            && is_within(self.static_power, MOST_POWER)
            && is_within(slip.half_slip, MOST_HALF_SLIP)
            && is_within(slip.relaxation, MOST_RELAXATION)
            && is_within(slip.rest, MOST_DEAD_BAND)
            && (slip.is_off() || self.mass_matrix.sides().is_some())
            && is_within(self.conditioning.delay, MOST_DELAY)
    }
}

impl<T: Real> MassRange<T> {
    fn is_plausible(&self) -> bool {
        let payload = self.full_load() - self.no_load();
        self.no_load() >= T::from_f64(LEAST_MASS)
            && self.full_load() <= T::from_f64(MOST_MASS)
            && payload >= T::from_f64(LEAST_PAYLOAD) * self.no_load()
    }
}

impl<T: Real> Columns<T> {
    /// What acts on sensors; what makes power is asked for that.
    fn are_plausible(&self) -> bool {
        let (least, most) = (T::from_f64(1.0 / MOST_FACTOR), T::from_f64(MOST_FACTOR));
        self.iter().all(|column| match column.cause {
            Cause::Scale(_) | Cause::Term(Term::Gain(_)) | Cause::HalfSlip => {
                let factor = T::ONE + column.coefficient;
                factor >= least && factor <= most
            }
            Cause::Delay => is_within(column.coefficient, MOST_DELAY),
            _ => true,
        })
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
