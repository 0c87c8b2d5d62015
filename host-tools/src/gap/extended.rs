//! The coefficients with the effects that were named, written for estimator and board.

use std::path::Path;

use super::report::Report;
use crate::effects::written::Written;
use crate::fit::file;

/// Writes the coefficients with the effects that were named, and the base as it moved. What is not written is said in a line each on
/// standard error; where nothing is left, so is the file.
///
/// # Errors
/// The file cannot be written; the effects are more than a board holds.
pub fn write(report: &Report, base: &Path, out: &Path) -> crate::error::Result<()> {
    let mut effects = Vec::new();
    for named in &report.effects {
        match Written::of(&named.candidate, &named.coefficients, &named.std_errs) {
            Ok(effect) => effects.push(effect),
            Err(why) => eprintln!("gmr: {why}"),
        }
    }
    if effects.is_empty() {
        eprintln!("gmr: {}: not written: no effect is to be added", out.display());
        return Ok(());
    }
    if !report.ambiguous_with.is_empty() {
        eprintln!(
            "gmr: {}: its effects cannot be told from {}: power is predicted as well with either, the cause is open",
            out.display(),
            report.ambiguous_with.join(", ")
        );
    }
    file::extend(base, &report.state.torque, &effects, out)
}
