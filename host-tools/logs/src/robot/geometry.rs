//! How wheel speeds become motion: the numbers of R in ζ = R w.

/// Kinematics of a robot and their dimensions, SI units.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Two driven wheels on one axle: wheel 1 left, wheel 2 right.
    DifferentialDrive {
        /// Wheel radius, m.
        wheel_radius_m: f64,
        /// Distance of the two wheels, m.
        track_m: f64,
    },
    /// Two sides that turn by driving at different speeds, with side slip.
    SkidSteer {
        /// Wheel radius, m.
        wheel_radius_m: f64,
        /// Effective distance of the two sides, m: wider than the wheels stand, because they slip.
        track_m: f64,
        /// 2: one log column a side (left, right); 4: one a wheel (front left, front right, rear
        /// left, rear right).
        wheels: usize,
    },
    /// Three omnidirectional wheels at 60°, 180° and 300° from the front, counter-clockwise: front
    /// left, rear, front right.
    ThreeWheelOmni {
        /// Wheel radius, m.
        wheel_radius_m: f64,
        /// Distance of every wheel from the centre, m.
        arm_m: f64,
    },
    /// Four mecanum wheels: front left, front right, rear left, rear right.
    FourMecanum {
        /// Wheel radius, m.
        wheel_radius_m: f64,
        /// Half the distance of front and rear axle, m.
        half_length_m: f64,
        /// Half the distance of left and right wheels, m.
        half_width_m: f64,
    },
    /// R itself.
    Matrix {
        /// D rows of N numbers: vx, (vy,) in m per rad, and ω, without a unit.
        rows: Vec<Vec<f64>>,
        /// Wheel radius, m, if known.
        wheel_radius_m: Option<f64>,
    },
}

impl Geometry {
    /// Number of driven wheels N.
    pub fn wheels(&self) -> usize {
        match self {
            Self::DifferentialDrive { .. } => 2,
            Self::SkidSteer { wheels, .. } => *wheels,
            Self::ThreeWheelOmni { .. } => 3,
            Self::FourMecanum { .. } => 4,
            Self::Matrix { rows, .. } => rows.first().map_or(0, Vec::len),
        }
    }

    /// Components D of the body twist: 2 (v, ω) or 3 (vx, vy, ω).
    pub fn twist_components(&self) -> usize {
        match self {
            Self::DifferentialDrive { .. } | Self::SkidSteer { .. } => 2,
            Self::ThreeWheelOmni { .. } | Self::FourMecanum { .. } => 3,
            Self::Matrix { rows, .. } => rows.len(),
        }
    }

    /// Wheel radius, m, where there is one.
    pub fn wheel_radius_m(&self) -> Option<f64> {
        match self {
            Self::DifferentialDrive { wheel_radius_m, .. }
            | Self::SkidSteer { wheel_radius_m, .. }
            | Self::ThreeWheelOmni { wheel_radius_m, .. }
            | Self::FourMecanum { wheel_radius_m, .. } => Some(*wheel_radius_m),
            Self::Matrix { wheel_radius_m, .. } => *wheel_radius_m,
        }
    }

    /// Width across the wheels, m, where there is one.
    pub fn width_m(&self) -> Option<f64> {
        match self {
            Self::DifferentialDrive { track_m, .. } | Self::SkidSteer { track_m, .. } => Some(*track_m),
            Self::ThreeWheelOmni { arm_m, .. } => Some(2.0 * arm_m),
            Self::FourMecanum { half_width_m, .. } => Some(2.0 * half_width_m),
            Self::Matrix { .. } => None,
        }
    }
}
