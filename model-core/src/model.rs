//! One model of the actuation power, whichever was fitted.

use crate::eq18::{self, Gate, REGRESSORS};
use crate::motion::Motion;
use crate::polynomial::Polynomial;
use crate::real::Real;
use crate::torque::{Drive, TorqueModel};

/// The masses that the robot can have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassRange<T> {
    no_load: T,
    full_load: T,
    middle: T,
    reach: T,
}

impl<T: Real> MassRange<T> {
    /// From the total mass without payload to that with the full one, kg. `None` unless 0 < no load
    /// < full load and both are finite.
    pub fn new(no_load: T, full_load: T) -> Option<Self> {
        let valid = no_load > T::ZERO && full_load > no_load && full_load.is_finite();
        let (middle, reach) = ((no_load + full_load) * T::HALF, (full_load - no_load) * T::HALF);
        valid.then_some(Self { no_load, full_load, middle, reach })
    }

    /// Total mass without payload, kg.
    pub fn no_load(&self) -> T {
        self.no_load
    }

    /// Total mass with full payload, kg.
    pub fn full_load(&self) -> T {
        self.full_load
    }

    /// The middle of the range, kg: the reference about which powers are expanded.
    #[inline]
    pub fn middle(&self) -> T {
        self.middle
    }

    /// Half the range, kg.
    #[inline]
    pub fn reach(&self) -> T {
        self.reach
    }
}

/// The fitted model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Model<T> {
    /// Eq. 18 with its 15 mass-decoupled coefficients.
    Eq18 {
        /// As printed, or corrected.
        gate: Gate,
        /// β_0 … β_14.
        beta: [T; REGRESSORS],
    },
    /// The signed torque model: the default.
    Signed {
        /// Its six parameters.
        torque: TorqueModel<T>,
        /// Whether braking power is clamped.
        drive: Drive,
    },
}

/// The power as a function of the mass at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response<T> {
    /// About the middle of the mass range.
    pub polynomial: Polynomial<T>,
    /// Some wheel may be clamped for some mass of the range: the polynomial says nothing reliable
    /// about the mass.
    pub may_clamp: bool,
}

impl<T: Real> Model<T> {
    /// P(m) about the middle of `range` (Eq. 24 for Eq. 18's models).
    #[inline]
    pub fn response<const N: usize>(&self, motion: &Motion<T, N>, range: &MassRange<T>) -> Response<T> {
        self.response_and_power(motion, range, T::ZERO).0
    }

    /// [`Self::response`], and with it [`Self::power`] at `d` kg beyond the middle of `range`: what
    /// the board computes for every sample. Only the caller knows what to do with a power that is
    /// not finite.
    #[inline(always)]
    pub fn response_and_power<const N: usize>(
        &self,
        motion: &Motion<T, N>,
        range: &MassRange<T>,
        d: T,
    ) -> (Response<T>, T) {
        match self {
            Model::Eq18 { gate, beta } => {
                let polynomial = eq18::power(*gate, motion, beta).about(range.middle());
                (Response { polynomial, may_clamp: false }, polynomial.at(d))
            }
            Model::Signed { torque, drive } => {
                let torque = T::read(torque);
                let mut response = Response { polynomial: Polynomial::NOTHING, may_clamp: false };
                let mut powers = [Polynomial::NOTHING; N];
                let mut least: Option<T> = None;
                for (power, wheel) in powers.iter_mut().zip(&motion.wheels) {
                    let of_wheel = torque.polynomial(wheel, range.middle(), range.reach());
                    *power = of_wheel.polynomial;
                    response.polynomial += of_wheel.polynomial;
                    least = Some(least.map_or(of_wheel.least, |least| least.least(of_wheel.least)));
                }
                let brakes = least.is_some_and(|least| least < T::ZERO);
                let may_clamp = brakes && matches!(drive, Drive::Dissipative);
                // Before the question: who weighs the sample asks for it again.
                let unclamped = response.polynomial.at(d);
                if !may_clamp {
                    return (response, unclamped);
                }
                response.may_clamp = true;
                let mut clamped = T::NOTHING;
                for power in &powers {
                    clamped += power.at(d).at_least(T::ZERO);
                }
                (response, clamped)
            }
        }
    }

    /// Step three of the paper: P_act in W at a total mass in kg. `None` where mass or motion give
    /// no finite power.
    #[inline]
    pub fn power<const N: usize>(&self, motion: &Motion<T, N>, mass: T) -> Option<T> {
        let power = match self {
            Model::Eq18 { gate, beta } => eq18::power(*gate, motion, beta).at(mass),
            Model::Signed { torque, drive } => {
                let mut sum = T::ZERO;
                for wheel in &motion.wheels {
                    let power = torque.wheel_power(wheel, mass);
                    sum += match drive {
                        Drive::Dissipative => power.at_least(T::ZERO),
                        Drive::Regenerative => power,
                    };
                }
                sum
            }
        };
        (mass > T::ZERO && power.is_finite()).then_some(power)
    }

    /// Whether every coefficient is finite and, as Eq. 20 demands, not negative; the imbalance of
    /// the sides has either sign.
    pub fn is_sound(&self) -> bool {
        let sound = |values: &[T]| values.iter().all(|value| value.is_finite() && *value >= T::ZERO);
        match self {
            Model::Eq18 { beta, .. } => sound(beta),
            Model::Signed { torque, .. } => {
                let takes_a_share = torque.gear_loss >= T::ZERO && torque.gear_loss < T::ONE;
                let is_a_share = |share: T| share >= T::ZERO && share <= T::ONE;
                let is_sound = sound(&torque.to_array()) && sound(&[torque.bridge_drop]);
                is_sound
                    && torque.imbalance.is_finite()
                    && takes_a_share
                    && is_a_share(torque.wheel_friction_share)
            }
        }
    }
}
