//! The logs that differences of Eq. 18 are measured on.

use std::path::Path;

use super::Pair;
use crate::error::Result;
use crate::fit::dataset::{Dataset, Reading};
use crate::plant::Scenario;
use crate::plant::experiment::{self, Drive};
use crate::plant::log::{Columns, write};
use crate::reproduce::contender::{WHEELS, training};
use crate::reproduce::section6;
use crate::robot::Robot;

/// Section 6's, with exact sensors on motors that do not conserve energy, and the experiment's, with noise on motors that do.
pub(super) fn pairs(folder: &Path, robot: &Robot, seed: u64) -> Result<Vec<Pair<WHEELS>>> {
    let [train, test] = section6::scenarios(seed)?;
    let regime = [experiment::scenario(Drive::Training, seed)?, experiment::scenario(Drive::Test, seed)?];
    let table3 = pair(folder, robot, "Section 6", seed, &[train, test])?;
    Ok(vec![table3, pair(folder, robot, "experiment's regime", seed, &regime)?])
}

fn pair(
    folder: &Path,
    robot: &Robot,
    plant: &'static str,
    seed: u64,
    [train, test]: &[Scenario; 2],
) -> Result<Pair<WHEELS>> {
    let file = |name: &str| folder.join(format!("{plant}-{name}-{seed}.csv"));
    let (train_file, test_file) = (file("training"), file("test"));
    write(&train_file, train, &Columns::default())?;
    write(&test_file, test, &Columns::default())?;
    let training = training(robot, &train_file)?;
    // Behind the filter of the fit.
    let reading = Reading {
        gate: training.gate,
        cutoff_hz: Some(training.robot.cutoff_hz),
        mass_kg: robot.mass_no_load_kg(),
    };
    let test = Dataset::read(robot, &[test_file], &reading)?;
    Ok(Pair { plant, training, test, floor_w: robot.mape_floor_w() })
}
