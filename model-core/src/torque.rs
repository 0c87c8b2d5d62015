//! The signed torque model: torques add with their signs, and only the sum is clamped.
//!
//! τ_i = (a0 + a1 m) h_i + g2 w_i + g3 a_i + g4 m K_i in N·m, drive efficiency folded in, and
//! P_act = Σ_i max(0, τ_i w_i + κ τ_i²). A drive that feeds braking power back has no max.
//!
//! Robots whose wheels are dragged sideways in turns (skid steer) have a seventh parameter: τ_i
//! gains b m σ_i, σ_i being the wheel's share in the turn
//! ([`crate::kinematics::MassMatrix::scrub`]). The power Σ τ_i w_i then holds b m |ω|, and the
//! winding losses of a spin on the spot, which speeds alone do not explain. σ follows the sign of
//! the turn, or builds up with the distance rolled ([`crate::slip`]).
//!
//! Where the sides of a robot are not alike, Coulomb's torque is a0 − d on the left and a0 + d on
//! the right.
//!
//! A gear takes a share of what passes it, whichever way that goes: e |X|, X being the load
//! m (a1 h + g4 K + b σ) and a share φ of the friction a0 h + g2 w (and of d). Friction of the
//! motor, φ = 0, is paid before the gear; friction of the wheel, φ = 1, passes it. The motor
//! supplies X + e |X| h: more than X while it drives the wheel, less while the wheel drives it, as
//! the inner wheels of a turn and all wheels in hard braking do. g4 alone has the one direction and
//! errs by twice e in the other. As a function of the mass the power keeps the direction that X has
//! at the middle of the masses, so it stays quadratic.
//!
//! A bridge takes a voltage of its own from whatever current passes it, so P gains δ |τ|: the drop
//! over the motor's constant at the wheel is a speed, by which the wheel seems to turn faster.

use crate::eq18::REGRESSORS;
use crate::motion::{Motion, Wheel};
use crate::polynomial::Polynomial;
use crate::real::Real;

/// How many physical parameters there are that both sides share: six, and the scrub of skid-steered
/// wheels.
pub const PARAMETERS: usize = 7;

/// How many products the scrub adds to the 15 of Eq. 18.
pub const SCRUB_PRODUCTS: usize = 6;

/// The powers of the mass that multiply them.
pub const SCRUB_POWERS: [u8; SCRUB_PRODUCTS] = [1, 1, 2, 2, 1, 2];

/// The physical parameters, all at least 0 but for the imbalance.
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
    /// g4: how much of the body's inertial torque the drive has to supply; 1 / efficiency,
    /// dimensionless.
    pub inertia_gain: T,
    /// κ: winding loss, W/(N·m)².
    pub winding_loss: T,
    /// b: torque at the outermost wheels that a turn takes, per kilogram, N·m/kg; 0 for wheels that
    /// do not scrub.
    pub scrub: T,
    /// d: how much Coulomb torque the right side's wheels have beyond a0, and the left side's lack,
    /// N·m; of either sign.
    pub imbalance: T,
    /// e: share of what passes the gear that it takes, in either direction; below 1, dimensionless.
    pub gear_loss: T,
    /// δ: voltage that the bridge takes over the motor's constant at the wheel, V / (V·s/rad) =
    /// W/(N·m) = rad/s.
    pub bridge_drop: T,
    /// φ: share of the friction that does not grow with the load which acts at the wheel and so
    /// passes the gear, 0 to 1, dimensionless. Without e it means nothing.
    pub wheel_friction_share: T,
}

/// What a drive draws for its torque: τ w + κ τ² + δ |τ|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draw<T> {
    /// κ: winding loss, W/(N·m)².
    pub winding_loss: T,
    /// δ: drop of the bridge, rad/s.
    pub bridge_drop: T,
}

impl<T: Real> Draw<T> {
    /// Power of a wheel that turns at `speed` (rad/s) with `torque` (N·m), W, before any clamp.
    #[inline(always)]
    pub fn power(&self, speed: T, torque: T) -> T {
        torque * (self.apparent(speed, torque) + self.winding_loss * torque)
    }

