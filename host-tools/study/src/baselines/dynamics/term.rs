//! Torques that a wheel may have to overcome, each linear in one constant.

use model_core::effects::GRAVITY;
use model_core::motion::Wheel;

use crate::baselines::point::Point;

/// One torque of a wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// Friction of constant size: c0 sgn w.
    Coulomb,
    /// Friction in proportion to the load: c1 m sgn w.
    Rolling,
    /// Friction in proportion to the speed: b w.
    Viscous,
    /// Inertia of rotor and wheel: J a.
    Rotor,
    /// Inertia of a body of constant mass: M K, with K = (M'' a) per kilogram.
    Body,
    /// Inertia of a body whose mass is given: g m K, with g for the losses on the way.
    LoadedBody,
    /// Inertia of a body of constant mass that drives straight ahead: l v̇, with l = M r/N.
    Straight,
    /// Weight of that body along a slope: l g sin θ, with l of its own.
    Grade,
}

impl Term {
    /// Torque per unit of its constant; 0 at a wheel that stands.
    pub(super) fn torque(self, wheel: &Wheel<f64>, point: &Point) -> f64 {
        if wheel.direction == 0.0 {
            return 0.0;
        }
        match self {
            Self::Coulomb => wheel.direction,
            Self::Rolling => point.mass * wheel.direction,
            Self::Viscous => wheel.speed,
            Self::Rotor => wheel.acceleration,
            Self::Body => wheel.inertial_torque,
            Self::LoadedBody => point.mass * wheel.inertial_torque,
            Self::Straight => point.acceleration.vx,
            Self::Grade => GRAVITY * point.grade().sin(),
        }
    }

    /// Symbol and unit of its constant.
    pub(super) fn symbol(self) -> (&'static str, &'static str) {
        match self {
            Self::Coulomb => ("c0", "N m"),
            Self::Rolling => ("c1", "N m/kg"),
            Self::Viscous => ("b", "N m s"),
            Self::Rotor => ("J", "kg m²"),
            Self::Body => ("M", "kg"),
            Self::LoadedBody => ("g", "1"),
            Self::Straight => ("l", "kg m"),
            Self::Grade => ("l_grade", "kg m"),
        }
    }
}
