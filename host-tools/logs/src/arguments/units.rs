//! Arguments about how logs are written, of all commands that read them.

use std::path::{Path, PathBuf};

use super::Log;
use crate::foreign::Reading;
use crate::robot::{LogUnits, MassUnit, PowerUnit, Robot, SpeedUnit};
use support::context::Context;
use support::error::Result;

/// Units of the logs' columns, where they are not those that the columns' names say.
#[derive(clap::Args)]
#[command(next_help_heading = "How logs are read")]
pub struct UnitArguments {
    /// Unit that the wheels' speeds are in (their accelerations: per second), whatever the columns
    /// are called
    #[arg(long, value_enum, default_value = "rad/s")]
    speed_unit: SpeedUnit,
    /// Unit that power_w is in
    #[arg(long, value_enum, default_value = "W")]
    power_unit: PowerUnit,
    /// Unit that mass_kg is in
    #[arg(long, value_enum, default_value = "kg")]
    mass_unit: MassUnit,
    /// Wheels, counted from 1, whose speed is negative when they drive forward
    #[arg(long, value_name = "WHEEL,…", value_delimiter = ',')]
    flip_wheel: Vec<usize>,
    /// Power is negative where the robot draws it: drivers that count a discharging current
    /// positive make such bags
    #[arg(long)]
    flip_power: bool,
    /// Read what is there of a bag or ULog that was cut off while it was recorded
    #[arg(long)]
    pub allow_truncated: bool,
    /// Say all there is to say, not only what counts: where columns came from, every figure
    #[arg(long, short)]
    pub verbose: bool,
}

impl UnitArguments {
    /// The robot by its name or file, with these units of its logs and what was weighed with each
    /// of them; and the context that reads them so.
    ///
    /// # Errors
    /// As [`Robot::load`]; units that this robot's logs cannot have.
    pub fn robot<'a>(
        &self,
        context: &Context,
        name_or_path: &Path,
        logs: impl IntoIterator<Item = &'a Log>,
    ) -> Result<(Context, Robot)> {
        let weighed = |log: &Log| -> Option<(PathBuf, f64)> { Some((log.path.clone(), log.mass_kg?)) };
        let robot = Robot::load(context, name_or_path)?.with_log_units(LogUnits {
            speed: self.speed_unit,
            power: self.power_unit,
            mass: self.mass_unit,
            flipped: self.flip_wheel.clone(),
            power_is_flipped: self.flip_power,
            masses: logs.into_iter().filter_map(weighed).collect(),
        })?;
        let reading =
            Reading { robot: robot.clone(), allow_cut: self.allow_truncated, verbose: self.verbose };
        Ok((context.with_reading(reading), robot))
    }
}
