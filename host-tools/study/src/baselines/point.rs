//! One conditioned row of a log, as baselines see it.

use fit::dataset::Row;
use logs::robot::chassis::{Chassis, Wheels};
use model_core::kinematics::Twist;

/// Columns of some logs, after the same filter as speed and power. NaN where the log has none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    /// Commanded motion of the body, m/s and rad/s.
    pub command: Twist<f64>,
    /// Road grade, nose up, rad.
    pub pitch: f64,
    /// Heading on the slope, from straight uphill, rad.
    pub slope_heading: f64,
    /// Acceleration along X, Y and Z as an IMU feels it, m/s².
    pub vibration: [f64; 3],
    /// Coefficient of rolling friction.
    pub rolling_friction: f64,
    /// Coefficient of static friction.
    pub static_friction: f64,
}

impl Readings {
    /// Of a log with speeds and power only.
    pub const NONE: Self = Self {
        command: Twist { vx: f64::NAN, vy: f64::NAN, omega: f64::NAN },
        pitch: f64::NAN,
        slope_heading: f64::NAN,
        vibration: [f64::NAN; 3],
        rolling_friction: f64::NAN,
        static_friction: f64::NAN,
    };
}

/// One conditioned row as baselines see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Which run: files and values of their `run` column are counted through.
    pub run: u32,
    /// Time within its log, s.
    pub time: f64,
    /// Motion of the body: m/s and rad/s.
    pub speed: Twist<f64>,
    /// Its derivative: m/s² and rad/s².
    pub acceleration: Twist<f64>,
    /// Motion of the wheels.
    pub wheels: Wheels,
    /// True total mass, kg: an input of some baselines, which our models estimate.
    pub mass: f64,
    /// Measured actuation power, W.
    pub power: f64,
    /// What only some logs tell.
    pub readings: Readings,
}

impl Point {
    /// From wheels to the body, by the robot's R.
    pub fn new(robot: &Chassis, row: &Row) -> Self {
        Self {
            run: row.run,
            time: row.time,
            speed: robot.twist(row.wheels.iter().map(|wheel| wheel.speed)),
            acceleration: robot.twist(row.wheels.iter().map(|wheel| wheel.acceleration)),
            wheels: row.wheels,
            mass: row.mass,
            power: row.power,
            readings: Readings::NONE,
        }
    }

    /// Speed along the path, m/s: of a robot that cannot move sideways |v|.
    pub fn path_speed(&self) -> f64 {
        self.speed.vx.hypot(self.speed.vy)
    }

    /// Road grade, nose up, rad; level where the log has none.
    pub fn grade(&self) -> f64 {
        if self.readings.pitch.is_nan() { 0.0 } else { self.readings.pitch }
    }
}
