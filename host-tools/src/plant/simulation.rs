//! The run itself: loop, motors, body and sensors in step.

use rand_chacha::ChaCha8Rng;

use super::body::Body;
use super::controller::Controller;
use super::kinematics::MAX_WHEELS;
use super::noise::{Stream, bounded, stream};
use super::scenario::{LOOP_PERIOD_S, Scenario};
use super::sensors::{PowerReader, SpeedReader};
use crate::error::Result;

/// One row of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time since the start, s.
    pub time_s: f64,
    /// Wheel speeds as measured, rad/s; only the robot's wheels count.
    pub wheel_rad_s: [f64; MAX_WHEELS],
    /// Power as measured, static power included, W.
    pub power_w: f64,
    /// Actuation power as it truly was in the last integration step, W.
    pub true_power_w: f64,
    /// True total mass, kg.
    pub mass_kg: f64,
}

/// A run in memory, column by column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record {
    /// Time since the start, s.
    pub time_s: Vec<f64>,
    /// Speeds per wheel, rad/s.
    pub wheel_rad_s: Vec<Vec<f64>>,
    /// Measured power, W.
    pub power_w: Vec<f64>,
    /// True actuation power, W.
    pub true_power_w: Vec<f64>,
    /// True total mass, kg.
    pub mass_kg: Vec<f64>,
}

/// A run in progress: an iterator over its samples, constant in memory.
#[derive(Debug, Clone)]
pub struct Simulation<'a> {
    scenario: &'a Scenario,
    body: Body,
    controllers: [Controller; MAX_WHEELS],
    voltage: [f64; MAX_WHEELS],
    /// Steps done.
    step: u64,
    steps_per_loop: u64,
    /// Samples given.
    sample: u64,
    cursor: usize,
    speed_reader: SpeedReader,
    power_reader: PowerReader,
    loop_noise: ChaCha8Rng,
    jitter: ChaCha8Rng,
    power_w: f64,
}

impl<'a> Simulation<'a> {
    /// A run about to start.
    ///
    /// # Errors
    /// What [`Scenario::check`] finds.
    pub fn new(scenario: &'a Scenario) -> Result<Self> {
        scenario.check()?;
        let Scenario { robot, sensors, seed, step_s, .. } = scenario;
        Ok(Self {
            scenario,
            body: Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels),
            controllers: [Controller::default(); MAX_WHEELS],
            voltage: [0.0; MAX_WHEELS],
            step: 0,
            steps_per_loop: (LOOP_PERIOD_S / step_s).round() as u64,
            sample: 0,
            cursor: 0,
            speed_reader: SpeedReader::new(sensors.speed, *seed),
            power_reader: PowerReader::new(sensors, *step_s, *seed),
            loop_noise: stream(*seed, Stream::SpeedLoop),
            jitter: stream(*seed, Stream::Jitter),
            power_w: 0.0,
        })
    }

    /// Rows that the run will have: one at 0 s and one every period up to the duration.
    pub fn rows(&self) -> u64 {
        // The small summand keeps the last row when the duration is a whole number of periods.
        (self.scenario.duration_s * self.scenario.rate_hz + 1e-6).floor() as u64 + 1
    }

    /// Number of wheels in every sample.
    pub fn wheels(&self) -> usize {
        self.scenario.robot.geometry.wheels()
    }

    fn now(&self) -> f64 {
        self.step as f64 * self.scenario.step_s
    }

    fn control(&mut self) {
        let robot = &self.scenario.robot;
        let target = self.scenario.profile.wheel_speeds_at(&robot.geometry, self.now(), &mut self.cursor);
        let speeds = self.body.wheel_speeds();
        for i in 0..robot.geometry.wheels() {
            let measured = speeds[i] + robot.loop_noise_rad_s * bounded(&mut self.loop_noise);
            self.voltage[i] =
                self.controllers[i].update(&robot.gains, target[i], measured, robot.supply_v, LOOP_PERIOD_S);
        }
    }

    fn advance(&mut self) {
        if self.step.is_multiple_of(self.steps_per_loop) {
            self.control();
        }
        let Scenario { robot, drive, payload, step_s, .. } = self.scenario;
        let before = self.body.wheel_speeds();
        let steps = self.body.step(&self.voltage, payload.mass_at(self.now()), *step_s);
        let after = self.body.wheel_speeds();
        self.power_w = steps[..robot.geometry.wheels()]
            .iter()
            .map(|wheel| drive.supply_power(wheel.voltage, wheel.current.mean))
            .sum();
        self.power_reader.observe(self.power_w);
        self.speed_reader.observe(std::array::from_fn(|i| 0.5 * step_s * (before[i] + after[i])));
        self.step += 1;
    }
}

impl Iterator for Simulation<'_> {
    type Item = Sample;

    fn next(&mut self) -> Option<Sample> {
        if self.sample >= self.rows() {
            return None;
        }
        let Scenario { rate_hz, sensors, robot, static_power_w, payload, step_s, .. } = self.scenario;
        let mut due = self.sample as f64 / rate_hz;
        if self.sample > 0 && sensors.jitter_s > 0.0 {
            due += sensors.jitter_s * bounded(&mut self.jitter);
        }
        let due = (due / step_s).round() as u64;
        while self.step < due {
            self.advance();
        }
        self.sample += 1;
        let time_s = self.now();
        Some(Sample {
            time_s,
            wheel_rad_s: self.speed_reader.read(time_s, self.body.wheel_speeds()),
            power_w: self.power_reader.read(robot.supply_v) + static_power_w,
            true_power_w: self.power_w,
            mass_kg: payload.mass_at(time_s),
        })
    }
}

/// Runs a scenario from start to end in memory.
///
/// # Errors
/// What [`Scenario::check`] finds.
pub fn simulate(scenario: &Scenario) -> Result<Record> {
    let simulation = Simulation::new(scenario)?;
    let mut record =
        Record { wheel_rad_s: vec![Vec::new(); scenario.robot.geometry.wheels()], ..Record::default() };
    for sample in simulation {
        record.time_s.push(sample.time_s);
        for (column, speed) in record.wheel_rad_s.iter_mut().zip(sample.wheel_rad_s) {
            column.push(speed);
        }
        record.power_w.push(sample.power_w);
        record.true_power_w.push(sample.true_power_w);
        record.mass_kg.push(sample.mass_kg);
    }
    Ok(record)
}
