//! What a baseline is, takes and assumes: shown in lists, tables and refusals.

use super::{Baseline, Readings};
use crate::robot::{Geometry, Robot};

/// One baseline's description.
pub struct Card {
    /// Its name in tables and in `gmr compare --models`.
    pub name: &'static str,
    /// Authors, year and what the model is, in one line.
    pub source: &'static str,
    /// What it assumes beyond that, in one line.
    pub assumes: &'static str,
    /// The true mass is one of its inputs.
    pub takes_mass: bool,
    /// It has a neural network.
    pub network: bool,
    /// What a log has to tell beside speeds and power.
    pub needs: &'static [Need],
    /// Wheel layouts that it is for; any, where none is named.
    pub layouts: &'static [Layout],
    /// A new one for this robot, not fitted.
    pub make: fn(&Robot) -> Box<dyn Baseline>,
}

/// Columns that a baseline cannot do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// Commanded motion of the body.
    Command,
    /// Road grade.
    Pitch,
    /// Heading on the slope.
    SlopeHeading,
    /// Acceleration along three axes.
    Vibration,
    /// Coefficient of rolling friction.
    RollingFriction,
    /// Coefficient of static friction.
    StaticFriction,
}

impl Need {
    /// Each of them.
    pub const ALL: [Self; 6] = [
        Self::Command,
        Self::Pitch,
        Self::SlopeHeading,
        Self::Vibration,
        Self::RollingFriction,
        Self::StaticFriction,
    ];

    /// The columns of a log that tell it.
    pub fn columns(self, robot: &Robot) -> &'static [&'static str] {
        match self {
            Self::Command if robot.geometry().twist_components() == 3 => {
                &["cmd_vx_m_s", "cmd_vy_m_s", "cmd_omega_rad_s"]
            }
            Self::Command => &["cmd_v_m_s", "cmd_omega_rad_s"],
            Self::Pitch => &["pitch_rad"],
            Self::SlopeHeading => &["slope_heading_rad"],
            Self::Vibration => &["accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"],
            Self::RollingFriction => &["rolling_friction"],
            Self::StaticFriction => &["static_friction"],
        }
    }

    /// What its columns tell, in their order; 0 behind the last of them.
    pub fn values(self, robot: &Robot, readings: &Readings) -> [f64; 3] {
        let command = readings.command;
        match self {
            Self::Command if robot.geometry().twist_components() == 3 => {
                [command.vx, command.vy, command.omega]
            }
            Self::Command => [command.vx, command.omega, 0.0],
            Self::Pitch => [readings.pitch, 0.0, 0.0],
            Self::SlopeHeading => [readings.slope_heading, 0.0, 0.0],
            Self::Vibration => readings.vibration,
            Self::RollingFriction => [readings.rolling_friction, 0.0, 0.0],
            Self::StaticFriction => [readings.static_friction, 0.0, 0.0],
        }
    }
}

/// How wheels carry a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Two wheels on one axle.
    Differential,
    /// Sides that turn by driving at different speeds.
    SkidSteer,
    /// Three omnidirectional wheels.
    Omni,
    /// Four mecanum wheels.
    Mecanum,
    /// A matrix of the user's.
    Matrix,
}

impl Layout {
    /// That of a robot.
    pub fn of(robot: &Robot) -> Self {
        match robot.geometry() {
            Geometry::DifferentialDrive { .. } => Self::Differential,
            Geometry::SkidSteer { .. } => Self::SkidSteer,
            Geometry::ThreeWheelOmni { .. } => Self::Omni,
            Geometry::FourMecanum { .. } => Self::Mecanum,
            Geometry::Matrix { .. } => Self::Matrix,
        }
    }

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Differential => "differential drive",
            Self::SkidSteer => "skid steer",
            Self::Omni => "three omni wheels",
            Self::Mecanum => "four mecanum wheels",
            Self::Matrix => "a matrix of one's own",
        }
    }
}
