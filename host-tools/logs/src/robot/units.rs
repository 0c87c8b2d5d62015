//! Units that logs are written in where they are not SI: said once, beside the robot, and taken off
//! while a log is read.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use support::error::{Error, Result};

/// Unit of the wheels' speeds (and accelerations, per second).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum SpeedUnit {
    /// Radians per second
    #[default]
    #[value(name = "rad/s")]
    RadPerS,
    /// Revolutions per minute
    #[value(name = "rpm")]
    Rpm,
    /// Revolutions per second
    #[value(name = "rev/s")]
    RevPerS,
    /// Degrees per second
    #[value(name = "deg/s")]
    DegPerS,
    /// Metres per second at the wheels' rims
    #[value(name = "m/s")]
    MPerS,
}

/// Unit of the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum PowerUnit {
    /// Milliwatts
    #[value(name = "mW")]
    Milliwatt,
    /// Watts
    #[default]
    #[value(name = "W")]
    Watt,
    /// Kilowatts
    #[value(name = "kW")]
    Kilowatt,
}

/// Unit of the total mass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum MassUnit {
    /// Grams
    #[value(name = "g")]
    Gram,
    /// Kilograms
    #[default]
    #[value(name = "kg")]
    Kilogram,
    /// Pounds
    #[value(name = "lb")]
    Pound,
}

/// How the logs of a robot are written, whatever their columns are called.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LogUnits {
    /// Of the wheels' speeds.
    pub speed: SpeedUnit,
    /// Of the power.
    pub power: PowerUnit,
    /// Of the total mass.
    pub mass: MassUnit,
    /// Wheels, counted from 1, whose sign is turned.
    pub flipped: Vec<usize>,
    /// Whether power is negative where the robot draws it.
    pub power_is_flipped: bool,
    /// Logs with the total mass that somebody weighed, kg: it stands for whatever the log itself
    /// says.
    pub masses: Vec<(PathBuf, f64)>,
}

/// Which columns of a log its power is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PowerSource {
    /// What was measured.
    #[default]
    Measured,
    /// What a simulator says would have been measured.
    Simulated,
    /// The torques that a simulator's motors give the wheels; what they draw for it, by
    /// [`Motor::power_w`](super::Motor::power_w).
    SimulatedTorques,
}

impl SpeedUnit {
    /// rad/s in one of them; `None` for m/s without a radius, m.
    pub fn in_rad_s(self, wheel_radius_m: Option<f64>) -> Option<f64> {
        Some(match self {
            Self::RadPerS => 1.0,
            Self::Rpm => PI / 30.0,
            Self::RevPerS => 2.0 * PI,
            Self::DegPerS => PI / 180.0,
            Self::MPerS => 1.0 / wheel_radius_m?,
        })
    }
}

impl PowerUnit {
    /// W in one of them.
    pub fn in_w(self) -> f64 {
        match self {
            Self::Milliwatt => 1e-3,
            Self::Watt => 1.0,
            Self::Kilowatt => 1e3,
        }
    }
}

impl MassUnit {
    /// kg in one of them.
    pub fn in_kg(self) -> f64 {
        match self {
            Self::Gram => 1e-3,
            Self::Kilogram => 1.0,
            // The international avoirdupois pound, exactly.
            Self::Pound => 0.453_592_37,
        }
    }
}

impl LogUnits {
    /// W in one unit of the logs' power, with its sign.
    pub fn power_in_w(&self) -> f64 {
        if self.power_is_flipped { -self.power.in_w() } else { self.power.in_w() }
    }

    /// The total mass that somebody weighed with this log, kg.
    pub fn mass_of(&self, log: &Path) -> Option<f64> {
        self.masses.iter().find(|(weighed, _)| weighed == log).map(|(_, mass)| *mass)
    }

    /// Refuses what a robot cannot have.
    ///
    /// # Errors
    /// m/s without a wheel radius; a wheel that it does not have.
    pub(super) fn check(&self, wheels: usize, wheel_radius_m: Option<f64>) -> Result<()> {
        if self.speed.in_rad_s(wheel_radius_m).is_none() {
            return Err(Error::usage("--speed-unit m/s: expected a robot whose file gives wheel_radius_m"));
        }
        if let Some((log, mass)) = self.masses.iter().find(|(_, mass)| !(*mass > 0.0 && mass.is_finite())) {
            let message = format!("={mass}: expected a total mass above 0 kg behind the log's name");
            return Err(Error::usage(message).in_file(log));
        }
        match self.flipped.iter().find(|wheel| !(1..=wheels).contains(*wheel)) {
            Some(wheel) => {
                Err(Error::usage(format!("--flip-wheel {wheel}: expected a wheel from 1 to {wheels}")))
            }
            None => Ok(()),
        }
    }
}
