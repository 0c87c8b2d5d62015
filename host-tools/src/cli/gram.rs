//! `gmr gram`: logs to sums, from which fits are made without the logs.

use std::path::{Path, PathBuf};

use fit::run_gram::{How, Request, RunGram, gram};
use logs::arguments::{Log, UnitArguments, paths};
use logs::checks::check_mass;
use logs::foreign::Reading;
use logs::robot::{FOUND, Robot};
use logs::{Header, Table};
use support::context::Context;
use support::error::{Error, Result};
use support::output::{self, check_apart};
use support::overwrite::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr gram`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr gram --robot robot.toml --out sums.jsonl monday/*.csv")]
pub(crate) struct Arguments {
    /// Logs, with the total mass behind the name where they do not hold it
    #[arg(required = true, value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Where the sums go: JSON, a run a line; or GRAMS.parquet, a run a row
    #[arg(long, value_name = "GRAMS.jsonl")]
    out: PathBuf,
    /// Cutoff of the filter, Hz; only sums of one cutoff add up [default: the robot's, or that of
    /// gmr fit for these logs]
    #[arg(long, value_name = "HZ", conflicts_with = "coeffs")]
    cutoff: Option<f64>,
    /// Coefficients of gmr fit (signed): their filter, delay and slip memory, and sums near them
    /// that know clamped wheels, too
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Say what was written as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    let logs = paths(&arguments.runs);
    let inputs = logs.iter().chain([&arguments.robot]).chain(&arguments.coeffs);
    check_apart([arguments.out.as_path()], inputs.map(PathBuf::as_path))?;
    arguments.overwrite.check([&arguments.out], Form::Grams)?;
    let summary = gram(context, &request(robot, &logs, arguments)?, &arguments.out)?;
    if arguments.json {
        return output::print_json(&summary);
    }
    println!(
        "{}: {} runs, {} rows, {:.1} m, {:.1} J; filter {} Hz",
        summary.file.display(),
        summary.runs,
        summary.rows,
        summary.distance_m,
        summary.energy_j,
        summary.filter_cutoff_hz
    );
    Ok(())
}

/// How `gmr gram` with some arguments sums up: made once, for all logs that a process is given.
pub struct Sums {
    reading: Reading,
    robot: Robot,
    how: How,
}

impl Sums {
    /// Cutoff or coefficients have to be given, as one of many machines cannot choose for all.
    ///
    /// # Errors
    /// As the command.
    pub(super) fn of(context: &Context, arguments: &Arguments) -> Result<Self> {
        if arguments.cutoff.is_none() && arguments.coeffs.is_none() {
            let message =
                "neither --cutoff nor --coeffs; expected one of them, so that sums of all machines add up";
            return Err(Error::usage(message));
        }
        let (context, robot) = arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
        let how = request(&robot, &[], arguments)?.how(&context)?;
        let reading =
            Reading { robot: robot.clone(), allow_cut: arguments.units.allow_truncated, verbose: false };
        Ok(Self { reading, robot, how })
    }

    /// Of a log.
    ///
    /// # Errors
    /// As the command.
    pub fn of_log(&self, context: &Context, log: &Path) -> Result<Vec<RunGram>> {
        let context = context.with_reading(self.reading.clone());
        self.how.of_log(&context, &self.robot, log).map(|summed| summed.runs)
    }

    /// Of columns in memory; `name` is what the run and errors are called by.
    ///
    /// # Errors
    /// As the command; columns that are not those of a log.
    pub fn of_table(&self, context: &Context, name: &Path, table: Table) -> Result<Vec<RunGram>> {
        let header = Header::of_table(context, name, table)?;
        self.how.of_header(&self.robot, header).map(|summed| summed.runs)
    }
}

fn request<'a>(robot: &'a Robot, logs: &'a [PathBuf], arguments: &'a Arguments) -> Result<Request<'a>> {
    let mass_kg = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    check_mass(robot, mass_kg).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    if let Some(given) = arguments.cutoff.filter(|given| !(*given > 0.0 && given.is_finite())) {
        return Err(Error::usage(format!("--cutoff {given}: expected a number above 0, Hz")));
    }
    Ok(Request { robot, logs, near: arguments.coeffs.as_deref(), cutoff_hz: arguments.cutoff, mass_kg })
}
