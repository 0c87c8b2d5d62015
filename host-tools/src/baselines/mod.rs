//! Models of the literature, to compare with: each fitted and evaluated through one trait.

pub mod linear;
#[cfg(feature = "mlp")]
pub mod mlp;

use model_core::coefficients::Robot as CoreRobot;
use model_core::kinematics::Twist;

use crate::error::Result;
use crate::fit::dataset::Row;

/// One conditioned row as baselines see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Motion of the body: m/s and rad/s.
    pub speed: Twist<f64>,
    /// Its derivative: m/s² and rad/s².
    pub acceleration: Twist<f64>,
    /// True total mass, kg: baselines are given what our models have to find.
    pub mass: f64,
    /// Measured actuation power, W.
    pub power: f64,
}

impl Point {
    /// From wheels to the body, by the robot's R.
    pub fn new<const N: usize>(robot: &CoreRobot<f64, N>, row: &Row<N>) -> Self {
        let speed = row.motion.wheels.map(|wheel| wheel.speed);
        let acceleration = row.motion.wheels.map(|wheel| wheel.acceleration);
        Self {
            speed: robot.kinematics.twist(&speed),
            acceleration: robot.kinematics.twist(&acceleration),
            mass: row.mass,
            power: row.power,
        }
    }
}

/// A model that learns power from points.
pub trait Baseline {
    /// Its name in tables, for example `linear`.
    fn name(&self) -> &'static str;

    /// What it is and where it comes from, in one line.
    fn source(&self) -> &'static str;

    /// Learns from training points.
    ///
    /// # Errors
    /// What makes these points unfit for it.
    fn fit(&mut self, training: &[Point]) -> Result<()>;

    /// Predicted power of every point, W, in their order.
    ///
    /// # Errors
    /// It has not been fitted.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>>;
}
