//! The run itself: motion and sensors in step.

use rand_chacha::ChaCha8Rng;
use support::error::Result;

use super::effects::{DelayLine, power_delay_s};
use super::imu::{Ground, Imu};
use super::kinematics::{Geometry, MAX_WHEELS, Twist};
use super::motion::{Command, Motion};
use super::noise::{Stream, bounded, stream};
use super::scenario::Scenario;
use super::sensors::{PowerReader, SpeedReader};

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
    /// Total mass as the log notes it, kg.
    pub mass_kg: f64,
    /// Slope under the robot, nose up, rad.
    pub pitch_rad: f64,
    /// Heading counter-clockwise from straight uphill, rad within ±π; 0 on level ground.
    pub slope_heading_rad: f64,
    /// Commanded motion of the body: forward m/s, leftward m/s, turn rate rad/s.
    pub command: Twist,
    /// Specific force at an IMU with noise and the floor's roughness: forward, left, up, m/s².
    pub imu_m_s2: [f64; 3],
    /// Coefficient of rolling friction (force per normal force).
    pub rolling_friction: f64,
    /// Coefficient of friction of tyres that slide over the floor; 0 where none does.
    pub static_friction: f64,
    /// Temperatures of the windings, °C; only the robot's wheels count.
    pub motor_temp_c: [f64; MAX_WHEELS],
    /// Voltage at the drives, V.
    pub bus_v: f64,
    /// Load of the computer, percent.
    pub cpu_percent: f64,
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
    /// Total mass as the log notes it, kg.
    pub mass_kg: Vec<f64>,
    /// Slope under the robot, nose up, rad.
    pub pitch_rad: Vec<f64>,
    /// Temperatures per winding, °C.
    pub motor_temp_c: Vec<Vec<f64>>,
    /// Voltage at the drives, V.
    pub bus_v: Vec<f64>,
    /// Load of the computer, percent.
    pub cpu_percent: Vec<f64>,
}

/// Temperature of windings that are no hotter than in the fit, °C.
const REFERENCE_C: f64 = 25.0;

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
    imu: Imu,
    /// Place in the profile of the last sample.
    cursor: usize,
    power_w: f64,
    drive_v: f64,
    power_line: DelayLine<f64>,
    /// Speeds and angles, where they are late.
    speed_line: DelayLine<[[f64; MAX_WHEELS]; 2]>,
    seen_rad_s: [f64; MAX_WHEELS],
}

impl<'a> Simulation<'a> {
    /// A run about to start.
    ///
    /// # Errors
    /// What [`Scenario::check`] finds.
    pub fn new(scenario: &'a Scenario) -> Result<Self> {
        scenario.check()?;
        let Scenario { sensors, seed, step_s, robot, effects, .. } = scenario;
        let motion = Motion::new(scenario)?;
        let (delay_s, at_rest_w) = (power_delay_s(effects), motion.conditions().reading(0.0));
        Ok(Self {
            scenario,
            motion,
            sample: 0,
            speed_reader: SpeedReader::new(sensors, *seed),
            power_reader: PowerReader::new(sensors, *step_s, *seed, at_rest_w),
            jitter: stream(*seed, Stream::Jitter),
            imu: Imu::new(*seed),
            cursor: 0,
            power_w: 0.0,
            drive_v: robot.supply_v,
            power_line: DelayLine::new(delay_s, *step_s, at_rest_w),
            speed_line: DelayLine::new(-delay_s, *step_s, [[0.0; MAX_WHEELS]; 2]),
            seen_rad_s: [0.0; MAX_WHEELS],
        })
    }

    /// Rows that the run will have: one at 0 s and one every period up to the duration.
    pub fn rows(&self) -> u64 {
        // The small summand keeps the last row when the duration is a whole number of periods.
        (self.scenario.duration_s * self.scenario.rate_hz + 1e-6).floor() as u64 + 1
    }

    /// The robot's layout: it says how many wheels of every sample count.
    pub fn geometry(&self) -> Geometry {
        self.scenario.robot.geometry
    }

    fn now(&self) -> f64 {
        self.motion.steps() as f64 * self.scenario.step_s
    }

    fn advance(&mut self) {
        let moved = self.motion.advance(self.scenario, Command::Profile, self.scenario.robot.supply_v);
        (self.power_w, self.drive_v) = (moved.power_w, moved.drive_v);
        let conditions = self.motion.conditions();
        self.power_reader.observe(self.power_line.pass(conditions.reading(self.power_w)));
        let scaled =
            |values: [f64; MAX_WHEELS]| std::array::from_fn(|i| conditions.speed_scale[i] * values[i]);
        let speeds = [scaled(self.motion.wheel_speeds()), scaled(moved.turned_rad)];
        let [seen, turned] = self.speed_line.pass(speeds);
        self.seen_rad_s = seen;
        self.speed_reader.observe(turned);
    }
}

impl Iterator for Simulation<'_> {
    type Item = Sample;

    fn next(&mut self) -> Option<Sample> {
        if self.sample >= self.rows() {
            return None;
        }
        let Scenario { rate_hz, sensors, robot, static_power_w, payload, step_s, profile, .. } =
            self.scenario;
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
        let cpu_percent = self.motion.cpu_percent_at(time_s);
        let conditions = self.motion.conditions();
        let ground = Ground { rise: conditions.rise, normal_gravity: conditions.loads.normal_gravity };
        Some(Sample {
            time_s,
            wheel_rad_s: self.speed_reader.read(time_s, self.seen_rad_s),
            power_w: self.power_reader.read(robot.supply_v) + conditions.power_gain * static_power_w,
            true_power_w: self.power_w,
            mass_kg: payload.mass_at(time_s),
            pitch_rad: conditions.pitch_rad(),
            slope_heading_rad: conditions.slope_heading_rad(),
            command: profile.twist_at(&robot.geometry, time_s, &mut self.cursor),
            imu_m_s2: self.imu.read(time_s, self.motion.twist(), ground),
            rolling_friction: conditions.rolling_friction(),
            static_friction: conditions.sliding_friction,
            motor_temp_c: conditions.winding_rise_k.map(|rise| REFERENCE_C + rise),
            bus_v: self.drive_v,
            cpu_percent,
        })
    }
}

/// Runs a scenario from start to end in memory.
///
/// # Errors
/// What [`Scenario::check`] finds.
pub fn simulate(scenario: &Scenario) -> Result<Record> {
    let simulation = Simulation::new(scenario)?;
    let per_wheel = vec![Vec::new(); scenario.robot.geometry.wheels()];
    let mut record = Record { wheel_rad_s: per_wheel.clone(), motor_temp_c: per_wheel, ..Record::default() };
    for sample in simulation {
        record.time_s.push(sample.time_s);
        for (column, speed) in record.wheel_rad_s.iter_mut().zip(sample.wheel_rad_s) {
            column.push(speed);
        }
        record.power_w.push(sample.power_w);
        record.true_power_w.push(sample.true_power_w);
        record.mass_kg.push(sample.mass_kg);
        record.pitch_rad.push(sample.pitch_rad);
        for (column, temperature) in record.motor_temp_c.iter_mut().zip(sample.motor_temp_c) {
            column.push(temperature);
        }
        record.bus_v.push(sample.bus_v);
        record.cpu_percent.push(sample.cpu_percent);
    }
    Ok(record)
}
