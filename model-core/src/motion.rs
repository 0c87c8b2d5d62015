//! What the models need to know of each wheel at one instant.

use crate::kinematics::MassMatrix;
use crate::real::Real;

/// One wheel, after filtering.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wheel<T> {
    /// w: speed, rad/s; 0 within the dead band.
    pub speed: T,
    /// a: acceleration, rad/s²; 0 within the dead band.
    pub acceleration: T,
    /// K = (M'' a): inertial torque per kilogram, N·m/kg; 0 within the dead band.
    pub inertial_torque: T,
    /// h: −1, 0 (within the dead band) or 1.
    pub direction: T,
    /// σ: share of the turn's scrub, −1 … 1, beyond that where true slip adds to it; 0 where the
    /// wheels do not scrub, within the dead band, and straight ahead.
    pub scrub: T,
    /// h of a wheel on the right, −h of one on the left; 0 where the robot has no two sides, and
    /// within the dead band.
    pub side: T,
}

/// All wheels of a robot at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion<T, const N: usize> {
    /// One entry a wheel.
    pub wheels: [Wheel<T>; N],
}

impl<T: Real, const N: usize> Motion<T, N> {
    /// From filtered speeds (rad/s) and accelerations (rad/s²).
    ///
    /// A wheel slower than `dead_band` (rad/s) is at rest: friction has no sign there, and its
    /// power is taken as 0. Without the band the sign of friction follows the noise of a
    /// standing wheel, which biases the winding loss and Coulomb friction of a fit.
    ///
    /// The scrub follows the sign of the turn; where its memory is known, [`Self::with_scrub`]
    /// takes it.
    #[inline]
    pub fn new(speed: &[T; N], acceleration: &[T; N], mass_matrix: &MassMatrix<T, N>, dead_band: T) -> Self {
        let scrub = mass_matrix.scrub(speed, dead_band);
        Self::with_scrub(speed, acceleration, &scrub, mass_matrix, dead_band)
    }

    /// The same with σ of every wheel, as [`crate::kinematics::Sides::scrub`] gives it for a share
    /// that is there.
    #[inline]
    pub fn with_scrub(
        speed: &[T; N],
        acceleration: &[T; N],
        scrub: &[T; N],
        mass_matrix: &MassMatrix<T, N>,
        dead_band: T,
    ) -> Self {
        let torque = mass_matrix.torque_per_kg(acceleration);
        let mut wheels = [Wheel::default(); N];
        let inputs = speed.iter().zip(acceleration).zip(&torque).zip(scrub).zip(mass_matrix.side());
        for (wheel, ((((&speed, &acceleration), &inertial_torque), &scrub), &side)) in
            wheels.iter_mut().zip(inputs)
        {
            let direction = if speed > T::ZERO { T::ONE } else { -T::ONE };
            *wheel = Wheel { speed, acceleration, inertial_torque, direction, scrub, side: side * direction };
        }
        // Most of the time every wheel turns: one question for all. Where one is no number, each is
        // asked.
        let slowest = speed.iter().map(|speed| speed.abs()).reduce(T::least);
        let all_turn = slowest.is_some_and(|slowest| slowest > dead_band);
        if !all_turn {
            for wheel in &mut wheels {
                // What is not a number is not at rest: it stays in, so that no model makes a power
                // of it.
                if wheel.speed.abs() <= dead_band {
                    *wheel = Wheel::default();
                }
            }
        }
        Self { wheels }
    }

    /// Adds to σ of every wheel that moves.
    pub(crate) fn add_scrub(&mut self, scrub: &[T; N]) {
        for (wheel, more) in self.wheels.iter_mut().zip(scrub) {
            if wheel.direction != T::ZERO {
                wheel.scrub += *more;
            }
        }
    }

    /// Whether any wheel turns faster than the dead band.
    #[inline]
    pub fn is_moving(&self) -> bool {
        self.wheels.iter().any(|wheel| wheel.direction != T::ZERO)
    }

    /// W̄ of Eq. 26: mean of the wheels' absolute speeds, rad/s.
    #[inline]
    pub fn mean_speed(&self) -> T {
        let mut count = T::ZERO;
        for _ in &self.wheels {
            count += T::ONE;
        }
        if count > T::ZERO { self.summed_speed() / count } else { T::ZERO }
    }

    /// N W̄: sum of the wheels' absolute speeds, rad/s.
    #[inline]
    pub fn summed_speed(&self) -> T {
        let mut sum = T::NOTHING;
        for wheel in &self.wheels {
            sum += wheel.speed.abs();
        }
        sum
    }
}
