//! The signed torque model: torques add with their signs, and only the sum is clamped.
//!
//! τ_i = (a0 + a1 m) h_i + g2 w_i + g3 a_i + g4 m K_i in N·m, drive efficiency folded in, and
//! P_act = Σ_i max(0, τ_i w_i + κ τ_i²). A drive that feeds braking power back has no max.

use crate::eq18::REGRESSORS;
use crate::motion::Wheel;
use crate::polynomial::Polynomial;
use crate::real::Real;

/// How many physical parameters there are.
pub const PARAMETERS: usize = 6;

/// The six physical parameters, all at least 0.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TorqueModel<T> {
    /// a0: Coulomb torque of motor and gear, N·m.
    pub coulomb: T,
    /// a1: rolling resistance torque per kilogram, N·m/kg.
    pub rolling: T,
    /// g2: viscous torque, N·m·s/rad.
    pub viscous: T,
    /// g3: inertia of the rotor as the wheel sees it, kg·m².
    pub rotor_inertia: T,
    /// g4: how much of the body's inertial torque the drive has to supply; 1 / efficiency, dimensionless.
    pub inertia_gain: T,
    /// κ: winding loss, W/(N·m)².
    pub winding_loss: T,
}

/// Name, unit and meaning of each parameter in the order of [`TorqueModel::to_array`].
pub const PARAMETER_NAMES: [(&str, &str); PARAMETERS] = [
    ("coulomb", "N·m"),
    ("rolling", "N·m/kg"),
    ("viscous", "N·m·s/rad"),
    ("rotor_inertia", "kg·m²"),
    ("inertia_gain", "1"),
    ("winding_loss", "W/(N·m)²"),
];

/// Whether the drive can feed power back into the supply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// Braking power is burnt in the drive: each wheel draws at least nothing.
    Dissipative,
    /// Braking power returns to the supply: a wheel may draw less than nothing.
    Regenerative,
}

/// What one wheel draws as a function of the mass, and whether that is beyond doubt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPower<T> {
    /// Power about the reference mass, before any clamp.
    pub polynomial: Polynomial<T>,
    /// The torque opposes the motion at some mass of the range: the drive may clamp.
    pub may_clamp: bool,
}

impl<T: Real> TorqueModel<T> {
    /// In the order of [`PARAMETER_NAMES`].
    pub fn from_array(values: [T; PARAMETERS]) -> Self {
        let [coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss] = values;
        Self { coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss }
    }

    /// In the order of [`PARAMETER_NAMES`].
    pub fn to_array(self) -> [T; PARAMETERS] {
        [self.coulomb, self.rolling, self.viscous, self.rotor_inertia, self.inertia_gain, self.winding_loss]
    }

    /// The torque of one wheel in N·m at a total mass in kg.
    #[inline]
    pub fn torque(&self, wheel: &Wheel<T>, mass: T) -> T {
        (self.coulomb + self.rolling * mass) * wheel.direction
            + self.viscous * wheel.speed
            + self.rotor_inertia * wheel.acceleration
            + self.inertia_gain * mass * wheel.inertial_torque
    }

    /// The power of one wheel in W at a total mass in kg, before any clamp.
    #[inline]
    pub fn wheel_power(&self, wheel: &Wheel<T>, mass: T) -> T {
        let torque = self.torque(wheel, mass);
        torque * (wheel.speed + self.winding_loss * torque)
    }

    /// The power of one wheel as a polynomial of d = m − `reference`, |d| ≤ `reach` being the masses in question.
    #[inline]
    pub fn polynomial(&self, wheel: &Wheel<T>, reference: T, reach: T) -> WheelPower<T> {
        let torque = self.torque(wheel, reference);
        let per_kg = self.rolling * wheel.direction + self.inertia_gain * wheel.inertial_torque;
        let loss = self.winding_loss * torque;
        let polynomial = Polynomial {
            a: self.winding_loss * per_kg * per_kg,
            b: per_kg * (wheel.speed + loss + loss),
            c: torque * (wheel.speed + loss),
        };
        // Torque is linear in the mass: its least along the motion is at one end of the range.
        let least = torque * wheel.direction - (per_kg * reach).abs();
        WheelPower { polynomial, may_clamp: least < T::ZERO }
    }

    /// β_0 … β_14 of the ungated Eq. 18 ([`crate::eq18::Gate::Signed`]) that equal this model away from the clamp.
    pub fn expand(&self) -> [T; REGRESSORS] {
        let [a0, a1, g2, g3, g4, k] = self.to_array();
        let two = T::TWO;
        let lift = T::ONE + two * k * g2;
        [
            k * a0 * a0,
            two * k * a0 * a1,
            k * a1 * a1,
            g2 * (T::ONE + k * g2),
            k * g3 * g3,
            k * g4 * g4,
            a0 * lift,
            a1 * lift,
            two * k * a0 * g3,
            two * k * a1 * g3,
            two * k * a0 * g4,
            two * k * a1 * g4,
            g3 * lift,
            g4 * lift,
            two * k * g3 * g4,
        ]
    }

    /// ∂β_j/∂θ_p of [`Self::expand`]: one row a product, one column a parameter.
    pub fn expansion_jacobian(&self) -> [[T; PARAMETERS]; REGRESSORS] {
        let [a0, a1, g2, g3, g4, k] = self.to_array();
        let (o, two) = (T::ZERO, T::TWO);
        let lift = T::ONE + two * k * g2;
        [
            [two * k * a0, o, o, o, o, a0 * a0],
            [two * k * a1, two * k * a0, o, o, o, two * a0 * a1],
            [o, two * k * a1, o, o, o, a1 * a1],
            [o, o, lift, o, o, g2 * g2],
            [o, o, o, two * k * g3, o, g3 * g3],
            [o, o, o, o, two * k * g4, g4 * g4],
            [lift, o, two * k * a0, o, o, two * g2 * a0],
            [o, lift, two * k * a1, o, o, two * g2 * a1],
            [two * k * g3, o, o, two * k * a0, o, two * a0 * g3],
            [o, two * k * g3, o, two * k * a1, o, two * a1 * g3],
            [two * k * g4, o, o, o, two * k * a0, two * a0 * g4],
            [o, two * k * g4, o, o, two * k * a1, two * a1 * g4],
            [o, o, two * k * g3, lift, o, two * g2 * g3],
            [o, o, two * k * g4, o, lift, two * g2 * g4],
            [o, o, o, two * k * g4, two * k * g3, two * g3 * g4],
        ]
    }
}
