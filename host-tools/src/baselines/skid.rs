//! Skid steer by instantaneous centres of rotation: what Pentzer 2022 and Effati 2023 have in common.
//!
//! Each side's contact turns about a centre of its own, on a line across the body, the slip-track B apart: twice the
//! turning radius at which the inner wheels stand. The sides' speeds are V = v ∓ ω B / 2, and a contact at the distance a from the
//! centre of its side slides over the ground at a |ω|. Two resistances follow, each a force times a speed:
//!
//! ```text
//! P = G (|V_l| + |V_r|) + μ m g a |ω|
//! ```
//!
//! with the rolling resistance and internal friction G of a side (N) and the friction μ of sliding under the weight m g. Neither
//! inertia nor braking is in it: a first-order model of longitudinal and angular speed, as Table 1 puts it. The form follows from
//! the kinematics; the full texts of both were not at hand to compare it with.

use super::{Layout, Point};
use crate::robot::{Geometry, Robot};

/// Robots with a left and a right side.
pub const LAYOUTS: &[Layout] = &[Layout::SkidSteer, Layout::Differential];

/// The slip-track B, m: the effective track of the robot's file. NaN for a robot without sides.
pub fn slip_track(robot: &Robot) -> f64 {
    match robot.geometry() {
        Geometry::DifferentialDrive { track_m, .. } | Geometry::SkidSteer { track_m, .. } => *track_m,
        Geometry::ThreeWheelOmni { .. } | Geometry::FourMecanum { .. } | Geometry::Matrix { .. } => f64::NAN,
    }
}

/// |V_l| + |V_r|, m/s, for the slip-track in m.
pub fn side_speeds(point: &Point, slip_track: f64) -> f64 {
    let (v, turn) = (point.speed.vx, 0.5 * slip_track * point.speed.omega);
    (v - turn).abs() + (v + turn).abs()
}

#[cfg(test)]
mod tests {
    use super::{side_speeds, slip_track};
    use crate::baselines::testing::{burger, drive};

    /// The Burger's wheels are its sides: 33 mm wheels, 160 mm apart.
    #[test]
    fn sides_run_at_the_speed_of_their_wheels() {
        let track = slip_track(&burger());
        assert_eq!(track, 0.16);
        for point in drive(100, |_| 0.0) {
            let wheels: f64 = point.wheels.iter().map(|wheel| 0.033 * wheel.speed.abs()).sum();
            assert!((side_speeds(&point, track) - wheels).abs() < 1e-12);
        }
    }
}
