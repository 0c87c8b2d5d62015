//! The signed model of runs in memory, as [`from_logs`](super::from_logs) fits it to files.

use std::path::PathBuf;

use logs::robot::Robot;
use logs::runs::RawRun;
use logs::{Conditioner, RawRow};
use model_core::eq18::Gate;
use support::error::Result;

use crate::dataset::{Dataset, Kept, Run, condition};
use crate::form::{TERMS, Term};
use crate::from_logs::fit_choosing;
use crate::gram::Gram;
use crate::pilot::Pilots;
use crate::{Fit, form, pgd};
use model::coefficients::{Method, ModelKind};

/// Fits the model behind a filter of `cutoff_hz`, with those further terms that the runs ask for.
///
/// # Errors
/// As [`crate::fit`]; a run that is too slow for the filter.
pub fn of_runs(robot: &Robot, runs: &[RawRun], cutoff_hz: f64) -> Result<Fit> {
    let pilots = Pilots::of_runs(runs);
    let plain = robot.chassis(cutoff_hz)?;
    let read = |terms: &[Term]| {
        let choice = form::choose(robot, &plain, terms, &pilots, &|_| false, None);
        let core = plain.clone().with_conditioning(choice.form.conditioning);
        let mut dataset = Dataset::empty(core, Gate::Signed);
        dataset.period_s = runs.first().map_or(f64::NAN, |run| run.period_s);
        for (place, run) in runs.iter().enumerate() {
            let file = PathBuf::from(&run.name);
            let mut conditioner = Conditioner::of_log(&dataset.robot, &file, run.period_s)?;
            for raw in rows(run) {
                dataset.rows += 1;
                if let Some(row) = condition(&mut conditioner, &raw, f64::NAN) {
                    dataset.take(Kept { run: place as u32, ..row });
                }
            }
            dataset.runs.push(Run { file, gram: Gram::default() });
        }
        dataset.free_terms = choice.form.free_terms;
        dataset.long_search = choice.long_search;
        Ok((dataset, choice.judged))
    };
    let (kind, method) = (ModelKind::Signed, Method::Physical);
    Ok(fit_choosing(robot, kind, method, &pgd::Settings::default(), &TERMS, read)?.0)
}

/// Rows of a run as a reader of its log gives them.
pub(super) fn rows(run: &RawRun) -> impl Iterator<Item = RawRow> {
    let mut last = f64::NEG_INFINITY;
    run.rows.iter().zip(2..).map(move |(&(time, sample, mass, _), line)| {
        let elapsed = time - last;
        last = time;
        RawRow { line, sample, elapsed, mass: Some(mass), run: 0, time, yaw_rate: f64::NAN }
    })
}
