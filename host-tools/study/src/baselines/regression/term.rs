//! Terms that the power of a robot may be linear in.

use logs::robot::{Geometry, Robot};
use model_core::effects::GRAVITY;

use crate::baselines::longitudinal;
use crate::baselines::point::Point;

/// A coefficient's symbol and unit, and what it multiplies.
pub type Listed = (&'static str, &'static str, Term);

/// What a coefficient multiplies. Speeds are the body's: v ahead, ω of the turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// 1: power at rest.
    One,
    /// Speed along the path, m/s: |v|. A robot draws the same forwards and backwards.
    Path,
    /// Its square.
    PathSquare,
    /// m, kg: what a kilogram costs at any speed.
    Mass,
    /// v.
    Speed,
    /// max(v̇, 0) v.
    Faster,
    /// min(v̇, 0) v.
    Slower,
    /// ω.
    Turn,
    /// max(ω̇, 0) ω.
    TurnFaster,
    /// min(ω̇, 0) ω.
    TurnSlower,
    /// max(sin φ, 0) v on a road of the grade φ.
    Climb,
    /// min(sin φ, 0) v.
    Descent,
    /// Rolling of the [longitudinal dynamics](longitudinal): |v| cos φ.
    Rolling,
    /// Inertia and weight of the longitudinal dynamics: (v̇ + g sin φ) v.
    Inertial,
    /// Speeds of the two sides: |V_l| + |V_r|.
    ///
    /// Each side's contact turns about a centre of its own, on a line across the body, the
    /// slip-track B apart: twice the turning radius at which the inner wheels stand. The sides'
    /// speeds are V = v ∓ ω B / 2, and a contact at the distance a from the centre of its side
    /// slides over the ground at a |ω|. The form follows from the kinematics; the full texts of
    /// both sources were not at hand to compare it with.
    Sides,
    /// Their difference: |V_r − V_l| = B |ω|.
    SideDifference,
    /// Sliding under the weight of the robot without payload: m g a |ω|, with a = B ∕ 2. Robot
    /// files do not tell where the wheels stand; a and m scale the coefficient, not the predicted
    /// power.
    Sliding,
}

/// What terms have to know of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// The slip-track B, m: the effective track of the robot's file. NaN for a robot without sides.
    pub slip_track: f64,
    /// Without payload, kg.
    pub mass_kg: f64,
}

impl Body {
    /// Of this robot.
    pub fn of(robot: &Robot) -> Self {
        let slip_track = match robot.geometry() {
            Geometry::DifferentialDrive { track_m, .. } | Geometry::SkidSteer { track_m, .. } => *track_m,
            Geometry::ThreeWheelOmni { .. } | Geometry::FourMecanum { .. } | Geometry::Matrix { .. } => {
                f64::NAN
            }
        };
        Self { slip_track, mass_kg: robot.mass_no_load_kg() }
    }
}

impl Term {
    /// Its value at a point.
    pub fn of(self, point: &Point, body: &Body) -> f64 {
        let (v, omega) = (point.speed.vx, point.speed.omega);
        let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
        match self {
            Self::One => 1.0,
            Self::Path => point.path_speed(),
            Self::PathSquare => point.path_speed() * point.path_speed(),
            Self::Mass => point.mass,
            Self::Speed => v,
            Self::Faster => up(dv) * v,
            Self::Slower => down(dv) * v,
            Self::Turn => omega,
            Self::TurnFaster => up(domega) * omega,
            Self::TurnSlower => down(domega) * omega,
            Self::Climb => up(point.grade().sin()) * v,
            Self::Descent => down(point.grade().sin()) * v,
            Self::Rolling => longitudinal::terms(point)[1],
            Self::Inertial => longitudinal::terms(point)[2],
            Self::Sides => {
                let turn = 0.5 * body.slip_track * omega;
                (v - turn).abs() + (v + turn).abs()
            }
            Self::SideDifference => body.slip_track * omega.abs(),
            Self::Sliding => body.mass_kg * GRAVITY * 0.5 * body.slip_track * omega.abs(),
        }
    }
}

/// max(value, 0), but NaN for NaN, which `f64::max` takes for 0.
fn up(value: f64) -> f64 {
    0.5 * (value + value.abs())
}

/// min(value, 0), but NaN for NaN.
fn down(value: f64) -> f64 {
    0.5 * (value - value.abs())
}

#[cfg(test)]
mod tests {
    use super::{Body, Term};
    use crate::baselines::testing::{burger, drive};

    /// The Burger's wheels are its sides: 33 mm wheels, 160 mm apart.
    #[test]
    fn sides_run_at_the_speed_of_their_wheels() {
        let body = Body::of(&burger());
        assert_eq!(body.slip_track, 0.16);
        for point in drive(100, |_| 0.0) {
            let wheels: f64 = point.wheels.iter().map(|wheel| 0.033 * wheel.speed.abs()).sum();
            assert!((Term::Sides.of(&point, &body) - wheels).abs() < 1e-12);
        }
    }
}
