//! `gmr fleet`: a folder of logs of many robots, ranked, and what changed on which since when.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use fit::run_gram::{self, Conditioned, RunGram, Spent, Summed};
use fleet::{
    self, Change, Disagreements, Drift, Found, Judged, Log, Outcome, Outliers, Place, Source, Standing, State,
};
use logs::checks::check_mass;
use logs::foreign;
use logs::robot::Robot;
use logs::with_wheels;
use model_core::torque::TorqueModel;
use rayon::prelude::*;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::progress::CountProgress;

use super::units::UnitArguments;

/// Arguments of `gmr fleet`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr fleet logs/ --coeffs coefficients.toml --out fleet/")]
pub(crate) struct Arguments {
    /// Folder of logs (CSV, Parquet, MCAP, db3, ULog, bag, DataFlash) in folders such as robot=7/day=2026-11-02, or 7/2026-11-02; with the feature bucket also the URL
    /// of a bucket, s3://bucket/logs
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    /// Coefficients of a clean fit (signed) of such a robot: what robots and days are held against
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// The robot that they all are: a robot.toml, or burger, turtlebot4, warthog, husky
    #[arg(long, default_value = "burger")]
    robot: PathBuf,
    /// What folders are called, from the outermost one; robot and day among them
    #[arg(long, value_name = "KEY,…", value_delimiter = ',', default_value = "robot,day")]
    group: Vec<String>,
    /// Where everything goes: grams.jsonl, fleet.html, fleet.json, and what has been read so far. A second run reads only what is new
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
}

#[derive(Serialize)]
struct Report<'a> {
    logs: usize,
    rows: u64,
    robots: &'a [Standing],
    changes: &'a [Change],
    questions: usize,
    threshold: Option<f64>,
    silent: &'a [(String, String)],
    outliers: &'a Outliers,
    disagreements: &'a Disagreements,
    runs: &'a [Judged],
}

/// Beside the report, on standard output only: files are the same however long they took.
#[derive(Serialize)]
struct Timed<'a> {
    #[serde(flatten)]
    report: &'a Report<'a>,
    seconds: Seconds,
}

/// Where the time went.
#[derive(Serialize, Default)]
struct Seconds {
    /// s of each core, added up.
    #[serde(flatten)]
    logs: Spent,
    /// Keeping and collecting sums, s.
    sums_kept_s: f64,
    /// Who changed, stands out and disagrees, s.
    judging_s: f64,
    /// Writing the page and the figures, s.
    page_s: f64,
    /// From the first log to the last, s.
    all_logs_s: f64,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, [])?;
    with_wheels!(robot, run_with(context, robot, arguments))
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    for key in ["robot", "day"] {
        if !arguments.group.iter().any(|known| known == key) {
            return Err(Error::usage(format!(
                "--group without {key}; expected robot and day among the keys"
            )));
        }
    }
    let mass = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    let how = Conditioned::<N>::near(robot, &arguments.coeffs, mass)?;
    let reference = how.reference.as_ref().map_or(TorqueModel::default(), |(reference, _)| reference.torque);
    let source = Source::of(&arguments.source)?;
    let logs = source.find(context, &arguments.group)?;
    let file = |log: &Log| match &log.place {
        Place::File(path) => Some(path.clone()),
        Place::Object { .. } => None,
    };
    if let Some(inside) = logs.iter().filter_map(file).find(|path| path.starts_with(&arguments.out)) {
        return Err(
            Error::usage("is in the folder that is to be written; expected --out elsewhere").in_file(inside)
        );
    }
    // With other coefficients, units or masses everything is read again.
    let settings = format!("{:?} {:?} {mass} {:?}", how.reference, robot, arguments.group);
    let state = State::open(arguments.out.join("read"), &settings)?;
    let started = Instant::now();
    let New { spent, not_now } = read_new(context, robot, &how, &source, &logs, &state, &arguments.out)?;
    let mut seconds =
        Seconds { logs: spent, all_logs_s: started.elapsed().as_secs_f64(), ..Seconds::default() };
    let started = Instant::now();
    let (grams, mut judged) = collect(&logs, &state, not_now)?;
    run_gram::write_all(&arguments.out.join("grams.jsonl"), &grams)?;
    seconds.sums_kept_s = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let verdicts: Vec<Judged> = grams.iter().map(|run| fleet::judge(run, &arguments.group)).collect();
    let used: Vec<&RunGram> =
        grams.iter().zip(&verdicts).filter(|(_, verdict)| verdict.is_used).map(|(run, _)| run).collect();
    let standings = fleet::rank(&used);
    let drift = fleet::changes(&used, &reference);
    let outliers = fleet::outliers(&used, &reference, &drift);
    let disagreements = fleet::disagreements(&used, &drift);
    seconds.judging_s = started.elapsed().as_secs_f64();
    let started = Instant::now();
    judged.extend(verdicts);
    judged.sort_by(|a, b| a.run.cmp(&b.run));
    let found = Found {
        standings: &standings,
        drift: &drift,
        outliers: &outliers,
        disagreements: &disagreements,
        judged: &judged,
    };
    fleet::save(&arguments.out.join("fleet.html"), &found)?;
    let report = Report {
        logs: logs.len(),
        rows: grams.iter().map(|run| run.summary.rows).sum(),
        robots: &standings,
        changes: &drift.changes,
        questions: drift.asked,
        threshold: drift.threshold,
        silent: &drift.silent,
        outliers: &outliers,
        disagreements: &disagreements,
        runs: &judged,
    };
    let file = arguments.out.join("fleet.json");
    output::write_content(&file, output::json(&report)? + "\n")?;
    seconds.page_s = started.elapsed().as_secs_f64();
    if arguments.json {
        return output::print_json(&Timed { report: &report, seconds });
    }
    print_text(&report, &drift, &arguments.out);
    Ok(())
}

