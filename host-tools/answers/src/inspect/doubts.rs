//! Logs that no answer can be computed from, told before it is.

use std::path::PathBuf;

use logs::robot::Robot;
use support::context::Context;
use support::error::{Error, Result};

use super::finding::{Finding, Severity};
use super::report::Report;

/// The first problem of some logs, and in which of them it is.
///
/// # Errors
/// As [`Report::of`].
pub fn first_problem(
    context: &Context,
    robot: &Robot,
    logs: &[PathBuf],
) -> Result<Option<(PathBuf, Finding)>> {
    for log in logs {
        let report = Report::of(context, log, robot, &mut |_, _| {})?;
        let problem = report.findings.into_iter().find(|finding| finding.severity == Severity::Problem);
        if let Some(problem) = problem {
            return Ok(Some((log.clone(), problem)));
        }
    }
    Ok(None)
}

/// Refuses logs in other units or with negative power, but where that is `forced`; says what other
/// problems they have.
///
/// # Errors
/// The first such log, with the remedy; as [`Report::of`].
pub fn check(context: &Context, robot: &Robot, logs: &[PathBuf], forced: bool) -> Result<()> {
    for log in logs {
        let report = Report::of(context, log, robot, &mut |_, _| {})?;
        // Without two rows of one run there is no log, as whoever reads it says.
        if report.rate_hz.is_none() {
            continue;
        }
        let problems = report.findings.iter().filter(|finding| finding.severity == Severity::Problem);
        for Finding { text, advice, is_misread, .. } in problems {
            let said = Error::failed(format!("{text}; {advice}")).in_file(log);
            if *is_misread && !forced {
                return Err(said);
            }
            context.notice(said);
        }
    }
    Ok(())
}
