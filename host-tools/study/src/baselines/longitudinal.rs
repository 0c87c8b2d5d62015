//! Longitudinal dynamics of a vehicle, shared by Sadrpour 2012/2013 and Quann 2020.
//!
//! The wheels push against inertia, grade and rolling resistance (aerodynamic drag is negligible at
//! the speeds of robots):
//!
//! ```text
//! P = b + F v / η,   F = m v̇ + m g sin γ + C m g cos γ sgn v
//! ```
//!
//! with the grade γ, nose up, and the drive's efficiency η. Where neither m nor η is an input,
//! three lumped constants remain, in which P is linear:
//!
//! ```text
//! P = b + f |v| cos γ + M (v̇ + g sin γ) v,   f = C m g / η,   M = m / η
//! ```
//!
//! A turn costs nothing in it. Robots that can move sideways have |v| and v̇ v of their path.

use model_core::effects::GRAVITY;

use super::baseline::Symbol;
use super::point::Point;

/// Number of lumped constants.
pub const TERMS: usize = 3;

/// b: power at rest, f: rolling resistance, M: effective mass, both at the battery.
pub const SYMBOLS: [Symbol; TERMS] = [("b", "W"), ("f", "N"), ("M", "kg")];

/// 1, |v| cos γ, (v̇ + g sin γ) v.
pub fn terms(point: &Point) -> [f64; TERMS] {
    let Point { speed, acceleration, .. } = point;
    let grade = point.grade();
    let inertial = speed.vx * acceleration.vx + speed.vy * acceleration.vy;
    [1.0, point.path_speed() * grade.cos(), inertial + GRAVITY * grade.sin() * speed.vx]
}

#[cfg(test)]
mod tests {
    use super::terms;
    use crate::baselines::testing::still;
    use model_core::kinematics::Twist;

    /// 2 kg that climb 30° at 0.5 m/s gain 2 · 9.80665 · 0.5 · 0.5 W of height and, at 0.2 m/s²,
    /// 0.2 W of speed; backwards they lose both.
    #[test]
    fn the_effective_mass_gains_energy_of_height_and_speed() {
        let mut point = still();
        point.readings.pitch = std::f64::consts::FRAC_PI_6;
        for direction in [1.0, -1.0] {
            point.speed = Twist { vx: direction * 0.5, ..Twist::default() };
            point.acceleration = Twist { vx: 0.2, ..Twist::default() };
            let [one, rolling, gain] = terms(&point);
            assert!((2.0 * gain - direction * (4.903_325 + 0.2)).abs() < 1e-12);
            assert!((rolling - 0.5 * 0.75_f64.sqrt()).abs() < 1e-12);
            assert_eq!(one, 1.0);
        }
    }
}