    /// By how much that grows with the torque, W/(N·m).
    #[inline(always)]
    pub fn slope(&self, speed: T, torque: T) -> T {
        let loss = self.winding_loss * torque;
        self.apparent(speed, torque) + loss + loss
    }

    /// w + δ sgn τ, rad/s.
    #[inline(always)]
    fn apparent(&self, speed: T, torque: T) -> T {
        speed + self.bridge_drop.copysign(torque)
    }
}

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
    /// Least torque along the motion at any mass of the range, N·m.
    pub least: T,
}

impl<T: Real> WheelPower<T> {
    /// Of a wheel whose torque is `torque` (N·m) at the reference mass and grows by `per_kg`
    /// (N·m/kg), for masses up to `reach` (kg) from the reference. The bridge's drop has the
    /// torque's direction there: where another mass turns it round, the drive brakes, which a
    /// dissipative one may clamp.
    #[inline(always)]
    pub(crate) fn new(wheel: &Wheel<T>, torque: T, per_kg: T, draw: &Draw<T>, reach: T) -> Self {
        let polynomial = Polynomial {
            a: draw.winding_loss * per_kg * per_kg,
            b: per_kg * draw.slope(wheel.speed, torque),
            c: draw.power(wheel.speed, torque),
        };
        // Torque is linear in the mass: its least along the motion is at one end of the range.
        let least = torque * wheel.direction - (per_kg * reach).abs();
        Self { polynomial, least }
    }

    /// The torque opposes the motion at some mass of the range: the drive may clamp.
    #[inline]
    pub fn may_clamp(&self) -> bool {
        self.least < T::ZERO
    }
}

impl<T: Real> TorqueModel<T> {
    /// In the order of the fields, both sides being alike, gear and bridge without a loss of their
    /// own.
    pub fn from_array(values: [T; PARAMETERS]) -> Self {
        let [coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss, scrub] = values;
        Self {
            coulomb,
            rolling,
            viscous,
            rotor_inertia,
            inertia_gain,
            winding_loss,
            scrub,
            imbalance: T::ZERO,
            gear_loss: T::ZERO,
            bridge_drop: T::ZERO,
            wheel_friction_share: T::ZERO,
        }
    }

    /// The same sides, gear and bridge with these values, in the order of the fields.
    #[must_use]
    pub fn with_array(self, values: [T; PARAMETERS]) -> Self {
        let [coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss, scrub] = values;
        Self { coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss, scrub, ..self }
    }

    /// What both sides share, in the order of the fields.
    pub fn to_array(self) -> [T; PARAMETERS] {
        [
            self.coulomb,
            self.rolling,
            self.viscous,
            self.rotor_inertia,
            self.inertia_gain,
            self.winding_loss,
            self.scrub,
        ]
    }

    /// Friction drives no wheel of either side of a robot of this mass in kg, or a heavier one.
    pub fn drags_on_both_sides(&self, least_mass: T) -> bool {
        self.imbalance.abs() <= self.coulomb + self.rolling * least_mass
    }

    /// The torque of one wheel in N·m at a total mass in kg.
    #[inline]
    pub fn torque(&self, wheel: &Wheel<T>, mass: T) -> T {
        (self.coulomb + self.rolling * mass) * wheel.direction
            + self.viscous * wheel.speed
            + self.rotor_inertia * wheel.acceleration
            + mass * (self.inertia_gain * wheel.inertial_torque + self.scrub * wheel.scrub)
            + self.imbalance * wheel.side
            + self.gear_loss * self.gear_share(wheel, mass)
    }

    /// Friction that does not grow with the load, N·m.
    #[inline(always)]
    fn friction(&self, wheel: &Wheel<T>) -> T {
        self.coulomb * wheel.direction + self.viscous * wheel.speed + self.imbalance * wheel.side
    }

    /// What passes the gear to move the body, N·m/kg.
    #[inline(always)]
    fn load_per_kg(&self, wheel: &Wheel<T>) -> T {
        let load = self.rolling * wheel.direction + self.inertia_gain * wheel.inertial_torque;
        // Known to be none where no wheel scrubs: no code at all then.
        if wheel.scrub == T::ZERO { load } else { load + self.scrub * wheel.scrub }
    }

