//! `gmr fit --grams`: the fit from sums, without the logs.

use std::path::{Path, PathBuf};

use fit::from_grams::{self, Request, Stepped, from_grams};
use fit::run_gram::Moved;
use logs::robot::Robot;
use model::coefficients::ModelKind;
use support::context::Context;
use support::error::{Error, Result};
use support::output;

/// Fits `model` to the sums of these files; with `leave_one_out` also every run by what the others
/// say.
///
/// # Errors
/// As [`from_grams`].
pub(super) fn run(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    model: ModelKind,
    leave_one_out: bool,
    json: bool,
) -> Result<()> {
    let answer = from_grams(context, &Request { robot, files, kind: model, leave_one_out })?;
    let fitted = &answer.fitted;
    fitted.warnings.iter().for_each(|warning| context.notice(warning));
    if json {
        return output::print_json(&answer);
    }
    println!(
        "{}: {} rows of {} runs, by their sums; R² {}, RMSE {:.4} W",
        answer.robot,
        fitted.rows,
        answer.runs,
        fitted.r2.map_or("–".to_owned(), |r2| format!("{r2:.5}")),
        fitted.rmse_w
    );
    for parameter in &fitted.parameters {
        let error = parameter.std_err.map_or("–".to_owned(), |error| format!("{error:.2e}"));
        println!("  {:<14} {:>12.5e} ± {error:<9} {}", parameter.name, parameter.value, parameter.unit);
    }
    for run in answer.left_out.iter().flatten() {
        let r2 = run.r2.map_or("–".to_owned(), |r2| format!("{r2:.4}"));
        println!("  without {}: R² {r2}, RMSE {:.4} W on its {} rows", run.run, run.rmse_w, run.rows);
    }
    Ok(())
}

/// The next coefficients from sums near those of `near`.
///
/// # Errors
/// As [`from_grams::step`]; another model than the signed one.
pub(super) fn step(
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
    let stepped = from_grams::step(context, robot, files, near, out)?;
    if json {
        return output::print_json(&stepped);
    }
    let Stepped { rows, runs, before_rmse_w, after_rmse_w, longest_std_errs, parameters, .. } = &stepped;
    println!(
        "{}: a step from {}, by the sums of {rows} rows of {runs} runs; RMSE {before_rmse_w:.4} → {after_rmse_w:.4} W",
        stepped.robot,
        near.display()
    );
    for Moved { name, unit, before, after, std_err } in parameters {
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
