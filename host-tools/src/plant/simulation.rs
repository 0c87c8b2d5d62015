//! The run itself: motion and sensors in step.

use rand_chacha::ChaCha8Rng;

use super::kinematics::MAX_WHEELS;
use super::motion::{Command, Motion};
use super::noise::{Stream, bounded, stream};
use super::scenario::Scenario;
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
    motion: Motion,
    /// Samples given.
    sample: u64,
    speed_reader: SpeedReader,
    power_reader: PowerReader,
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
        let Scenario { sensors, seed, step_s, .. } = scenario;
        Ok(Self {
            scenario,
            motion: Motion::new(scenario),
            sample: 0,
            speed_reader: SpeedReader::new(sensors.speed, *seed),
            power_reader: PowerReader::new(sensors, *step_s, *seed),
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
        self.motion.steps() as f64 * self.scenario.step_s
    }

    fn advance(&mut self) {
        let moved = self.motion.advance(self.scenario, Command::Profile, self.scenario.robot.supply_v);
        self.power_w = moved.power_w;
        self.power_reader.observe(self.power_w);
        self.speed_reader.observe(moved.turned_rad);
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
        while self.motion.steps() < due {
            self.advance();
        }
        self.sample += 1;
        let time_s = self.now();
        Some(Sample {
            time_s,
            wheel_rad_s: self.speed_reader.read(time_s, self.motion.wheel_speeds()),
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
