//! Wheels in motion: speed loop, windings and body, one integration step after the other.

use rand_chacha::ChaCha8Rng;
use support::error::Result;

use super::body::Body;
use super::controller::Controller;
use super::effects::{Causes, Conditions};
use super::kinematics::{MAX_WHEELS, Twist};
use super::noise::{Stream, bounded, stream};
use super::scenario::{LOOP_PERIOD_S, Scenario};

/// Who says how fast the wheels should turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// The scenario's profile.
    Profile,
    /// These wheel speeds, rad/s.
    Wheels([f64; MAX_WHEELS]),
}

/// What happened in one step.
#[derive(Debug, Clone, Copy)]
pub struct Moved {
    /// By how much each wheel has turned, rad.
    pub turned_rad: [f64; MAX_WHEELS],
    /// Mean power that the drives drew from the supply, W.
    pub power_w: f64,
    /// Voltage at the drives, V.
    pub drive_v: f64,
    /// Winding voltage of each wheel, V.
    pub voltage: [f64; MAX_WHEELS],
    /// Mean winding current of each wheel, A.
    pub current: [f64; MAX_WHEELS],
}

/// The moving part of a run. The same scenario has to be given to every step.
#[derive(Debug, Clone)]
pub struct Motion {
    body: Body,
    controllers: [Controller; MAX_WHEELS],
    voltage: [f64; MAX_WHEELS],
    /// Steps done.
    step: u64,
    steps_per_loop: u64,
    cursor: usize,
    loop_noise: ChaCha8Rng,
    causes: Causes,
    /// Voltage that the leads took in the last step, V.
    lead_v: f64,
}

impl Motion {
    /// At rest.
    ///
    /// # Errors
    /// Usage: an effect that makes no sense for this robot.
    pub fn new(scenario: &Scenario) -> Result<Self> {
        let Scenario { robot, seed, step_s, .. } = scenario;
        let mut causes = Causes::new(scenario)?;
        causes.begin(0.0, scenario.payload.mass_at(0.0));
        Ok(Self {
            body: Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels),
            controllers: [Controller::default(); MAX_WHEELS],
            voltage: [0.0; MAX_WHEELS],
            step: 0,
            steps_per_loop: (LOOP_PERIOD_S / step_s).round() as u64,
            cursor: 0,
            loop_noise: stream(*seed, Stream::SpeedLoop),
            causes,
            lead_v: 0.0,
        })
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Wheel speeds, rad/s.
    pub fn wheel_speeds(&self) -> [f64; MAX_WHEELS] {
        self.body.wheel_speeds()
    }

    /// Body twist: forward m/s, leftward m/s, turn rate rad/s.
    pub fn twist(&self) -> Twist {
        self.body.twist()
    }

    /// What held in the last step.
    pub(super) fn conditions(&self) -> &Conditions {
        self.causes.conditions()
    }

    /// Load of the computer at a time that never goes back, percent.
    pub fn cpu_percent_at(&mut self, time_s: f64) -> f64 {
        self.causes.cpu_percent_at(time_s)
    }

    /// One step, the loop's output limited by a supply of `supply_v`.
    pub fn advance(&mut self, scenario: &Scenario, command: Command, supply_v: f64) -> Moved {
        let Scenario { robot, drive, payload, step_s, .. } = scenario;
        let time_s = self.step as f64 * step_s;
        let noted_kg = payload.mass_at(time_s);
        self.causes.begin(time_s, noted_kg);
        if self.step.is_multiple_of(self.steps_per_loop) {
            self.control(scenario, command, time_s, supply_v - self.lead_v);
        }
        let conditions = self.causes.conditions();
        if !self.causes.is_empty() {
            self.body.meet(&conditions.wheels, &conditions.loads);
        }
        let before = self.body.wheel_speeds();
        let steps = self.body.step(&self.voltage, noted_kg + conditions.unnoted_kg, *step_s);
        let after = self.body.wheel_speeds();
        let mut power_w = steps[..robot.geometry.wheels()]
            .iter()
            .map(|wheel| conditions.drive_power(drive, wheel.voltage, wheel.current.mean))
            .sum();
        if conditions.lead_ohm > 0.0 {
            let current = conditions.lead_current(power_w, supply_v);
            self.lead_v = conditions.lead_ohm * current;
            power_w = supply_v * current;
        }
        self.causes.end(&steps, self.body.twist(), after);
        self.step += 1;
        Moved {
            turned_rad: std::array::from_fn(|i| 0.5 * step_s * (before[i] + after[i])),
            power_w,
            drive_v: supply_v - self.lead_v,
            voltage: steps.map(|wheel| wheel.voltage),
            current: steps.map(|wheel| wheel.current.mean),
        }
    }

    fn control(&mut self, scenario: &Scenario, command: Command, time_s: f64, supply_v: f64) {
        let robot = &scenario.robot;
        let target = match command {
            Command::Profile => scenario.profile.wheel_speeds_at(&robot.geometry, time_s, &mut self.cursor),
            Command::Wheels(speeds) => speeds,
        };
        let speeds = self.body.wheel_speeds();
        let scale = self.causes.conditions().speed_scale;
        for i in 0..robot.geometry.wheels() {
            let measured = scale[i] * speeds[i] + robot.loop_noise_rad_s * bounded(&mut self.loop_noise);
            self.voltage[i] =
                self.controllers[i].update(&robot.gains, target[i], measured, supply_v, LOOP_PERIOD_S);
        }
    }
}
