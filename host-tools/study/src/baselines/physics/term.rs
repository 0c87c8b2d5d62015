//! Powers that a moving robot may need, each linear in one constant.

use logs::robot::chassis::Wheels;
use model_core::coefficients::MOST_WHEELS;
use model_core::effects::GRAVITY;
use model_core::motion::Wheel;

use crate::baselines::point::Point;
use crate::baselines::training::positive_part;

/// One share of the power; its constant is at least 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// Growth of the kinetic energy of translation: m max(v·v̇, 0).
    Translation,
    /// Growth of the kinetic energy of the turn: I max(ω ω̇, 0).
    Rotation,
    /// Traction resistance and all else of constant torque: c Σ |w|.
    Traction,
    /// Viscous friction and eddy currents: b Σ w².
    Viscous,
    /// Winding loss of the current that friction takes: R i_f² for each wheel that turns.
    FrictionHeat,
    /// Winding loss common to friction and inertia: 2 R i_f i_K Σ K sgn w.
    CommonHeat,
    /// Winding loss of the current that inertia takes: R i_K² Σ K².
    InertiaHeat,
    /// Wheels dragged sideways in turns: c Σ σ w.
    Scrub,
    /// Winding loss of the current that the scrub takes: R i_s² Σ σ².
    ScrubHeat,
    /// Weight along a slope: m g v sin θ.
    Grade,
    /// Decrease of friction from rest to speed: (Fs − Fc) Σ exp(−(w/vs)²) y w. With bristles only.
    Stribeck,
}

impl Term {
    /// Power per unit of its constant at a point, with the friction `bristle` of each wheel as a
    /// share of its steady size, and the Stribeck speed in rad/s.
    pub(super) fn power(self, point: &Point, bristle: &Bristles, stribeck: f64) -> f64 {
        let wheels = &point.wheels;
        let Point { speed, acceleration, .. } = point;
        let sum = |each: fn(&Wheel<f64>) -> f64| wheels.iter().map(each).sum();
        match self {
            Self::Translation => positive_part(speed.vx * acceleration.vx + speed.vy * acceleration.vy),
            Self::Rotation => positive_part(speed.omega * acceleration.omega),
            Self::Traction => wheels.iter().zip(bristle).map(|(wheel, share)| share * wheel.speed).sum(),
            Self::Viscous => sum(|wheel| wheel.speed * wheel.speed),
            Self::FrictionHeat => sum(|wheel| wheel.direction * wheel.direction),
            Self::CommonHeat => sum(|wheel| wheel.inertial_torque * wheel.direction),
            Self::InertiaHeat => sum(|wheel| wheel.inertial_torque * wheel.inertial_torque),
            Self::Scrub => sum(|wheel| wheel.scrub * wheel.speed),
            Self::ScrubHeat => sum(|wheel| wheel.scrub * wheel.scrub),
            Self::Grade => GRAVITY * speed.vx * point.grade().sin(),
            Self::Stribeck => {
                let fall = |w: f64| (-(w / stribeck).powi(2)).exp();
                let pairs = wheels.iter().zip(bristle);
                pairs.map(|(wheel, share)| fall(wheel.speed) * share * wheel.speed).sum()
            }
        }
    }

    /// Symbol and unit of its constant.
    pub(super) fn symbol(self) -> (&'static str, &'static str) {
        match self {
            Self::Translation => ("m", "kg"),
            Self::Rotation => ("I", "kg m²"),
            Self::Traction => ("Fc", "N m"),
            Self::Viscous => ("b", "N m s"),
            Self::FrictionHeat => ("R i_f²", "W"),
            Self::CommonHeat => ("2 R i_f i_K", "W/(N m/kg)"),
            Self::InertiaHeat => ("R i_K²", "W/(N m/kg)²"),
            Self::Scrub => ("Fσ", "N m"),
            Self::ScrubHeat => ("R i_σ²", "W"),
            Self::Grade => ("m_grade", "kg"),
            Self::Stribeck => ("Fs - Fc", "N m"),
        }
    }
}

/// Friction of each wheel, as a share of its steady size at that speed, −1 to 1 at constant speed.
pub(super) type Bristles = [f64; MOST_WHEELS];

/// Friction without bristles: the direction of each wheel.
pub(super) fn rigid(wheels: &Wheels) -> Bristles {
    let mut shares = Bristles::default();
    for (share, wheel) in shares.iter_mut().zip(wheels.iter()) {
        *share = wheel.direction;
    }
    shares
}
