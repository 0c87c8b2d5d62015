//! What `gmr gram` asks of logs, and what it is told.

use std::path::{Path, PathBuf};

use logs::robot::Robot;
use rayon::prelude::*;
use serde::Serialize;
use support::context::Context;
use support::error::Result;
use support::progress::CountProgress;

use super::files::write_all;
use super::how::How;
use super::run::{RunGram, total};

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot, which knows in which units its logs are.
    pub robot: &'a Robot,
    /// The logs.
    pub logs: &'a [PathBuf],
    /// Coefficients whose filter is taken, and near which sums are taken as well.
    pub near: Option<&'a Path>,
    /// Without such coefficients: the filter's cutoff; none: as a fit of these logs would choose
    /// it.
    pub cutoff_hz: Option<f64>,
    /// Total mass of logs that do not tell it, kg.
    pub mass_kg: f64,
}

/// What was written.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// Where.
    pub file: PathBuf,
    /// How many there are.
    pub runs: usize,
    /// Of all of them.
    pub rows: u64,
    /// Of the filter.
    pub filter_cutoff_hz: f64,
    /// Of all of them.
    pub distance_m: f64,
    /// Of all of them.
    pub energy_j: f64,
    /// Rows in which a wheel may have been clamped.
    pub may_clamp_rows: u64,
}

impl Request<'_> {
    /// How such logs are read.
    ///
    /// # Errors
    /// As [`How::near`], [`How::at`] and [`How::chosen`].
    pub fn how(&self, context: &Context) -> Result<How> {
        let Self { robot, logs, near, cutoff_hz, mass_kg } = *self;
        match (near, cutoff_hz) {
            (Some(file), _) => How::near(robot, file, mass_kg),
            (None, Some(cutoff_hz)) => How::at(robot, cutoff_hz, mass_kg),
            (None, None) => How::chosen(context, robot, logs, mass_kg),
        }
    }
}

/// Sums logs up into a file, a log a core.
///
/// # Errors
/// A log or coefficients that cannot be read or are not of this robot; a file that cannot be
/// written.
pub fn gram(context: &Context, request: &Request<'_>, out: &Path) -> Result<Answer> {
    let Request { robot, logs, .. } = *request;
    let how = request.how(context)?;
    let progress = CountProgress::new(context, "logs read", logs.len() as u64);
    let of_log = |log: &PathBuf| {
        let runs = how.of_log(context, robot, log).map(|summed| summed.runs);
        progress.one_more();
        runs
    };
    let of_logs: Vec<Result<Vec<RunGram>>> = logs.par_iter().map(of_log).collect();
    drop(progress);
    let runs: Vec<RunGram> = of_logs.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    for run in runs.iter().filter(|run| run.summary.exclusions.total() > 0) {
        context.notice(format_args!("{}: {}", run.run, run.summary.exclusions));
    }
    write_all(out, &runs)?;
    let all = total(&runs)?;
    Ok(Answer {
        file: out.to_owned(),
        runs: runs.len(),
        rows: all.summary.rows,
        filter_cutoff_hz: how.filter_cutoff_hz,
        distance_m: all.summary.distance_m,
        energy_j: all.summary.energy_j,
        may_clamp_rows: all.may_clamp,
    })
}
