//! Notices about masses that a table of models needs.

use std::path::PathBuf;

use logs::{Header, MASS};
use support::context::Context;
use support::error::Result;

use super::ours::OURS;
use super::settings::Settings;
use crate::baselines::{self, Point};
use logs::robot::Robot;

/// Names each log without a mass, and the mass taken for it.
///
/// # Errors
/// A log cannot be read.
pub(super) fn tell_taken(context: &Context, robot: &Robot, files: &[PathBuf], mass_kg: f64) -> Result<()> {
    for (index, file) in files.iter().enumerate() {
        let is_weighed = robot.log_units().mass_of(file).is_some();
        if !is_weighed && !files[..index].contains(file) && !Header::open(context, file)?.has(MASS) {
            context.notice(format_args!("{}: no {MASS}: {mass_kg} kg taken (--mass)", file.display()));
        }
    }
    Ok(())
}

/// Warns if models take a mass that was another single value in all training: they extrapolate.
pub(super) fn tell_extrapolation<'a>(
    context: &Context,
    settings: &Settings,
    training: impl Iterator<Item = &'a Point>,
    test: impl Iterator<Item = &'a Point>,
) {
    let takes = |name: &&str| {
        OURS.iter().any(|model| model.name == *name)
            || baselines::every().any(|card| card.takes_mass && card.name == *name)
    };
    let [only] = masses(training)[..] else { return };
    let others: Vec<String> =
        masses(test).iter().filter(|mass| !same(**mass, only)).map(f64::to_string).collect();
    if !others.is_empty() && settings.models.iter().any(takes) {
        let others = others.join(", ");
        context.notice(format_args!(
            "training at {only} kg only, test at {others} kg: models that take the mass extrapolate"
        ));
    }
}

/// To the gram, as a fit distinguishes payloads.
pub(super) fn same(one: f64, other: f64) -> bool {
    (one - other).abs() < 1e-3
}

/// Masses in order of appearance, at most [`MOST_MASSES`](fit::dataset::MOST_MASSES).
fn masses<'a>(points: impl Iterator<Item = &'a Point>) -> Vec<f64> {
    let mut known: Vec<f64> = Vec::new();
    for point in points {
        if known.len() < fit::dataset::MOST_MASSES && !known.iter().any(|mass| same(*mass, point.mass)) {
            known.push(point.mass);
        }
    }
    known
}
