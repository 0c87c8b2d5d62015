//! How fast a profile may ask the robot to drive, turn and accelerate.

use logs::robot::Robot;
use logs::runs::Runs;
use nalgebra::DMatrix;

use residuals::thresholds::manoeuvre::USUAL;

/// Limits, and the wheel speeds of a twist.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Forward speed, m/s.
    pub speed_m_s: f64,
    /// Turn rate, rad/s.
    pub turn_rad_s: f64,
    /// Speed of any wheel, rad/s.
    pub wheel_rad_s: f64,
    /// Acceleration of any wheel, rad/s².
    pub wheel_rad_s2: f64,
    /// Wheel speeds per twist: columns for forward speed and turn rate.
    wheels: Vec<[f64; 2]>,
}

impl Limits {
    /// From the robot's file; those that it does not give, from the runs.
    pub fn new(robot: &Robot, runs: &Runs) -> Self {
        let rows = || runs.runs.iter().flat_map(|run| &run.rows);
        let wheels = wheels_of_twist(runs);
        let driven = |values: Vec<f64>| usual(values);
        let given = robot.limits();
        let speed_m_s =
            given.speed_m_s.unwrap_or_else(|| driven(rows().map(|row| row.speed.abs()).collect()));
        let turn_rad_s =
            given.turn_rad_s.unwrap_or_else(|| driven(rows().map(|row| row.turn_rate.abs()).collect()));
        let per_speed = wheels.iter().map(|w| w[0].abs()).fold(0.0, f64::max);
        let all = |of: fn(&model_core::motion::Wheel<f64>) -> f64| {
            driven(rows().flat_map(|row| row.wheels.iter().map(move |wheel| of(wheel).abs())).collect())
        };
        let wheel_rad_s = given.speed_m_s.map_or_else(|| all(|wheel| wheel.speed), |speed| per_speed * speed);
        let wheel_rad_s2 = given
            .acceleration_m_s2
            .map_or_else(|| all(|wheel| wheel.acceleration), |acceleration| per_speed * acceleration);
        Self { speed_m_s, turn_rad_s, wheel_rad_s, wheel_rad_s2, wheels }
    }

    /// Turn rate of a spin in which the fastest wheel is as fast as it may be, rad/s.
    pub fn spin_rad_s(&self) -> f64 {
        let per_turn = self.wheels.iter().map(|w| w[1].abs()).fold(0.0, f64::max);
        if per_turn > 0.0 { self.wheel_rad_s / per_turn } else { 0.0 }
    }

    /// Wheel speeds, rad/s, of a forward speed and a turn rate.
    pub fn wheel_speeds(&self, [speed, turn]: [f64; 2]) -> impl Iterator<Item = f64> {
        self.wheels.iter().map(move |w| w[0] * speed + w[1] * turn)
    }

    /// Scales a twist down, keeping its curvature, until no limit is passed.
    pub fn hold(&self, twist: [f64; 2]) -> [f64; 2] {
        let most = |value: f64, limit: f64| if limit > 0.0 { value.abs() / limit } else { 0.0 };
        let strain = self
            .wheel_speeds(twist)
            .map(|wheel| most(wheel, self.wheel_rad_s))
            .chain([most(twist[0], self.speed_m_s), most(twist[1], self.turn_rad_s)])
            .fold(1.0, f64::max);
        twist.map(|x| x / strain)
    }

    /// Shortest time between two twists, s.
    pub fn ramp_s(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let change =
            self.wheel_speeds([to[0] - from[0], to[1] - from[1]]).fold(0.0_f64, |a, w| a.max(w.abs()));
        if self.wheel_rad_s2 > 0.0 { change / self.wheel_rad_s2 } else { 0.0 }
    }
}

/// The value that nearly all are below.
fn usual(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = (USUAL * (values.len() - 1) as f64) as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// The wheel speeds of a twist with the least slip: the pseudo-inverse of R.
fn wheels_of_twist(runs: &Runs) -> Vec<[f64; 2]> {
    let rows = runs.robot.rows();
    let wheels = rows[0].len();
    let matrix = DMatrix::from_fn(3, wheels, |i, j| rows[i][j]);
    // Fails only for a negative threshold.
    let inverse = matrix.pseudo_inverse(1e-12).unwrap_or_else(|_| DMatrix::zeros(wheels, 3));
    (0..wheels).map(|wheel| [inverse[(wheel, 0)], inverse[(wheel, 2)]]).collect()
}