    /// X, N·m: what passes the gear at a total mass in kg.
    #[inline(always)]
    pub fn passed(&self, wheel: &Wheel<T>, mass: T) -> T {
        self.wheel_friction_share * self.friction(wheel) + mass * self.load_per_kg(wheel)
    }

    /// |X| h, N·m: what the loss of the gear multiplies.
    #[inline(always)]
    pub fn gear_share(&self, wheel: &Wheel<T>, mass: T) -> T {
        self.passed(wheel, mass).abs() * wheel.direction
    }

    /// 1 + e: what the motor supplies of a load that it drives, per unit of what passes the gear.
    pub fn driving_factor(&self) -> T {
        T::ONE + self.gear_loss
    }

    /// The same per unit of the load: all losses of motor, gear and drive that grow with it.
    pub fn load_gain(&self) -> T {
        self.inertia_gain * self.driving_factor()
    }

    /// Rolling resistance as a motor that drives supplies it, N·m/kg.
    pub fn supplied_rolling(&self) -> T {
        self.rolling * self.driving_factor()
    }

    /// Scrub as a motor that drives supplies it, N·m/kg.
    pub fn supplied_scrub(&self) -> T {
        self.scrub * self.driving_factor()
    }

    /// 1 + φ e: what the motor supplies per unit of friction that does not grow with the load.
    fn friction_factor(&self) -> T {
        T::ONE + self.wheel_friction_share * self.gear_loss
    }

    /// Coulomb torque as a motor that drives supplies it, N·m.
    pub fn supplied_coulomb(&self) -> T {
        self.coulomb * self.friction_factor()
    }

    /// Viscous torque as a motor that drives supplies it, N·m·s/rad.
    pub fn supplied_viscous(&self) -> T {
        self.viscous * self.friction_factor()
    }

    /// e in the direction of X: the slope of the loss by X. A gear at which nothing passes drives.
    #[inline(always)]
    pub fn gear_slope(&self, wheel: &Wheel<T>, mass: T) -> T {
        self.gear_loss.copysign(self.passed(wheel, mass) * wheel.direction)
    }

    /// What the motor gives its gear: [`Self::parts`] without what the rotor takes for itself.
    #[inline(always)]
    pub(crate) fn gear_input(&self, wheel: &Wheel<T>, mass: T) -> [T; 2] {
        let (friction, load) = (self.friction(wheel), self.load_per_kg(wheel));
        // Some twenty instructions that most robots need not pay for.
        if self.gear_loss == T::ZERO {
            return [friction, load];
        }
        let slope = self.gear_slope(wheel, mass);
        [friction + slope * (self.wheel_friction_share * friction), load + slope * load]
    }

    /// [`Self::torque`] as what does not depend on the mass, N·m, and what multiplies it, N·m/kg;
    /// X has the direction that it has at this mass in kg.
    #[inline(always)]
    pub(crate) fn parts(&self, wheel: &Wheel<T>, mass: T) -> [T; 2] {
        let [fixed, per_kg] = self.gear_input(wheel, mass);
        [fixed + self.rotor_inertia * wheel.acceleration, per_kg]
    }

    /// What a torque draws.
    #[inline(always)]
    pub fn draw(&self) -> Draw<T> {
        Draw { winding_loss: self.winding_loss, bridge_drop: self.bridge_drop }
    }

    /// The power of one wheel in W at a total mass in kg, before any clamp.
    #[inline]
    pub fn wheel_power(&self, wheel: &Wheel<T>, mass: T) -> T {
        self.draw().power(wheel.speed, self.torque(wheel, mass))
    }

    /// The power of one wheel as a polynomial of d = m − `reference`, |d| ≤ `reach` being the
    /// masses in question.
    #[inline(always)]
    pub fn polynomial(&self, wheel: &Wheel<T>, reference: T, reach: T) -> WheelPower<T> {
        let [fixed, per_kg] = self.parts(wheel, reference);
        let torque = fixed + reference * per_kg;
        WheelPower::new(wheel, torque, per_kg, &self.draw(), reach)
    }

