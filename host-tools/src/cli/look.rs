//! `gmr look`: what is in a log, what the robot's energy goes into, and what can be learned from it.

use std::path::PathBuf;

use answers::look::{self, Report};
use support::error::{Error, Result};
use support::output;
use support::own::Form;

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
    /// Read what is there of a bag or ULog that was cut off while it was recorded
    #[arg(long)]
    allow_truncated: bool,
    /// The logs: MCAP, db3, ULog, Parquet or CSV
    #[arg(value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

/// Several logs.
#[derive(serde::Serialize)]
struct Several<'a> {
    logs: &'a [Report],
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if let Some(page) = &arguments.page {
        if arguments.logs.len() > 1 {
            return Err(Error::usage(format!("--page with {} logs: expected one", arguments.logs.len())));
        }
        output::folder_of(page)?;
    }
    output::check_apart(arguments.page.as_deref(), arguments.logs.iter().map(PathBuf::as_path))?;
    arguments.overwrite.check(&arguments.page, Form::Page)?;
    let reports = arguments.logs.iter().map(|log| Report::of(log, arguments.allow_truncated));
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
