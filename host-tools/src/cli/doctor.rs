//! `gmr doctor`: what is there, what is missing, and what comes next: robot.toml, logs,
//! coefficients, board, sensor, ROS.

use std::path::{Path, PathBuf};

use serde::Serialize;

use board::serial::ports;
use logs::robot::{Robot, nearest};
use logs::{Header, POWER};
use model::coefficients;
use support::context::Context;
use support::error::Result;
use support::output;

/// Arguments of `gmr doctor`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr doctor")]
pub(crate) struct Arguments {
    /// Answer as JSON
    #[arg(long)]
    json: bool,
}

/// One thing that was looked for.
#[derive(Debug, Serialize)]
struct Check {
    what: &'static str,
    /// `there`, `missing`, or `wrong` where it is there and cannot be used.
    state: State,
    /// What was found, or what would give it.
    text: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum State {
    There,
    Missing,
    Wrong,
}

#[derive(Serialize)]
struct Report {
    /// The command to run next.
    next: String,
    checks: Vec<Check>,
}

/// Endings of logs.
const LOGS: [&str; 6] = ["csv", "mcap", "db3", "ulg", "parquet", "bag"];

/// The name that the examples give coefficients.
const COEFFICIENTS: &str = "coefficients.toml";

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let report = look(context);
    if arguments.json {
        return output::print_json(&report);
    }
    println!("Next: {}", report.next);
    for Check { what, state, text } in &report.checks {
        let state = match state {
            State::There => "there",
            State::Missing => "missing",
            State::Wrong => "WRONG",
        };
        println!("  {what:<13} {state:<8} {text}");
    }
    Ok(())
}

fn look(context: &Context) -> Report {
    let check = |what, state, text: String| Check { what, state, text };
    let file = nearest();
    let robot = file.as_ref().map(|file| Robot::load(context, file));
    let described = match (&file, &robot) {
        (Some(file), Some(Ok(robot))) => {
            check("robot.toml", State::There, format!("{}: {}", file.display(), robot.name()))
        }
        (_, Some(Err(error))) => check("robot.toml", State::Wrong, error.to_string()),
        _ => check("robot.toml", State::Missing, "gmr new-robot asks, and writes one".to_owned()),
    };
    let logs = logs_here(context);
    let names: Vec<String> = logs.iter().take(3).map(|log| log.display().to_string()).collect();
    let recorded = if logs.is_empty() {
        check(
            "logs",
            State::Missing,
            "none in this folder: ros2 bag record, or gmr record from a board".to_owned(),
        )
    } else {
        let more = if logs.len() > names.len() { ", …" } else { "" };
        check("logs", State::There, format!("{}: {}{more}", logs.len(), names.join(", ")))
    };
    let burger = Robot::named("burger").ok();
    let robot = robot.and_then(Result::ok).or(burger);
    let fitted = match robot.as_ref().and_then(fitted) {
        Some(Ok(())) => check("coefficients", State::There, format!("{COEFFICIENTS}: usable")),
        Some(Err(error)) => check("coefficients", State::Wrong, error.to_string()),
        None => {
            check("coefficients", State::Missing, format!("gmr fit --out {COEFFICIENTS} EMPTY=KG FULL=KG"))
        }
    };
    let boards: Vec<String> =
        ports().iter().filter(|port| port.is_opencr).map(|port| port.path.display().to_string()).collect();
    let board = match &boards[..] {
        [] => check(
            "board",
            State::Missing,
            "no OpenCR on a USB port; only gmr record, flash and watch need one".to_owned(),
        ),
        boards => check("board", State::There, boards.join(", ")),
    };
    let buses = devices("/dev", "i2c-");
    let sensor = match &buses[..] {
        [] => check(
            "power sensor",
            State::Missing,
            "no I²C bus (/dev/i2c-*); only gmr node needs one".to_owned(),
        ),
        buses => check(
            "power sensor",
            State::There,
            format!("buses {}: gmr node asks a sensor there", buses.join(", ")),
        ),
    };
    let installed = devices("/opt/ros", "");
    let ros = match (std::env::var("ROS_DISTRO"), &installed[..]) {
        (Ok(name), _) => check("ROS 2", State::There, name),
        (_, []) => {
            check("ROS 2", State::Missing, "not needed: gmr reads bags and speaks DDS without it".to_owned())
        }
        (_, installed) => check("ROS 2", State::There, format!("{}, not sourced", installed.join(", "))),
    };
    let next = match (described.state, recorded.state, fitted.state) {
        (State::Wrong, ..) => "mend robot.toml".to_owned(),
        (_, State::Missing, _) => "gmr demo, or record a drive into this folder".to_owned(),
        (State::Missing, ..) => "gmr new-robot".to_owned(),
        (_, _, State::There) => format!("gmr estimate --coeffs {COEFFICIENTS} {}", names[0]),
        _ => format!("gmr inspect {}", names.join(" ")),
    };
    Report { next, checks: vec![described, recorded, fitted, board, sensor, ros] }
}

/// Whether the coefficients of this folder can be used with this robot; `None` where there are
/// none.
fn fitted(robot: &Robot) -> Option<Result<()>> {
    let file = Path::new(COEFFICIENTS);
    file.exists().then(|| coefficients::check(file, robot))
}

/// Logs in the working directory, by the ends of their names.
fn logs_here(context: &Context) -> Vec<PathBuf> {
    let is_log = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        ending.is_some_and(|ending| LOGS.contains(&&*ending) && !(ending == "csv" && is_plan(context, path)))
    };
    let entries = std::fs::read_dir(".").into_iter().flatten().flatten();
    let mut logs: Vec<PathBuf> =
        entries.map(|entry| PathBuf::from(entry.file_name())).filter(is_log).collect();
    logs.sort();
    logs
}

/// A plan of `gmr predict` has no power.
fn is_plan(context: &Context, file: &Path) -> bool {
    let plan = |header: &Header| header.has("v_m_s") || header.has("distance_m");
    Header::open(context, file).is_ok_and(|header| plan(&header) && !header.has(POWER))
}

/// Names in a folder that begin so.
fn devices(folder: &str, begin: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| name.starts_with(begin)).collect();
    names.sort();
    names
}
