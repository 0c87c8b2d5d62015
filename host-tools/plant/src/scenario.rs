//! One simulated run, as a value.

use support::error::{Error, Result};

use super::drive::Drive;
use super::effects::Effect;
use super::kinematics::Kinematics;
use super::payload::PayloadSchedule;
use super::profile::{Profile, ProfileKind};
use super::sensors::Sensors;
use super::sets::{PlantSet, Robot};

/// Integration step, s: a quarter of the speed loop's period. Halving it moves the power by less
/// than 0.2 %.
pub const DEFAULT_STEP_S: f64 = 0.25e-3;

/// Period of the wheel speed loop, s (the paper's simulation runs at 1 ms throughout).
pub const LOOP_PERIOD_S: f64 = 1e-3;

/// Whether a run may last this long, s: up to 115 days, of which the profile's knots fill 0.2 GB.
pub fn duration_allowed(duration_s: f64) -> bool {
    duration_s > 0.0 && duration_s <= 1e7
}

/// What is simulated. Start from [`Scenario::new`] and change fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The robot.
    pub robot: Robot,
    /// The drives' losses.
    pub drive: Drive,
    /// Commanded motion.
    pub profile: Profile,
    /// Total mass over time.
    pub payload: PayloadSchedule,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Samples per second, Hz. Samples fall on whole integration steps.
    pub rate_hz: f64,
    /// The measuring chain.
    pub sensors: Sensors,
    /// Power added to what is logged, W, for logs of total power.
    pub static_power_w: f64,
    /// Seed of every noise (the profile has been drawn already).
    pub seed: u64,
    /// What is not as the fit knew it.
    pub effects: Vec<Effect>,
    /// Integration step, s; the loop's period divided by a whole number.
    pub step_s: f64,
}

/// No power stage loses more than 99 parts in a hundred; the power that it draws stays a number.
const LEAST_EFFICIENCY: f64 = 0.01;

impl Scenario {
    /// A run of 1 kg with exact sensors at 100 Hz.
    pub fn new(
        set: PlantSet,
        kinematics: Kinematics,
        profile: ProfileKind,
        duration_s: f64,
        seed: u64,
    ) -> Self {
        Self::of(Robot::new(set, kinematics), profile, duration_s, seed)
    }

    /// The same of any robot.
    pub fn of(robot: Robot, profile: ProfileKind, duration_s: f64, seed: u64) -> Self {
        let profile = Profile::generate(profile, &robot.geometry, &robot.limits, duration_s, seed);
        Self {
            robot,
            drive: Drive::default(),
            profile,
            payload: PayloadSchedule::constant(1.0),
            duration_s,
            rate_hz: 100.0,
            sensors: Sensors::exact(),
            static_power_w: 0.0,
            seed,
            effects: Vec::new(),
            step_s: DEFAULT_STEP_S,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// Usage, naming the first that is out of range and the range.
    pub fn check(&self) -> Result<()> {
        let sensors = &self.sensors;
        let top_rate = 1.0 / self.step_s;
        let top_jitter = 1.0 / (6.0 * self.rate_hz);
        let steps = LOOP_PERIOD_S / self.step_s;
        let checks = [
            ("duration", self.duration_s, "s, above 0 to 1e7", duration_allowed(self.duration_s)),
            (
                "rate",
                self.rate_hz,
                &format!("Hz, above 0 to {top_rate}"),
                self.rate_hz > 0.0 && self.rate_hz <= top_rate,
            ),
            ("speed noise", sensors.speed_noise_rad_s, "rad/s, 0 or more", sensors.speed_noise_rad_s >= 0.0),
            ("power noise", sensors.power_noise_w, "W, 0 or more", sensors.power_noise_w >= 0.0),
            (
                "power noise per watt",
                sensors.power_noise_per_w,
                "0 or more",
                sensors.power_noise_per_w >= 0.0,
            ),
            (
                "power noise tail",
                // None passes as the limit of many degrees of freedom.
                sensors.power_noise_tail.unwrap_or(1e9),
                "degrees of freedom, above 2",
                sensors.power_noise_tail.is_none_or(|degrees| degrees > 2.0),
            ),
            (
                "power autocorrelation",
                sensors.power_autocorrelation,
                "above -1, below 1",
                sensors.power_autocorrelation.abs() < 1.0,
            ),
            (
                "jitter",
                sensors.jitter_s,
                &format!("s, 0 to a sixth of the period, {top_jitter}"),
                (0.0..=top_jitter).contains(&sensors.jitter_s),
            ),
            (
                "averages",
                f64::from(sensors.ina219.averages),
                "1, 2, 4, 8, 16, 32, 64 or 128",
                sensors.ina219.averages.is_power_of_two() && sensors.ina219.averages <= 128,
            ),
            (
                "loop noise",
                self.robot.loop_noise_rad_s,
                "rad/s, 0 or more",
                self.robot.loop_noise_rad_s >= 0.0,
            ),
            (
                "drive efficiency",
                self.drive.efficiency,
                &format!("{LEAST_EFFICIENCY} to 1"),
                (LEAST_EFFICIENCY..=1.0).contains(&self.drive.efficiency),
            ),
            ("static power", self.static_power_w, "W, 0 or more", self.static_power_w >= 0.0),
            (
                "step",
                self.step_s,
                "s, 1 ms divided by a whole number",
                steps >= 1.0 && (steps - steps.round()).abs() < 1e-9,
            ),
        ];
        for (name, value, allowed, holds) in checks {
            if !(holds && value.is_finite()) {
                return Err(Error::usage(format!("{name} {value}; allowed: {allowed}")));
            }
        }
        Ok(())
    }
}
