//! A fitted model of a robot with as many wheels as it has.

use logs::robot::chassis::Chassis;
use logs::with_core;
use model_core::coefficients::{Coefficients, Image, Robot as CoreRobot};
use model_core::effects::Columns;
use model_core::model::Model;
use model_core::payload::Noise;

/// As model-core's [`Coefficients`], on ground that does not adapt.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedModel {
    /// Geometry and conditioning.
    pub robot: Chassis,
    /// The model.
    pub model: Model<f64>,
    /// Its residuals.
    pub noise: Noise<f64>,
    /// Effects that it lacks.
    pub columns: Columns<f64>,
    /// Whether the fit saw what tells one mass from another.
    pub identifies_mass: bool,
}

impl FittedModel {
    /// As model-core takes it.
    ///
    /// # Panics
    /// If `N` is not the robot's number of wheels.
    pub fn core<const N: usize>(&self) -> Coefficients<f64, N> {
        self.of(self.robot.core())
    }

    /// The same for its robot as model-core knows it.
    pub fn of<const N: usize>(&self, robot: &CoreRobot<f64, N>) -> Coefficients<f64, N> {
        Coefficients {
            robot: *robot,
            model: self.model,
            noise: self.noise,
            columns: self.columns,
            identifies_mass: self.identifies_mass,
            ground_adapts: false,
        }
    }

    /// [`Coefficients::energy_floor`].
    pub fn energy_floor(&self) -> f64 {
        with_core!(&self.robot, core => self.of(core).energy_floor())
    }

    /// Whether a robot can be so ([`Coefficients::is_plausible`]).
    pub fn is_plausible(&self) -> bool {
        with_core!(&self.robot, core => self.of(core).is_plausible())
    }

    /// As a board would hold it; `None` where no board has such a model.
    pub fn encode(&self) -> Option<Image> {
        with_core!(&self.robot, core => self.of(core).encode())
    }
}