    /// β_0 … β_14 of the ungated Eq. 18 ([`crate::eq18::Gate::Signed`]) that equal this model
    /// away from the clamp; scrub, imbalance and losses of gear and bridge apart.
    pub fn expand(&self) -> [T; REGRESSORS] {
        let [a0, a1, g2, g3, g4, k, _] = self.to_array();
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
        let [a0, a1, g2, g3, g4, k, _] = self.to_array();
        let (o, two) = (T::ZERO, T::TWO);
        let lift = T::ONE + two * k * g2;
        [
            [two * k * a0, o, o, o, o, a0 * a0, o],
            [two * k * a1, two * k * a0, o, o, o, two * a0 * a1, o],
            [o, two * k * a1, o, o, o, a1 * a1, o],
            [o, o, lift, o, o, g2 * g2, o],
            [o, o, o, two * k * g3, o, g3 * g3, o],
            [o, o, o, o, two * k * g4, g4 * g4, o],
            [lift, o, two * k * a0, o, o, two * g2 * a0, o],
            [o, lift, two * k * a1, o, o, two * g2 * a1, o],
            [two * k * g3, o, o, two * k * a0, o, two * a0 * g3, o],
            [o, two * k * g3, o, two * k * a1, o, two * a1 * g3, o],
            [two * k * g4, o, o, o, two * k * a0, two * a0 * g4, o],
            [o, two * k * g4, o, o, two * k * a1, two * a1 * g4, o],
            [o, o, two * k * g3, lift, o, two * g2 * g3, o],
            [o, o, two * k * g4, o, lift, two * g2 * g4, o],
            [o, o, o, two * k * g4, two * k * g3, two * g3 * g4, o],
        ]
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> TorqueModel<U> {
        let number = |value: T| U::from_f64(value.to_f64());
        TorqueModel {
            imbalance: number(self.imbalance),
            gear_loss: number(self.gear_loss),
            bridge_drop: number(self.bridge_drop),
            wheel_friction_share: number(self.wheel_friction_share),
            ..TorqueModel::from_array(self.to_array().map(number))
        }
    }

    /// Coefficients of [`scrub_products`] that add the scrub to [`Self::expand`].
    pub fn expand_scrub(&self) -> [T; SCRUB_PRODUCTS] {
        let [a0, a1, g2, g3, g4, k, b] = self.to_array();
        let two = T::TWO;
        let cross = two * k * b;
        [b * (T::ONE + two * k * g2), cross * a0, cross * a1, k * b * b, cross * g3, cross * g4]
    }

    /// Derivatives of [`Self::expand_scrub`]: one row a product, one column a parameter.
    pub fn scrub_jacobian(&self) -> [[T; PARAMETERS]; SCRUB_PRODUCTS] {
        let [a0, a1, g2, g3, g4, k, b] = self.to_array();
        let (o, two) = (T::ZERO, T::TWO);
        let (loss, cross) = (two * k, two * k * b);
        [
            [o, o, cross, o, o, two * g2 * b, T::ONE + loss * g2],
            [cross, o, o, o, o, two * a0 * b, loss * a0],
            [o, cross, o, o, o, two * a1 * b, loss * a1],
            [o, o, o, o, o, b * b, loss * b],
            [o, o, o, cross, o, two * g3 * b, loss * g3],
            [o, o, o, o, cross, two * g4 * b, loss * g4],
        ]
    }
}

/// σ w, h σ (twice: for m and m²), σ², a σ and K σ, summed over the wheels, without the powers of
/// the mass.
#[inline]
pub fn scrub_products<T: Real, const N: usize>(motion: &Motion<T, N>) -> [T; SCRUB_PRODUCTS] {
    let mut sums = [T::ZERO; SCRUB_PRODUCTS];
    for wheel in &motion.wheels {
        let s = wheel.scrub;
        let turned = s * wheel.direction;
        let products =
            [s * wheel.speed, turned, turned, s * s, s * wheel.acceleration, s * wheel.inertial_torque];
        for (sum, product) in sums.iter_mut().zip(products) {
            *sum += product;
        }
    }
    sums
}
