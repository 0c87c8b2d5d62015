//! `gmr gram`: logs to sums, from which fits are made without the logs.

use std::path::{Path, PathBuf};

use fit::run_gram::{self, Conditioned, RunGram};
use logs::checks::check_mass;
use logs::robot::{FOUND, Robot};
use logs::with_wheels;
use logs::{Header, Table};
use rayon::prelude::*;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output::{self, check_apart};
use support::own::Form;
use support::progress::CountProgress;

use super::overwrite::OverwriteArgument;
use super::units::UnitArguments;
use super::weighed::{Log, paths};

/// Arguments of `gmr gram`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr gram --robot robot.toml --out sums.jsonl monday/*.csv")]
pub(crate) struct Arguments {
    /// Logs, with the total mass behind the name where they do not hold it
    #[arg(required = true, value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Where the sums go: JSON, a run a line; or GRAMS.parquet, a run a row
    #[arg(long, value_name = "GRAMS.jsonl")]
    out: PathBuf,
    /// Cutoff of the filter, Hz; only sums of one cutoff add up [default: the robot's, or that of gmr fit for these logs]
    #[arg(long, value_name = "HZ", conflicts_with = "coeffs")]
    cutoff: Option<f64>,
    /// Coefficients of gmr fit (signed): their filter, delay and slip memory, and sums near them that know clamped wheels, too
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

#[derive(Serialize)]
struct Summary<'a> {
    file: &'a Path,
    runs: usize,
    rows: u64,
    filter_cutoff_hz: f64,
    distance_m: f64,
    energy_j: f64,
    may_clamp_rows: u64,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    with_wheels!(robot, run_with(context, robot, arguments))
}

/// What `gmr gram` with these arguments makes of columns in memory, in the place of its log: nothing is written. Cutoff or coefficients have
/// to be given, as one of many machines cannot choose for all.
///
/// # Errors
/// As the command.
pub(super) fn of_table(context: &Context, arguments: &Arguments, table: Table) -> Result<Vec<RunGram>> {
    if arguments.cutoff.is_none() && arguments.coeffs.is_none() {
        let message =
            "neither --cutoff nor --coeffs; expected one of them, so that sums of all machines add up";
        return Err(Error::usage(message));
    }
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    let header = Header::of_table(context, &arguments.runs[0].path, table)?;
    with_wheels!(robot, of_header(context, robot, arguments, header))
}

fn of_header<const N: usize>(
    context: &Context,
    robot: &Robot,
    arguments: &Arguments,
    header: Header,
) -> Result<Vec<RunGram>> {
    let how = conditioned::<N>(context, robot, arguments)?;
    run_gram::of_header(robot, &how, header).map(|summed| summed.runs)
}

fn conditioned<const N: usize>(
    context: &Context,
    robot: &Robot,
    arguments: &Arguments,
) -> Result<Conditioned<N>> {
    let mass = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    if let Some(file) = &arguments.coeffs {
        return Conditioned::near(robot, file, mass);
    }
    let cutoff = match arguments.cutoff {
        Some(given) if given > 0.0 && given.is_finite() => given,
        Some(given) => {
            return Err(Error::usage(format!("--cutoff {given}: expected a number above 0, Hz")));
        }
        None => fit::choose_cutoff::<N>(context, robot, &paths(&arguments.runs), mass)?,
    };
    Ok(Conditioned { core: robot.core::<N>(cutoff)?, drive: robot.drive(), reference: None, mass_kg: mass })
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    let logs = paths(&arguments.runs);
    let inputs = logs.iter().chain([&arguments.robot]).chain(&arguments.coeffs);
    check_apart([arguments.out.as_path()], inputs.map(PathBuf::as_path))?;
    arguments.overwrite.check([&arguments.out], Form::Grams)?;
    let how = conditioned::<N>(context, robot, arguments)?;
    let progress = CountProgress::new(context, "logs read", logs.len() as u64);
    let of_log = |log: &PathBuf| {
        let runs = run_gram::of_log(context, robot, &how, log).map(|summed| summed.runs);
        progress.one_more();
        runs
    };
    let of_logs: Vec<Result<Vec<RunGram>>> = logs.par_iter().map(of_log).collect();
    drop(progress);
    let runs: Vec<RunGram> = of_logs.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    for run in runs.iter().filter(|run| run.summary.exclusions.total() > 0) {
        context.notice(format_args!("{}: {}", run.run, run.summary.exclusions));
    }
    run_gram::write_all(&arguments.out, &runs)?;
    let all = run_gram::total(&runs)?;
    let summary = Summary {
        file: &arguments.out,
        runs: runs.len(),
        rows: all.summary.rows,
        filter_cutoff_hz: how.core.cutoff_hz,
        distance_m: all.summary.distance_m,
        energy_j: all.summary.energy_j,
        may_clamp_rows: all.may_clamp,
    };
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
