//! What `gmr fleet` asks of a folder of logs, and what it is told: read what is new, keep its sums,
//! judge all.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use ::logs::checks::check_mass;
use ::logs::foreign;
use ::logs::robot::Robot;
use fit::run_gram::{How, RunGram, Spent, Summed, write_all};
use model_core::torque::TorqueModel;
use rayon::prelude::*;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::progress::CountProgress;

use super::abstain::{Judged, judge};
use super::disagree::{Disagreements, disagreements};
use super::drift::{Change, Drift, changes};
use super::finding::finding;
use super::logs::{Log, Place};
use super::models::{self, Exported};
use super::outlier::{Outliers, outliers};
use super::page::{Content, save};
use super::rank::{Standing, rank};
use super::source::Source;
use super::state::{Outcome, State};

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot that they all are, which knows in which units its logs are.
    pub robot: &'a Robot,
    /// A folder, or a bucket's URL.
    pub source: &'a Path,
    /// Coefficients that robots and days are held against.
    pub coeffs: &'a Path,
    /// What folders are called, from the outermost one; robot and day among them.
    pub group: &'a [String],
    /// Where everything goes.
    pub out: &'a Path,
    /// Total mass of logs that do not tell it, kg.
    pub mass_kg: f64,
    /// Whether a file for Open-RMF is written for each robot.
    pub rmf: bool,
    /// Where figures for Prometheus go.
    pub metrics: Option<&'a Path>,
}

/// What was found, and where the time went: files are the same however long they took.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// As it is kept in fleet.json.
    #[serde(flatten)]
    pub report: Report,
    /// Files for Open-RMF, if asked for, and how far they are from those that were there before.
    pub exported: Vec<Exported>,
    /// Beside it, on standard output only.
    pub seconds: Seconds,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Who stands out, in one sentence.
    pub finding: String,
    /// How many there are.
    pub logs: usize,
    /// Of all of them.
    pub rows: u64,
    /// The robots, the dearest first.
    pub robots: Vec<Standing>,
    /// What changed on which since when.
    pub changes: Vec<Change>,
    /// How often that was asked.
    pub questions: usize,
    /// From which on a change stands out; none where nothing could be asked.
    pub threshold: Option<f64>,
    /// Robots of which nothing can be said, and why.
    pub silent: Vec<(String, String)>,
    /// Who stands out.
    pub outliers: Outliers,
    /// Runs that disagree.
    pub disagreements: Disagreements,
    /// Every run.
    pub runs: Vec<Judged>,
}

/// Where the time went.
#[derive(Debug, Clone, Serialize, Default)]
pub struct Seconds {
    /// s of each core, added up.
    #[serde(flatten)]
    pub logs: Spent,
    /// Keeping and collecting sums, s.
    pub sums_kept_s: f64,
    /// Who changed, stands out and disagrees, s.
    pub judging_s: f64,
    /// Writing the page and the figures, s.
    pub page_s: f64,
    /// From the first log to the last, s.
    pub all_logs_s: f64,
}

/// Reads what is new of a fleet's logs, and says what all of them say.
///
/// # Errors
/// Folder or coefficients cannot be read; keys without robot and day; a file that cannot be
/// written.
pub fn fleet(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { robot, coeffs, group, out, mass_kg: mass, rmf, metrics, .. } = *request;
    for key in ["robot", "day"] {
        if !group.iter().any(|known| known == key) {
            return Err(Error::usage(format!(
                "--group without {key}; expected robot and day among the keys"
            )));
        }
    }
    check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    let how = How::near(robot, coeffs, mass)?;
    let reference = how.reference.as_ref().map_or(TorqueModel::default(), |(reference, _)| reference.torque);
    let source = Source::of(request.source)?;
    let logs = source.find(context, group)?;
    let file = |log: &Log| match &log.place {
        Place::File(path) => Some(path.clone()),
        #[cfg(feature = "bucket")]
        Place::Object { .. } => None,
    };
    if let Some(inside) = logs.iter().filter_map(file).find(|path| path.starts_with(out)) {
        return Err(
            Error::usage("is in the folder that is to be written; expected --out elsewhere").in_file(inside)
        );
    }
    // With other coefficients, units or masses everything is read again.
    let settings = format!("{:?} {robot:?} {mass} {group:?}", how.reference);
    let state = State::open(out.join("read"), &settings)?;
    let started = Instant::now();
    let New { spent, not_now } = read_new(context, robot, &how, &source, &logs, &state, out)?;
    let mut seconds =
        Seconds { logs: spent, all_logs_s: started.elapsed().as_secs_f64(), ..Seconds::default() };
    let started = Instant::now();
    let (grams, mut judged) = collect(&logs, &state, not_now)?;
    write_all(&out.join("grams.jsonl"), &grams)?;
    seconds.sums_kept_s = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let verdicts: Vec<Judged> = grams.iter().map(|run| judge(run, group)).collect();
    let used: Vec<&RunGram> =
        grams.iter().zip(&verdicts).filter(|(_, verdict)| verdict.is_used).map(|(run, _)| run).collect();
    let mut standings = rank(&used);
    let drift = changes(&used, &reference);
    let models = models::models(robot, coeffs, &mut standings, &used, &drift);
    let outliers = outliers(&used, &reference, &drift);
    let disagreements = disagreements(&used, &drift);
    let finding = finding(&standings, &drift, &outliers, &disagreements);
    seconds.judging_s = started.elapsed().as_secs_f64();
    let started = Instant::now();
    judged.extend(verdicts);
    judged.sort_by(|a, b| a.run.cmp(&b.run));
    let content = Content {
        finding: &finding,
        standings: &standings,
        drift: &drift,
        outliers: &outliers,
        disagreements: &disagreements,
        judged: &judged,
    };
    save(&out.join("fleet.html"), &content)?;
    let Drift { changes, asked, threshold, silent, .. } = drift;
    let exported = if rmf { models::write(&out.join("rmf"), robot, &standings, &models)? } else { vec![] };
    let report = Report {
        finding,
        logs: logs.len(),
        rows: grams.iter().map(|run| run.summary.rows).sum(),
        robots: standings,
        changes,
        questions: asked,
        threshold,
        silent,
        outliers,
        disagreements,
        runs: judged,
    };
    output::write_content(&out.join("fleet.json"), output::json(&report)? + "\n")?;
    if let Some(file) = metrics {
        super::metrics::save(file, &report)?;
    }
    seconds.page_s = started.elapsed().as_secs_f64();
    Ok(Answer { report, exported, seconds })
}

/// What came of the logs that had not been read.
#[derive(Default)]
struct New {
    spent: Spent,
    /// Logs that the operating system would not give just now, and what it said.
    not_now: BTreeMap<String, String>,
}

/// Reads what has not been read yet, a log a core.
fn read_new(
    context: &Context,
    robot: &Robot,
    how: &How,
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
/// What it would be wrong to remember: too many open files, no right to read, no space. Another
/// time it may be given.
fn read(context: &Context, robot: &Robot, how: &How, log: &Log, path: &Path) -> Result<(Outcome, Spent)> {
    let summed = how.of_log(context, robot, path);
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
