//! What a baseline is, takes and assumes: shown in lists, tables and refusals.

use logs::robot::{Geometry, Robot};

use super::baseline::Baseline;
use super::dynamics::{self, Braking, Dynamics};
use super::longitudinal::TERMS;
use super::network::{Inputs, Network, Settings};
use super::physics::{self, Physics};
use super::point::Readings;
use super::process::GaussianProcess;
use super::recursive::{Bayes, Forgetting, Online};
use super::regression::{Listed, Regression};

/// One baseline's description.
pub struct Card {
    /// Its name in tables and in `gmr compare --models`.
    pub name: &'static str,
    /// Authors, year and what the model is, in one line.
    pub source: &'static str,
    /// What it assumes beyond that, in one line.
    pub assumes: &'static str,
    /// How it departs from its source; empty where it has all that logs allow.
    pub reduced: &'static str,
    /// Kind of its equation: cards of one family differ in terms, not in method.
    pub family: Family,
    /// The true mass is one of its inputs.
    pub takes_mass: bool,
    /// What a log has to hold beside speeds and power.
    pub needs: &'static [Need],
    /// Wheel layouts that it is for; any, where none is named.
    pub layouts: &'static [Layout],
    /// Which engine it runs, and with what.
    pub preset: Preset,
}

/// Kinds of equations among the baselines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Least squares on motion of body or wheels.
    Regression,
    /// Inertia, grade and rolling resistance along the way, learned while driving.
    LongitudinalDynamics,
    /// A Gaussian process about the longitudinal dynamics.
    GaussianProcess,
    /// Skid steer by instantaneous centres of rotation.
    CentresOfRotation,
    /// Dynamics of robot and DC motor: quadratic in the torque.
    MotorDynamics,
    /// Growth of kinetic energy, resistance and losses, seen from outside.
    EnergyBalance,
    /// Neural network.
    Network,
}

impl Family {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regression => "regression on motion",
            Self::LongitudinalDynamics => "longitudinal dynamics",
            Self::GaussianProcess => "Gaussian process",
            Self::CentresOfRotation => "centres of rotation",
            Self::MotorDynamics => "dynamics of robot and motor",
            Self::EnergyBalance => "energy balance",
            Self::Network => "neural network",
        }
    }
}

/// An engine, and what a source runs it with.
#[derive(Debug, Clone, Copy)]
pub enum Preset {
    /// Least squares on these terms.
    Regression(&'static [Listed]),
    /// Least squares on commanded and measured speeds of the wheels, and on their products or not.
    WheelSpeeds {
        /// With all products of two.
        products: bool,
    },
    /// Recursive least squares on these terms.
    Recursive(&'static [Listed; TERMS]),
    /// Recursive least squares with a prior from the training.
    Bayes,
    /// Recursive least squares that find the mass, with several forgetting factors.
    Forgetting {
        /// Residuals are bounded.
        robust: bool,
    },
    /// The Gaussian process.
    Process,
    /// Dynamics of robot and motor with these torques.
    Dynamics(&'static [dynamics::Term], PowerOfBraking),
    /// Energies and losses with these terms.
    Physics(&'static [physics::Term]),
    /// A network that sees this.
    Network(Inputs, Settings),
}

/// Where braking power goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PowerOfBraking {
    /// Back to the battery.
    Regenerates,
    /// As the robot's own drives do: the source does not say.
    AsDriven,
}

impl Card {
    /// A new one for this robot, not fitted.
    pub fn make(&self, robot: &Robot) -> Box<dyn Baseline> {
        self.make_with(robot, Settings::PERCEPTRON.seed)
    }

    /// The same; a network's weights begin from this seed.
    pub fn make_with(&self, robot: &Robot, seed: u64) -> Box<dyn Baseline> {
        let name = self.name;
        match self.preset {
            Preset::Regression(terms) => Box::new(Regression::new(name, terms, robot)),
            Preset::WheelSpeeds { products } => Box::new(Regression::of_wheels(name, products, robot)),
            Preset::Recursive(terms) => Box::new(Online::new(name, terms, robot)),
            Preset::Bayes => Box::<Bayes>::default(),
            Preset::Forgetting { robust } => Box::new(Forgetting::new(name, robust)),
            Preset::Process => Box::<GaussianProcess>::default(),
            Preset::Dynamics(terms, braking) => {
                let loses = braking == PowerOfBraking::AsDriven && !robot.regeneration();
                let braking = if loses { Braking::Dissipates } else { Braking::Regenerates };
                Box::new(Dynamics::new(name, terms, braking))
            }
            Preset::Physics(terms) => Box::new(Physics::new(name, terms, robot)),
            Preset::Network(inputs, settings) => {
                Box::new(Network::new(name, inputs, Settings { seed, ..settings }))
            }
        }
    }

    /// It predicts from the powers of the samples before.
    pub fn learns_while_driving(&self) -> bool {
        matches!(self.preset, Preset::Recursive(_) | Preset::Bayes | Preset::Forgetting { .. })
    }

    /// It finds the mass itself.
    pub fn finds_mass(&self) -> bool {
        matches!(self.preset, Preset::Forgetting { .. })
    }

    /// It has a neural network.
    pub fn is_network(&self) -> bool {
        self.family == Family::Network
    }
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

    /// The columns of a log that hold it.
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

    /// Values of its columns, in their order; 0 after the last.
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
