//! The experiment's training drive of a seed, and what was learned from it: once for all that is driven afterwards.

use std::path::{Path, PathBuf};

use super::contender::{CONTENDERS, Fitted, Log, WHEELS, training};
use crate::compare::points::Wanted;
use crate::error::Result;
use crate::fit::dataset::Dataset;
use crate::plant::experiment::{Drive, scenario};
use crate::plant::log::{Column, Columns, write};
use crate::robot::Robot;

/// A training drive, and the contenders that were fitted to it.
pub(super) struct Learned<'a> {
    /// The robot.
    pub(super) robot: &'a Robot,
    /// Ours, the paper's, the paper's without its misprints.
    pub(super) fitted: Vec<Fitted<'a>>,
    folder: &'a Path,
    file: PathBuf,
    dataset: Dataset<WHEELS>,
    seed: u64,
}

/// Drives the training of a seed into the folder, and fits the contenders.
pub(super) fn learn<'a>(folder: &'a Path, robot: &'a Robot, seed: u64) -> Result<Learned<'a>> {
    let file = drive(folder, Drive::Training, seed)?;
    let dataset = training(robot, &file)?;
    let fitted = CONTENDERS.iter().map(|contender| contender.fit(robot, &dataset)).collect::<Result<_>>()?;
    Ok(Learned { robot, fitted, folder, file, dataset, seed })
}

impl Learned<'_> {
    /// Another drive of the seed, and what baselines may read of it and of the training.
    pub(super) fn drive(&self, which: Drive) -> Result<(Log, Wanted)> {
        let file = drive(self.folder, which, self.seed)?;
        let wanted = Wanted::of(self.robot, &[self.file.clone(), file.clone()])?;
        Ok((Log::read(self.robot, &self.dataset, &file, &wanted)?, wanted))
    }

    /// The training drive itself.
    pub(super) fn training(&self, wanted: &Wanted) -> Result<Log> {
        Log::read(self.robot, &self.dataset, &self.file, wanted)
    }
}

/// One drive as a log with every column that a baseline may need.
fn drive(folder: &Path, which: Drive, seed: u64) -> Result<PathBuf> {
    let columns = Columns {
        further: vec![Column::Command, Column::Imu, Column::Friction, Column::Pitch, Column::Slope],
        ..Columns::default()
    };
    let file = folder.join(format!("experiment-{}-{seed}.csv", which as u8));
    write(&file, &scenario(which, seed)?, &columns)?;
    Ok(file)
}