/// What came of the logs that had not been read.
#[derive(Default)]
struct New {
    spent: Spent,
    /// Logs that the operating system would not give just now, and what it said.
    not_now: BTreeMap<String, String>,
}

/// Reads what has not been read yet, a log a core.
fn read_new<const N: usize>(
    context: &Context,
    robot: &Robot,
    how: &Conditioned<N>,
    source: &Source,
    logs: &[Log],
    state: &State,
    out: &Path,
) -> Result<New> {
    let progress = CountProgress::new(context, "logs read", logs.len() as u64);
    let unread = |log: &&Log| {
        let is_unread = state.done(log).is_none();
        if !is_unread {
            progress.one_more();
        }
        is_unread
    };
    let unread: Vec<&Log> = logs.par_iter().filter(unread).collect();
    let new = Mutex::new(New::default());
    let change = || new.lock().unwrap_or_else(PoisonError::into_inner);
    source.each(&unread, &out.join("fetched"), |log, here| {
        match here.and_then(|path| read(context, robot, how, log, path)) {
            Ok((outcome, spent)) => {
                change().spent.add(&spent);
                state.keep(log, outcome)?;
            }
            Err(refused) => {
                change().not_now.insert(log.name.clone(), refused.to_string());
            }
        }
        progress.one_more();
        Ok(())
    })?;
    Ok(new.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// What comes of a log that is here as this file.
///
/// # Errors
/// What it would be wrong to remember: too many open files, no right to read, no space. Another time it may be given.
fn read<const N: usize>(
    context: &Context,
    robot: &Robot,
    how: &Conditioned<N>,
    log: &Log,
    path: &Path,
) -> Result<(Outcome, Spent)> {
    let summed = run_gram::of_log(context, robot, how, path);
    // Nobody opens it again, and a fleet has more logs than a process may have files open.
    foreign::forget(context, path);
    let file = path.display().to_string();
    match summed {
        Ok(Summed { mut runs, spent }) => {
            for run in &mut runs {
                run.run = run.run.replacen(&file, &log.name, 1);
                run.keys.clone_from(&log.keys);
            }
            Ok((Outcome::Read(runs), spent))
        }
        Err(refused) => {
            let told = refused.to_string().replace(&file, &log.name);
            if refused.is_of_system() {
                return Err(Error::failed(told));
            }
            Ok((Outcome::Refused(told), Spent::default()))
        }
    }
}

/// All that has been read, in the order of the logs: as it was kept, whoever read it.
fn collect(
    logs: &[Log],
    state: &State,
    not_now: BTreeMap<String, String>,
) -> Result<(Vec<RunGram>, Vec<Judged>)> {
    let (mut grams, mut refused) = (Vec::new(), Vec::new());
    let mut refuse = |log: &Log, why: String| {
        refused.push(Judged { run: log.name.clone(), is_used: false, notes: vec![why] });
    };
    let done: Vec<Option<Outcome>> = logs.par_iter().map(|log| state.done(log)).collect();
    for (log, done) in logs.iter().zip(done) {
        match (done, not_now.get(&log.name)) {
            (Some(Outcome::Read(runs)), _) => grams.extend(runs),
            (Some(Outcome::Refused(why)), _) => refuse(log, why),
            (None, Some(why)) => {
                refuse(log, format!("{why}; not read, and not remembered: the next run tries again"));
            }
            (None, None) => return Err(Error::failed("has changed while it was read").in_file(&log.name)),
        }
    }
    Ok((grams, refused))
}

/// Robots listed on a terminal.
const MOST_SHOWN: usize = 10;

fn print_text(report: &Report<'_>, drift: &Drift, out: &Path) {
    let left_out = report.runs.iter().filter(|run| !run.is_used).count();
    println!(
        "{} logs, {} rows; {} runs, {left_out} of them left out",
        report.logs,
        report.rows,
        report.runs.len()
    );
    for change in report.changes {
        println!("{}", change.sentence());
    }
    if report.changes.is_empty() {
        println!("no change that stands out of how runs differ by chance");
    }
    for (robot, why) in &drift.silent {
        println!("{robot}: nothing can be said: {why}");
    }
    for outlier in &report.outliers.found {
        println!("{}", outlier.sentence());
    }
    for run in &report.disagreements.found {
        println!("{}", run.sentence());
    }
    for standing in report.robots.iter().take(MOST_SHOWN) {
        let cost = standing.energy_per_metre_j_m.map_or("–".to_owned(), |cost| format!("{cost:.3}"));
        println!(
            "  {:<20} {cost:>9} J/m at {:.2} kg over {:.0} m",
            standing.robot, standing.mean_mass_kg, standing.distance_m
        );
    }
    if let Some(more) = report.robots.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        println!("  and {more} more, on the page");
    }
    for run in report.runs.iter().filter(|run| !run.is_used) {
        println!("  left out: {}: {}", run.run, run.notes.join("; "));
    }
    println!("wrote {}", out.join("fleet.html").display());
}
