//! `gmr fit --grams`: the fit from sums, without the logs.

use std::path::{Path, PathBuf};

use fit::run_gram::{self, Fitted, LeftOut, Moved, RunGram, Step};
use logs::robot::Robot;
use model::coefficients::ModelKind;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output;

#[derive(Serialize)]
struct Report<'a> {
    robot: &'a str,
    runs: usize,
    filter_cutoff_hz: f64,
    #[serde(flatten)]
    fitted: &'a Fitted,
    left_out: Option<&'a [LeftOut]>,
}

/// Fits `model` to the sums of these files; with `leave_one_out` also every run by what the others say.
///
/// # Errors
/// Files that are no grams, of another robot, or read with different settings.
pub(super) fn run<const N: usize>(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    model: ModelKind,
    leave_one_out: bool,
    json: bool,
) -> Result<()> {
    let runs = read::<N>(context, robot, files)?;
    let setting = &runs[0].setting;
    let fitted = match model {
        ModelKind::Signed => run_gram::signed(&robot.core::<N>(setting.filter_cutoff_hz)?, robot, &runs)?,
        ModelKind::Eq18 | ModelKind::Eq18Published => run_gram::eq18(model, &runs)?,
    };
    let left_out = match (leave_one_out, model) {
        (false, _) => None,
        (true, ModelKind::Signed) => {
            return Err(Error::usage(
                "--leave-one-out with --model signed: expected eq18 or eq18-published, whose sums hold every row",
            ));
        }
        (true, _) => Some(run_gram::leave_one_out(model, &runs)?),
    };
    fitted.warnings.iter().for_each(|warning| context.notice(warning));
    if json {
        return output::print_json(&Report {
            robot: robot.name(),
            runs: runs.len(),
            filter_cutoff_hz: setting.filter_cutoff_hz,
            fitted: &fitted,
            left_out: left_out.as_deref(),
        });
    }
    println!(
        "{}: {} rows of {} runs, by their sums; R² {}, RMSE {:.4} W",
        robot.name(),
        fitted.rows,
        runs.len(),
        fitted.r2.map_or("–".to_owned(), |r2| format!("{r2:.5}")),
        fitted.rmse_w
    );
    for parameter in &fitted.parameters {
        let error = parameter.std_err.map_or("–".to_owned(), |error| format!("{error:.2e}"));
        println!("  {:<14} {:>12.5e} ± {error:<9} {}", parameter.name, parameter.value, parameter.unit);
    }
    for run in left_out.iter().flatten() {
        let r2 = run.r2.map_or("–".to_owned(), |r2| format!("{r2:.4}"));
        println!("  without {}: R² {r2}, RMSE {:.4} W on its {} rows", run.run, run.rmse_w, run.rows);
    }
    Ok(())
}

/// The runs of these files, of this robot.
fn read<const N: usize>(context: &Context, robot: &Robot, files: &[PathBuf]) -> Result<Vec<RunGram>> {
    let mut runs: Vec<RunGram> = Vec::new();
    for file in files {
        let read = run_gram::read_all(context, file)?;
        if let Some(other) =
            read.iter().find(|run| run.setting.robot != robot.name() || run.setting.wheels != N)
        {
            let message =
                format!("{} is of robot {}; expected {}", other.run, other.setting.robot, robot.name());
            return Err(Error::failed(message).in_file(file));
        }
        runs.extend(read);
    }
    Ok(runs)
}

#[derive(Serialize)]
struct Stepped<'a> {
    robot: &'a str,
    runs: usize,
    rows: u64,
    before_rmse_w: f64,
    after_rmse_w: f64,
    longest_std_errs: f64,
    parameters: &'a [Moved],
}

/// The next coefficients from sums near those of `near`.
///
/// # Errors
/// As [`run`]; sums near other coefficients; another model than the signed one.
pub(super) fn step<const N: usize>(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    near: &Path,
    model: ModelKind,
    out: Option<&Path>,
    json: bool,
) -> Result<()> {
    if model != ModelKind::Signed {
        return Err(Error::usage(
            "--coeffs with --model eq18: expected signed; Eq. 18 needs no step from known coefficients",
        ));
    }
    let runs = read::<N>(context, robot, files)?;
    let step = run_gram::step::<N>(robot, near, &runs)?;
    if let Some(out) = out {
        step.file.write(out)?;
    }
    let Step { moved, rows, before_rmse_w, after_rmse_w, longest_std_errs, .. } = &step;
    if json {
        return output::print_json(&Stepped {
            robot: robot.name(),
            runs: runs.len(),
            rows: *rows,
            before_rmse_w: *before_rmse_w,
            after_rmse_w: *after_rmse_w,
            longest_std_errs: *longest_std_errs,
            parameters: moved,
        });
    }
    println!(
        "{}: a step from {}, by the sums of {rows} rows of {} runs; RMSE {before_rmse_w:.4} → {after_rmse_w:.4} W",
        robot.name(),
        near.display(),
        runs.len()
    );
    for Moved { name, unit, before, after, std_err } in moved {
        println!("  {name:<14} {before:>12.5e} → {after:>12.5e} ± {std_err:<9.2e} {unit}");
    }
    println!(
        "the longest move is {longest_std_errs:.2} standard errors: below 0.1 another pass changes nothing that matters"
    );
    if let Some(out) = out {
        println!("wrote {}", out.display());
    }
    Ok(())
}
