//! Arguments about the simulated robot and its drive, of all commands that have one.

use std::path::Path;

use clap::ValueEnum;
use plant::scenario::duration_allowed;
use plant::{
    Effect, Geometry, Kinematics, PayloadSchedule, PlantSet, Profile, ProfileKind, Robot, Scenario, profile,
};
use support::error::{Error, Result};

/// Arguments about robot and drive.
#[derive(clap::Args)]
pub(super) struct DriveArguments {
    /// Motors: the paper's Table 3, a servo like the XL430-W250, or a brisk gear motor
    #[arg(long, value_enum, default_value = "servo")]
    pub(super) plant: PlantSet,
    /// training, test, constant, standstill, or a CSV file with time_s and v_m_s, omega_rad_s
    /// (vx_m_s, vy_m_s, omega_rad_s for omni and mecanum) or wheel1_rad_s …
    #[arg(long, default_value = "training", value_name = "KIND|FILE")]
    pub(super) profile: String,
    /// Length of the run, s
    #[arg(long, default_value_t = 200.0, allow_negative_numbers = true)]
    pub(super) duration: f64,
    /// Total mass, kg, or steps of KG@SECONDS: `1@0,6@100` [default: 1]
    #[arg(long, allow_hyphen_values = true)]
    mass: Option<String>,
    /// Bounded noise on the speed loop's measurement, rad/s at the wheel [default: 0.0002 table3,
    /// 0.002 servo, 0.01 gearmotor]
    #[arg(long, allow_negative_numbers = true)]
    loop_noise: Option<f64>,
    /// Efficiency of the motor drives
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    drive_efficiency: f64,
    /// Let the drives return braking power to the supply
    #[arg(long)]
    regeneration: bool,
    /// What is not as a fit knew it: ID=SIZE, with options ID=SIZE:OPTION=VALUE:…, e.g.
    /// `grade=0.03:heading=1.57`; may be given several times (`gmr simulate --effects` lists them)
    #[arg(long, value_name = "ID=SIZE", allow_hyphen_values = true)]
    pub(super) effect: Vec<String>,
    /// Seed of profile and noise: same seed, same bytes
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
}

impl DriveArguments {
    /// Total mass over time, as written.
    pub(super) fn mass(&self) -> &str {
        self.mass.as_deref().unwrap_or("1")
    }

    /// Whether somebody said what the robot weighs.
    pub(super) fn has_mass(&self) -> bool {
        self.mass.is_some()
    }

    /// The profile's kind; `None` for a file.
    pub(super) fn kind(&self) -> Option<ProfileKind> {
        ProfileKind::from_str(&self.profile, false).ok()
    }

    /// What they ask for, with exact sensors.
    pub(super) fn scenario(&self, kinematics: Kinematics) -> Result<Scenario> {
        self.scenario_on(Robot::new(self.plant, kinematics))
    }

    /// The same with a robot of other lengths.
    pub(super) fn scenario_on(&self, robot: Robot) -> Result<Scenario> {
        if let Some(kind) = self.kind() {
            return self.scenario_of(kind, robot);
        }
        let mut scenario = self.scenario_of(ProfileKind::Standstill, robot)?;
        scenario.profile = read_profile(&self.profile, &scenario.robot.geometry)?;
        Ok(scenario)
    }

    /// The same with a profile of this kind, whatever the arguments say of it.
    pub(super) fn scenario_of(&self, kind: ProfileKind, robot: Robot) -> Result<Scenario> {
        // Checked before any profile of that length is drawn.
        if !duration_allowed(self.duration) {
            return Err(Error::usage(format!("duration {}; allowed: s, above 0 to 1e7", self.duration)));
        }
        let mut scenario = Scenario::of(robot, kind, self.duration, self.seed);
        scenario.payload = PayloadSchedule::parse(self.mass())?;
        scenario.effects = self.effect.iter().map(|text| Effect::parse(text)).collect::<Result<_>>()?;
        scenario.drive.efficiency = self.drive_efficiency;
        scenario.drive.regeneration = self.regeneration;
        if let Some(noise) = self.loop_noise {
            scenario.robot.loop_noise_rad_s = noise;
        }
        Ok(scenario)
    }
}

fn read_profile(name: &str, geometry: &Geometry) -> Result<Profile> {
    let file = Path::new(name);
    // A bare word that is no file is more likely a misspelt kind than a lost file.
    if !file.exists() && file.extension().is_none() && !name.contains(std::path::MAIN_SEPARATOR) {
        let allowed = "training, test, constant, standstill or a CSV file";
        return Err(Error::usage(format!("profile `{name}`; allowed: {allowed}")));
    }
    profile::read(file, geometry)
}
