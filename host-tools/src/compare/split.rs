//! Logs divided into what is fitted and what is evaluated.

use std::path::{Path, PathBuf};

use super::points::{self, Wanted};
use super::{Settings, mass};
use crate::baselines::Point;
use crate::error::{Error, Result};
use crate::fit::dataset::{Dataset, Reading, Row};
use crate::log::Exclusions;
use crate::robot::Robot;

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
    /// Blocks of time of the same logs, every so many a test block.
    Blocks {
        /// The logs.
        files: Vec<PathBuf>,
        /// Length of a block, s; at most [`BLOCK_S`], and a sixth of the longest run, unless given.
        block_s: Option<f64>,
    },
}

/// Length of held-out blocks, s: longer than any correlation of filtered power, short enough for several kinds of driving.
pub const BLOCK_S: f64 = 5.0;

/// One in this many blocks is held out.
pub const HOLD_OUT: i64 = 3;

/// Training rows as a dataset and as points, test rows behind the same filter.
pub(super) struct Data<const N: usize> {
    pub(super) wanted: Wanted,
    pub(super) train: Dataset<N>,
    pub(super) training: Vec<Point>,
    pub(super) test: Vec<(Row<N>, Point)>,
}

impl<const N: usize> Data<N> {
    pub(super) fn read(robot: &Robot, split: &Split, settings: &Settings) -> Result<Self> {
        let reading =
            Reading { gate: model_core::eq18::Gate::Signed, cutoff_hz: None, mass_kg: settings.mass_kg };
        let (files, others): (&[PathBuf], &[PathBuf]) = match split {
            Split::Files { train, test } => (train, test),
            Split::Blocks { files, .. } => (files, &[]),
        };
        let all = [files, others].concat();
        let wanted = Wanted::of(robot, &all)?;
        let mut train = Dataset::<N>::read(robot, files, &reading)?;
        let core = train.robot;
        // The fit has told already what it excluded.
        let read = points::read(robot, &core, files, settings.mass_kg, &wanted, train.stride)?;
        let (training, test) = match split {
            Split::Files { test, .. } => {
                let tell = |file: &Path, exclusions: Exclusions| {
                    if exclusions.total() > 0 {
                        eprintln!("gmr: {}: {exclusions}", file.display());
                    }
                };
                let test = points::read_telling(robot, &core, test, settings.mass_kg, (&wanted, 1), tell)?;
                if test.is_empty() {
                    return Err(Error::failed("no usable row to evaluate on").in_file(&others[0]));
                }
                (read, test)
            }
            Split::Blocks { block_s, .. } => {
                let block_s = block_s.unwrap_or_else(|| BLOCK_S.min(longest_run(&train.store) / 6.0));
                let held_out = |time: f64| (time / block_s).floor() as i64 % HOLD_OUT == HOLD_OUT - 1;
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
        // A log that is refused says no more than why.
        mass::tell_taken(&all, settings.mass_kg)?;
        Ok(Self { wanted, train, training, test })
    }
}

/// Duration of the longest run, s.
fn longest_run<const N: usize>(rows: &[Row<N>]) -> f64 {
    let durations =
        rows.chunk_by(|a, b| a.run == b.run).filter_map(|run| Some(run.last()?.time - run.first()?.time));
    durations.fold(0.0, f64::max)
}
