//! True slip: how much more the wheels turn the robot than it turns, by a gyro.
//!
//! Δ is the difference of the sides' wheel speeds, G the difference that the robot's own turn rate
//! would take without slip ([`Kinematics::difference_per_turn`]), and S = Δ − G what the wheels
//! slip, rad/s, positive to the left. A turn's scrub builds up by the wheels alone
//! ([`crate::slip`]), so its share s is the same on ice and on rubber; what the ground lets pass
//! shows in S only. Each wheel's share σ becomes that of s + q S, and its torque b m σ with it:
//! linear in the mass as before, so that all that stands on that (window, effects, ground that
//! adapts) stays as it is. q = 0 is the model without.
//!
//! The turn rate passes the delay and the filter of the wheel speeds. Boards have no place for it:
//! their images refuse a q.

use crate::coefficients::Robot;
use crate::conditioner::{Conditioned, Conditioner, Unfit};
use crate::conditioning::Conditioning;
use crate::effects::live::{Additions, Answer, Outside};
use crate::kinematics::Kinematics;
use crate::model::{MassRange, Model};
use crate::motion::Motion;
use crate::real::Real;
use crate::sample::Sample;
use crate::slip::TrueTurn;

/// The gyro's channel: delay and filter of the wheel speeds, which a single wheel has as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gyro<T> {
    channel: Conditioner<T, 1>,
    gain: T,
    difference_per_turn: T,
}

impl<T: Real> Gyro<T> {
    /// For samples `period_s` apart whose power is `delay` (s) after the speeds. `None` where the
    /// robot has no true slip.
    ///
    /// # Errors
    /// As [`Conditioner::new`]; a robot without two sides.
    pub fn new<const N: usize>(robot: &Robot<T, N>, delay: T, period_s: f64) -> Result<Option<Self>, Unfit> {
        let gain = robot.conditioning.true_slip;
        if gain == T::ZERO {
            return Ok(None);
        }
        if robot.mass_matrix.sides().is_none() {
            return Err(Unfit::Sides);
        }
        let kinematics = Kinematics::from_rows([[T::ONE], [T::ZERO], [T::ZERO]]).map_err(|_| Unfit::Sides)?;
        let single = Robot {
            name: robot.name,
            kinematics,
            gyration_radius: T::ONE,
            mass_matrix: kinematics.mass_matrix(T::ONE).map_err(|_| Unfit::Sides)?,
            // A turn rate has no rest: below any band it is what it is.
            dead_band: -T::ONE,
            cutoff_hz: robot.cutoff_hz,
            conditioning: Conditioning { delay, ..Conditioning::PLAIN },
            range: robot.range,
            static_power: T::ZERO,
        };
        Ok(Some(Self {
            channel: Conditioner::new(&single, period_s)?,
            gain,
            difference_per_turn: robot.kinematics.difference_per_turn(),
        }))
    }

    /// Takes the turn rate (counter-clockwise, rad/s) of a sample, `elapsed` (s) after the one
    /// before, and gives back the sample as the wheels' conditioner has to have it: one without a
    /// turn rate is as one without a power, and leaves no trace in either.
    pub fn push<const N: usize>(
        &mut self,
        sample: &Sample<T, N>,
        turn_rate: T,
        elapsed: T,
    ) -> (Sample<T, N>, Option<TrueTurn<T>>) {
        // 0, or NaN where any value is not finite.
        let zero = sample.zero_if_finite() + turn_rate * T::ZERO;
        let sample = Sample { power: sample.power + zero, ..*sample };
        let turn_sample = Sample { wheel_speed: [turn_rate], wheel_acceleration: None, power: sample.power };
        let turn = self.channel.push(&turn_sample, elapsed).map(|now| {
            let [channel] = now.motion.wheels;
            TrueTurn { gain: self.gain, difference: self.difference_per_turn * channel.speed }
        });
        (sample, turn)
    }
}

/// A conditioner of logs, which may have a gyro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GyroConditioner<T, const N: usize> {
    wheels: Conditioner<T, N>,
    gyro: Option<Gyro<T>>,
}

impl<T: Real, const N: usize> GyroConditioner<T, N> {
    /// For samples `period_s` apart of this robot.
    ///
    /// # Errors
    /// As [`Conditioner::new`]; true slip of a robot without two sides.
    pub fn new(robot: &Robot<T, N>, period_s: f64) -> Result<Self, Unfit> {
        Ok(Self {
            wheels: Conditioner::new(robot, period_s)?,
            gyro: Gyro::new(robot, robot.conditioning.delay, period_s)?,
        })
    }

    /// Takes one sample with the robot's turn rate (counter-clockwise, rad/s), `elapsed` (s) after
    /// the one before. `None` as of
    /// [`Conditioner::push`], and where the robot has true slip but the sample no turn rate.
    pub fn push(&mut self, sample: &Sample<T, N>, turn_rate: T, elapsed: T) -> Option<Conditioned<T, N>> {
        let Some(gyro) = &mut self.gyro else { return self.wheels.push(sample, elapsed) };
        let (sample, turn) = gyro.push(sample, turn_rate, elapsed);
        self.wheels.condition::<false>(&sample, elapsed, turn.as_ref()).map(|(conditioned, _)| conditioned)
    }
}

/// A gyro with or without effects: what an estimator needs for true slip.
#[derive(Debug)]
pub struct WithGyro<'a, E: ?Sized, T, const N: usize> {
    effects: &'a mut E,
    gyro: &'a mut Gyro<T>,
    turn_rate: T,
    sample: Sample<T, N>,
    turn: Option<TrueTurn<T>>,
}

impl<'a, E: ?Sized, T: Real, const N: usize> WithGyro<'a, E, T, N> {
    /// For the next sample, of which the gyro says this turn rate (counter-clockwise, rad/s).
    pub fn new(effects: &'a mut E, gyro: &'a mut Gyro<T>, turn_rate: T) -> Self {
        let sample = Sample { wheel_speed: [T::ZERO; N], wheel_acceleration: None, power: T::NAN };
        Self { effects, gyro, turn_rate, sample, turn: None }
    }
}

impl<E: Additions<T, N> + ?Sized, T: Real, const N: usize> Additions<T, N> for WithGyro<'_, E, T, N> {
    fn correct(&mut self, sample: &Sample<T, N>, outside: &Outside<T, N>, elapsed: T) {
        self.effects.correct(sample, outside, elapsed);
        (self.sample, self.turn) = self.gyro.push(self.effects.corrected(sample), self.turn_rate, elapsed);
    }

    fn corrected<'a>(&'a self, _: &'a Sample<T, N>) -> &'a Sample<T, N> {
        &self.sample
    }

    fn true_turn(&self) -> Option<&TrueTurn<T>> {
        self.turn.as_ref()
    }

    fn follow(&mut self, motion: &Motion<T, N>, range: &MassRange<T>, d: T) {
        self.effects.follow(motion, range, d);
    }

    fn respond(&self, model: &Model<T>, now: &Conditioned<T, N>, range: &MassRange<T>, d: T) -> Answer<T> {
        self.effects.respond(model, now, range, d)
    }
}
