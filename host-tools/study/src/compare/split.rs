//! Logs divided into training and test.

use std::path::{Path, PathBuf};

use fit::dataset::{Dataset, Reading, Row};
use fit::form::{TERMS_WITH_GYRO, Term};
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::{Exclusions, Header, YAW_RATE};
use model_core::conditioning::Conditioning;
use model_core::eq18::Gate;
use support::context::Context;
use support::error::{Error, Result};

use super::points::{self, Wanted};
use super::settings::Settings;
use super::{cutoff, delay, mass};
use crate::baselines::Point;

/// Where training ends and testing begins.
#[derive(Debug, Clone)]
pub enum Split {
    /// Logs of their own for both.
    Files {
        /// Logs to fit.
        train: Vec<PathBuf>,
        /// Logs to evaluate.
        test: Vec<PathBuf>,
    },
    /// Blocks of time of the same logs: every [`HOLD_OUT`]-th is a test block.
    Blocks {
        /// The logs.
        files: Vec<PathBuf>,
        /// Length of a block, s; at most [`BLOCK_S`], and a sixth of the longest run, unless given.
        block_s: Option<f64>,
    },
}

/// Length of held-out blocks, s: longer than any correlation of filtered power, short enough for
/// several kinds of driving.
pub const BLOCK_S: f64 = 5.0;

/// One in this many blocks is held out.
pub const HOLD_OUT: i64 = 3;

/// Training rows as a dataset and as points; test rows with the same filter and delay.
pub(super) struct Data {
    pub(super) wanted: Wanted,
    pub(super) train: Dataset,
    pub(super) training: Vec<Point>,
    pub(super) test: Vec<(Row, Point)>,
    /// The robot with cutoff and delay alone.
    plain: Chassis,
}

impl Data {
    pub(super) fn read(context: &Context, robot: &Robot, split: &Split, settings: &Settings) -> Result<Self> {
        let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg: settings.mass_kg };
        let (files, others): (&[PathBuf], &[PathBuf]) = match split {
            Split::Files { train, test } => (train, test),
            Split::Blocks { files, .. } => (files, &[]),
        };
        let all = [files, others].concat();
        let wanted = Wanted::of(context, robot, &all)?;
        if files.is_empty() {
            return Err(Error::usage("no log was given"));
        }
        let given = robot.filter_cutoff_hz();
        let mass_kg = settings.mass_kg;
        let choose = || cutoff::choose(context, robot, files, mass_kg, |points| split.training(points));
        let mut core = robot.chassis(given.map_or_else(choose, Ok)?)?;
        let undelayed = points::read(context, robot, &core, files, mass_kg, &wanted, 1)?;
        let undelayed: Vec<Point> = undelayed.into_iter().map(|(_, point)| point).collect();
        let block_s = match split {
            Split::Blocks { block_s, .. } => block_s.unwrap_or_else(|| default_block(undelayed.iter())),
            Split::Files { .. } => f64::INFINITY,
        };
        let held_out = |time: f64| is_held_out(time, block_s);
        let delay = delay::choose(&split.training(undelayed));
        core = core.with_conditioning(Conditioning { delay, ..*core.conditioning() });
        let headers = all.iter().map(|file| Header::open(context, file)).collect::<Result<Vec<_>>>()?;
        let gyro = headers.iter().all(|header| header.has(YAW_RATE));
        let plain = core;
        let mut train = dataset(context, robot, &plain, gyro, files, &reading, &held_out)?;
        let core = train.robot.clone();
        // The fit has already reported its exclusions.
        let read = points::read(context, robot, &core, files, settings.mass_kg, &wanted, train.stride)?;
        let (training, test) = match split {
            Split::Files { test, .. } => {
                let tell = |file: &Path, exclusions: Exclusions| {
                    if exclusions.total() > 0 {
                        context.notice(format_args!("{}: {exclusions}", file.display()));
                    }
                };
                let test =
                    points::read_telling(context, robot, &core, test, settings.mass_kg, (&wanted, 1), tell)?;
                if test.is_empty() {
                    return Err(Error::failed("no usable row to evaluate on").in_file(&others[0]));
                }
                (read, test)
            }
            Split::Blocks { .. } => {
                train.store.retain(|row| !held_out(row.time));
                let (test, training): (Vec<_>, Vec<_>) =
                    read.into_iter().partition(|(row, _)| held_out(row.time));
                if test.is_empty() || training.is_empty() {
                    return Err(Error::failed(format!(
                        "the log is too short to hold out blocks of {block_s} s; expected at least {} s",
                        HOLD_OUT as f64 * block_s
                    ))
                    .in_file(&files[0]));
                }
                (training, test)
            }
        };
        let training = training.into_iter().map(|(_, point)| point).collect();
        // Only after logs were accepted: a refusal stands alone.
        mass::tell_taken(context, robot, &all, settings.mass_kg)?;
        Ok(Self { wanted, train, training, test, plain })
    }

    /// The training logs for a model that has no gyro.
    pub(super) fn without_gyro(
        &self,
        context: &Context,
        robot: &Robot,
        files: &[PathBuf],
        mass_kg: f64,
    ) -> Result<Dataset> {
        let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg };
        dataset(context, robot, &self.plain, false, files, &reading, &|_| false)
    }
}

/// Logs for the signed model: the delay is every model's, other terms are its own.
fn dataset(
    context: &Context,
    robot: &Robot,
    plain: &Chassis,
    gyro: bool,
    files: &[PathBuf],
    reading: &Reading,
    held_out: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Dataset> {
    let asked = |term: &Term| *term != Term::Delay && (gyro || *term != Term::TrueSlip);
    let terms: Vec<Term> = TERMS_WITH_GYRO.into_iter().filter(asked).collect();
    let form = fit::choose_form(context, robot, plain, &terms, files, reading.mass_kg, held_out)?;
    let core = plain.with_conditioning(form.conditioning);
    let mut train = Dataset::read(context, robot, core, files, reading)?;
    train.free_terms = form.free_terms;
    Ok(train)
}

impl Split {
    /// The points of the training logs that may be used before models are judged: all but the
    /// blocks held out.
    fn training(&self, mut points: Vec<Point>) -> Vec<Point> {
        if let Self::Blocks { block_s, .. } = self {
            let block_s = block_s.unwrap_or_else(|| default_block(points.iter()));
            points.retain(|point| !is_held_out(point.time, block_s));
        }
        points
    }
}

fn is_held_out(time_s: f64, block_s: f64) -> bool {
    (time_s / block_s).floor() as i64 % HOLD_OUT == HOLD_OUT - 1
}

/// [`BLOCK_S`], or a sixth of the longest run if that is less, s.
fn default_block<'a>(points: impl Iterator<Item = &'a Point>) -> f64 {
    let mut ends: Option<(u32, f64)> = None;
    let mut longest = 0.0_f64;
    for point in points {
        match ends {
            Some((run, start)) if run == point.run => longest = longest.max(point.time - start),
            _ => ends = Some((point.run, point.time)),
        }
    }
    BLOCK_S.min(longest / 6.0)
}
