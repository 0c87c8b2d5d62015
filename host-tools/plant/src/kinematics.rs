//! How wheels and body move together while every wheel rolls without slipping.
//!
//! The plant integrates the body's twist and derives the wheels' speeds from it, so every layout is
//! the matrix of wheel speed per twist. Body frame: x forward, y to the left, turning
//! counter-clockwise.

use serde::Serialize;

/// The most driven wheels of any layout.
pub const MAX_WHEELS: usize = 4;

/// Body twist: forward m/s, leftward m/s, turn rate rad/s.
pub type Twist = [f64; 3];

/// A wheel layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kinematics {
    /// Two wheels on one axle: left, right.
    Differential,
    /// Four wheels, the two of a side geared alike: front left, front right, rear left, rear right.
    Skid,
    /// Three omni wheels at 60°, 180° and 300° from the front: front left, rear, front right.
    Omni,
    /// Four mecanum wheels, rollers in X: front left, front right, rear left, rear right.
    Mecanum,
}

/// Lengths of a layout, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Geometry {
    /// Wheel layout.
    pub kinematics: Kinematics,
    /// Wheel radius, m.
    pub wheel_radius_m: f64,
    /// Distance between left and right wheels; for omni wheels twice the distance from centre to
    /// wheel, m. For skid steer it is the effective track: the tyres' scrub is not simulated.
    pub track_m: f64,
    /// Distance between front and rear wheels (mecanum only), m.
    pub wheelbase_m: f64,
}

impl Geometry {
    /// Number of driven wheels.
    pub fn wheels(&self) -> usize {
        match self.kinematics {
            Kinematics::Differential => 2,
            Kinematics::Omni => 3,
            Kinematics::Skid | Kinematics::Mecanum => 4,
        }
    }

    /// Whether the robot can move sideways.
    pub fn holonomic(&self) -> bool {
        matches!(self.kinematics, Kinematics::Omni | Kinematics::Mecanum)
    }

    /// Wheel speed per twist, row i for wheel i: rad/s per (m/s, m/s, rad/s). Rows of missing
    /// wheels are 0.
    pub fn wheel_per_twist(&self) -> [Twist; MAX_WHEELS] {
        let half_track = self.track_m / 2.0;
        let rim: [Twist; MAX_WHEELS] = match self.kinematics {
            Kinematics::Differential => [[1.0, 0.0, -half_track], [1.0, 0.0, half_track], [0.0; 3], [0.0; 3]],
            Kinematics::Skid => {
                let (left, right) = ([1.0, 0.0, -half_track], [1.0, 0.0, half_track]);
                [left, right, left, right]
            }
            Kinematics::Omni => {
                // A wheel at angle φ drives along the tangent (−sin φ, cos φ).
                let wheel = |degrees: f64| {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    [-sin, cos, half_track]
                };
                [wheel(60.0), wheel(180.0), wheel(300.0), [0.0; 3]]
            }
            Kinematics::Mecanum => {
                let arm = half_track + self.wheelbase_m / 2.0;
                [[1.0, -1.0, -arm], [1.0, 1.0, arm], [1.0, 1.0, -arm], [1.0, -1.0, arm]]
            }
        };
        rim.map(|row| row.map(|x| x / self.wheel_radius_m))
    }

    /// The wheels' values with left and right exchanged (an omni robot's rear wheel turns the other
    /// way).
    pub fn mirrored(&self, wheels: [f64; MAX_WHEELS]) -> [f64; MAX_WHEELS] {
        let [a, b, c, d] = wheels;
        match self.kinematics {
            Kinematics::Differential | Kinematics::Skid | Kinematics::Mecanum => [b, a, d, c],
            Kinematics::Omni => [-c, -b, -a, d],
        }
    }

    /// Wheel speeds, rad/s, of a twist.
    pub fn wheel_speeds(&self, twist: Twist) -> [f64; MAX_WHEELS] {
        self.wheel_per_twist().map(|row| dot(row, twist))
    }

    /// The twist whose wheel speeds come nearest to these, rad/s. The columns of the matrix are
    /// orthogonal in every layout, so each is projected on alone.
    pub fn twist(&self, wheels: [f64; MAX_WHEELS]) -> Twist {
        let rows = self.wheel_per_twist();
        std::array::from_fn(|k| {
            let square: f64 = rows.iter().map(|row| row[k] * row[k]).sum();
            let along: f64 = rows.iter().zip(wheels).map(|(row, wheel)| row[k] * wheel).sum();
            if square > 0.0 { along / square } else { 0.0 }
        })
    }
}

pub(super) fn dot(a: Twist, b: Twist) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry(kinematics: Kinematics) -> Geometry {
        Geometry { kinematics, wheel_radius_m: 0.05, track_m: 0.4, wheelbase_m: 0.3 }
    }

    /// Back from the wheels to the body, in every layout; what wheels cannot do is no motion.
    #[test]
    fn wheels_tell_the_twist() {
        for kinematics in [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum]
        {
            let geometry = geometry(kinematics);
            let twist = [0.3, if geometry.holonomic() { -0.2 } else { 0.0 }, 0.7];
            let back = geometry.twist(geometry.wheel_speeds(twist));
            assert!(twist.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{kinematics:?} {back:?}");
        }
    }

    /// The contact point of every wheel, from rigid-body motion: v + ω × p, along the wheel's own
    /// rolling direction (for mecanum: zero velocity across the free roller).
    #[test]
    fn contact_points_do_not_slip() {
        let twist = [0.3, -0.2, 0.7];
        let [vx, vy, omega] = twist;
        // Mecanum, front left at (0.15, 0.2): its roller rolls along (1, 1)/√2, so the point slips
        // only along that line: (v + ω×p − r w x̂) · (1, −1) = 0.
        let w = geometry(Kinematics::Mecanum).wheel_speeds(twist);
        let at = |x: f64, y: f64| [vx - omega * y, vy + omega * x];
        for (i, (x, y)) in [(0.15, 0.2), (0.15, -0.2), (-0.15, 0.2), (-0.15, -0.2)].into_iter().enumerate() {
            let roller_across = if x * y > 0.0 { [1.0, -1.0] } else { [1.0, 1.0] };
            let [px, py] = at(x, y);
            let slip = (px - 0.05 * w[i]) * roller_across[0] + py * roller_across[1];
            assert!(slip.abs() < 1e-12, "mecanum wheel {i}: {slip}");
        }
        let w = geometry(Kinematics::Omni).wheel_speeds(twist);
        for (i, degrees) in [60.0_f64, 180.0, 300.0].into_iter().enumerate() {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let [px, py] = at(0.2 * cos, 0.2 * sin);
            let slip = -px * sin + py * cos - 0.05 * w[i];
            assert!(slip.abs() < 1e-12, "omni wheel {i}: {slip}");
        }
        let w = geometry(Kinematics::Skid).wheel_speeds([vx, 0.0, omega]);
        assert!((w[0] * 0.05 - (vx - 0.2 * omega)).abs() < 1e-12 && w[0] == w[2] && w[1] == w[3]);
    }
}
