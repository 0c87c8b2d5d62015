//! What `gmr fit --grams` asks of sums in the place of logs, and what it is told.

use std::path::{Path, PathBuf};

use logs::robot::Robot;
use model::coefficients::ModelKind;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};

use crate::run_gram::{self, Fitted, LeftOut, Moved, RunGram, Step};

/// What is asked of sums.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Files of sums.
    pub files: &'a [PathBuf],
    /// Which model.
    pub kind: ModelKind,
    /// Whether each run is also predicted by the others.
    pub leave_one_out: bool,
}

/// A fit to sums as it is told.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// The robot's name.
    pub robot: String,
    /// How many there are.
    pub runs: usize,
    /// Of the filter that they were made with.
    pub filter_cutoff_hz: f64,
    /// The fit.
    #[serde(flatten)]
    pub fitted: Fitted,
    /// Each run by what the others say.
    pub left_out: Option<Vec<LeftOut>>,
}

/// Fits the model to sums.
///
/// # Errors
/// Files that are no grams, of another robot, or read with different settings; runs left out of the
/// signed model.
pub fn from_grams(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { robot, files, kind, leave_one_out } = *request;
    let runs = read(context, robot, files)?;
    let cutoff_hz = runs[0].setting.filter_cutoff_hz;
    let fitted = match kind {
        ModelKind::Signed => run_gram::signed(&robot.chassis(cutoff_hz)?, robot, &runs)?,
        ModelKind::Eq18 | ModelKind::Eq18Published => run_gram::eq18(kind, &runs)?,
    };
    let left_out = match (leave_one_out, kind) {
        (false, _) => None,
        (true, ModelKind::Signed) => {
            return Err(Error::usage(
                "--leave-one-out with --model signed: expected eq18 or eq18-published, whose sums hold every row",
            ));
        }
        (true, _) => Some(run_gram::leave_one_out(kind, &runs)?),
    };
    Ok(Answer {
        robot: robot.name().to_owned(),
        runs: runs.len(),
        filter_cutoff_hz: cutoff_hz,
        fitted,
        left_out,
    })
}

/// The runs of these files, of this robot.
fn read(context: &Context, robot: &Robot, files: &[PathBuf]) -> Result<Vec<RunGram>> {
    let mut runs: Vec<RunGram> = Vec::new();
    for file in files {
        let read = run_gram::read_all(context, file)?;
        let is_other =
            |run: &&RunGram| run.setting.robot != robot.name() || run.setting.wheels != robot.wheels();
        if let Some(other) = read.iter().find(is_other) {
            let message =
                format!("{} is of robot {}; expected {}", other.run, other.setting.robot, robot.name());
            return Err(Error::failed(message).in_file(file));
        }
        runs.extend(read);
    }
    Ok(runs)
}

/// What came of a step from known coefficients.
#[derive(Debug, Clone, Serialize)]
pub struct Stepped {
    /// The robot's name.
    pub robot: String,
    /// How many there are.
    pub runs: usize,
    /// Rows in which a wheel draws power.
    pub rows: u64,
    /// Their root mean square residual before.
    pub before_rmse_w: f64,
    /// The same after, as far as the model is linear in between.
    pub after_rmse_w: f64,
    /// The longest move, in standard errors: a further pass is worth it where it is not far below
    /// 1.
    pub longest_std_errs: f64,
    /// Parameter by parameter.
    pub parameters: Vec<Moved>,
}

/// The next coefficients of the signed model from sums near those of `near`; written where `out`
/// says so.
///
/// # Errors
/// As [`from_grams`]; sums near other coefficients.
pub fn step(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    near: &Path,
    out: Option<&Path>,
) -> Result<Stepped> {
    let runs = read(context, robot, files)?;
    let Step { file, told } = run_gram::step(robot, near, &runs)?;
    out.map_or(Ok(()), |out| file.write(out))?;
    Ok(Stepped {
        robot: robot.name().to_owned(),
        runs: runs.len(),
        rows: told.rows,
        before_rmse_w: told.before_rmse_w,
        after_rmse_w: told.after_rmse_w,
        longest_std_errs: told.longest_std_errs,
        parameters: told.moved,
    })
}
