//! What a simulator says beside, or instead of, a measured power: which columns it has, and what a
//! power is made of.

use std::path::{Path, PathBuf};

use support::context::Context;
use support::error::{Error, Result};

use super::{Header, POWER, SIM_POWER, sim_torque_column};
use crate::robot::{Motor, PowerSource, Robot};

/// A simulator's torques as power.
#[derive(Debug, Clone, Copy)]
pub(super) struct Torques {
    motor: Motor,
    regenerates: bool,
    /// What logs of measured power have beside, W.
    static_w: f64,
}

impl Torques {
    /// # Errors
    /// robot.toml does not tell what its motors draw for a torque.
    pub(super) fn of(robot: &Robot) -> Result<Self> {
        let Some(motor) = robot.motor() else {
            let message = format!(
                "{}: torques are no power as long as the motors are not known; expected motor_resistance_ohm, \
                 motor_torque_constant_nm_a and motor_gear_ratio in the robot's file, or a column {SIM_POWER}",
                sim_torque_column(0)
            );
            return Err(Error::failed(message));
        };
        let static_w = robot.static_power_w().unwrap_or(0.0);
        Ok(Self { motor: *motor, regenerates: robot.regeneration(), static_w })
    }

    pub(super) fn power_w(&self, torques: &[f64], speeds: &[f64]) -> f64 {
        let power = |(torque, speed): (&f64, &f64)| {
            let power = self.motor.power_w(*torque, *speed);
            if self.regenerates { power } else { power.max(0.0) }
        };
        self.static_w + torques.iter().zip(speeds).map(power).sum::<f64>()
    }
}

/// Which of a simulator's columns a log has.
fn columns_of(context: &Context, file: &Path, wheels: usize) -> Result<Option<PowerSource>> {
    let header = Header::open(context, file)?;
    let has_torques = (0..wheels).all(|wheel| header.has(&sim_torque_column(wheel)));
    Ok(if header.has(SIM_POWER) {
        Some(PowerSource::Simulated)
    } else if has_torques {
        Some(PowerSource::SimulatedTorques)
    } else {
        None
    })
}

/// What a simulator says in the logs that were measured: the same in all of them, or nothing.
///
/// # Errors
/// A log that cannot be read; logs that differ in it.
pub fn beside(context: &Context, files: &[PathBuf], wheels: usize) -> Result<Option<PowerSource>> {
    let Some(first) = files.first() else { return Ok(None) };
    let expected = columns_of(context, first, wheels)?;
    for file in files {
        if columns_of(context, file, wheels)? != expected {
            let message = format!(
                "has other columns of a simulator than {}; expected {SIM_POWER}, or {} and so on, in all logs or in none",
                first.display(),
                sim_torque_column(0)
            );
            return Err(Error::failed(message).in_file(file));
        }
    }
    Ok(expected)
}

/// Where logs of a simulator have their power: in its own columns, else in that of measured logs.
///
/// # Errors
/// A log that cannot be read, or has none of them; logs that differ in it.
pub fn of_simulator(context: &Context, files: &[PathBuf], wheels: usize) -> Result<PowerSource> {
    if let Some(source) = beside(context, files, wheels)? {
        return Ok(source);
    }
    for file in files {
        if !Header::open(context, file)?.has(POWER) {
            let message = format!(
                "no power; expected {POWER} or {SIM_POWER}, W, or {} and so on, N·m, of all wheels",
                sim_torque_column(0)
            );
            return Err(Error::failed(message).in_file(file));
        }
    }
    Ok(PowerSource::Measured)
}
