//! `gmr look`: what is in a log, what the robot's energy goes into, and what can be learned from
//! it.

use std::path::PathBuf;

use answers::look::{self, Report};
use logs::arguments::{Log, UnitArguments, paths};
use logs::checks;
use logs::robot::FOUND;
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::overwrite::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr look`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr look bag.mcap --page bag.html")]
pub(crate) struct Arguments {
    /// Answer as JSON: an object of one log, a list of several
    #[arg(long)]
    json: bool,
    /// Write a page with plots as well; of one log
    #[arg(long, value_name = "FILE.html")]
    page: Option<PathBuf>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger. Its [topics] say where a bag has what
    #[arg(long, value_name = "R.toml", default_value = FOUND)]
    robot: PathBuf,
    /// The logs: MCAP, db3, ULog, Parquet or CSV
    #[arg(value_name = "LOG[=KG]", required = true)]
    logs: Vec<Log>,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

/// Several logs.
#[derive(serde::Serialize)]
pub(super) struct Several<'a, T> {
    pub(super) logs: &'a [T],
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    if let Some(page) = &arguments.page {
        if arguments.logs.len() > 1 {
            return Err(Error::usage(format!("--page with {} logs: expected one", arguments.logs.len())));
        }
        output::folder_of(page)?;
    }
    let logs = paths(&arguments.logs);
    output::check_apart(arguments.page.as_deref(), logs.iter().map(PathBuf::as_path))?;
    checks::each_once(&logs, &[])?;
    arguments.overwrite.check(&arguments.page, Form::Page)?;
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.logs)?;
    let reports = logs.iter().map(|log| Report::of(context, log, robot, arguments.units.allow_truncated));
    let reports = reports.collect::<Result<Vec<_>>>()?;
    if let (Some(file), [only]) = (&arguments.page, &reports[..]) {
        output::write_content(file, look::page(only)?)?;
    }
    match &reports[..] {
        [only] if arguments.json => return output::print_json(only),
        logs if arguments.json => return output::print_json(&Several { logs }),
        _ => {}
    }
    let summaries: Vec<String> = reports.iter().map(Report::summary).collect();
    output::print(format_args!("{}", summaries.join("\n")));
    Ok(())
}
