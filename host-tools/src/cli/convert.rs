//! `gmr convert`: logs of any format that is read, as one log in CSV, Parquet or MCAP.

use std::path::PathBuf;

use logs::arguments::Log;
use logs::convert::{Request, convert};
use logs::foreign::Reading;
use logs::robot::{FOUND, Robot};
use support::context::Context;
use support::error::Result;
use support::output;
use support::overwrite::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr convert`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr convert --robot robot.toml --mass 1.06 empty.mcap --out empty.csv")]
pub(crate) struct Arguments {
    /// Robot: a built-in name (burger, turtlebot4, warthog, husky) or a robot.toml; its [topics]
    /// say where a bag has what; auto: the nearest robot.toml upward, else burger
    #[arg(long, value_name = "R.toml", default_value = FOUND)]
    robot: PathBuf,
    /// Total mass of logs that do not tell it, kg
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Read what is there of a bag or ULog that was cut off while it was recorded
    #[arg(long)]
    allow_truncated: bool,
    /// Write to this file; its ending says as what
    #[arg(long, value_name = "OUT.{csv,parquet,mcap}")]
    out: PathBuf,
    /// Answer as JSON
    #[arg(long)]
    json: bool,
    /// The logs; of several, each is a run. The total mass behind the name is written into mass_kg
    #[arg(value_name = "LOG[=KG]", required = true)]
    logs: Vec<Log>,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let request = Request { logs: &arguments.logs, mass_kg: arguments.mass, out: &arguments.out };
    request.check()?;
    let inputs = arguments.logs.iter().map(AsRef::as_ref).chain([arguments.robot.as_path()]);
    output::check_apart([arguments.out.as_path()], inputs)?;
    output::folder_of(&arguments.out)?;
    arguments.overwrite.check([&arguments.out], Form::Converted)?;
    let robot = Robot::load(context, &arguments.robot)?;
    let reading = Reading { robot, allow_cut: arguments.allow_truncated, verbose: true };
    let answer = convert(&context.with_reading(reading), &request)?;
    if arguments.json {
        return output::print_json(&answer);
    }
    println!("{}: {} rows of {}", answer.out, answer.rows, answer.columns.join(", "));
    Ok(())
}
