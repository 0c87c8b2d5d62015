//! A robot's own coefficients, by its sums near the fleet's, in Open-RMF's words.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use answers::export::rmf::{Export, export};
use answers::export::{cruise_m_s, straight_w};
use fit::run_gram::{RunGram, step};
use logs::robot::Robot;
use serde::Serialize;
use support::error::{Error, Result};
use support::output::write_content;
use support::printable;

use super::drift::Drift;
use super::keys::{DAY, ROBOT, key};
use super::rank::Standing;

/// A file that Open-RMF reads.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Exported {
    /// Of which robot.
    pub robot: String,
    /// Its file.
    pub file: PathBuf,
    /// As written.
    pub friction_coefficient: f64,
    /// Of the file that was there before.
    pub before: Option<f64>,
}

impl Exported {
    /// What its friction is off the last file's, %.
    pub fn drift_percent(&self) -> Option<f64> {
        let before = self.before.filter(|before| *before > 0.0)?;
        Some(100.0 * (self.friction_coefficient / before - 1.0))
    }
}

/// Gives each robot its power when driving straight, W, and its coefficients in Open-RMF's words at
/// the mean of its masses; none where its runs do not determine them. Only runs since a change
/// count.
pub(super) fn models(
    robot: &Robot,
    coeffs: &Path,
    standings: &mut [Standing],
    runs: &[&RunGram],
    drift: &Drift,
) -> Vec<Option<Export>> {
    let mut of: BTreeMap<&str, Vec<&RunGram>> = BTreeMap::new();
    for run in runs {
        of.entry(key(run, ROBOT)).or_default().push(run);
    }
    let model = |standing: &mut Standing| {
        let since = drift.changes.iter().find(|change| change.robot == standing.robot);
        let counts = |run: &&&RunGram| since.is_none_or(|change| key(run, DAY) >= &*change.since);
        let all = of.get(&*standing.robot)?;
        let counted: Vec<RunGram> = all.iter().filter(counts).map(|run| (*run).clone()).collect();
        let (watts, mut export) = of_one(robot, coeffs, standing, &counted).ok()?;
        standing.straight_w = Some(watts);
        export.robot = printable::name(&standing.robot);
        Some(export)
    };
    standings.iter_mut().map(model).collect()
}

fn of_one(robot: &Robot, coeffs: &Path, standing: &Standing, runs: &[RunGram]) -> Result<(f64, Export)> {
    let coefficients = step(robot, coeffs, runs)?.file.coefficients;
    let speed = cruise_m_s(robot);
    // Of the same mass for all: robots that carry more do not stand out by it.
    let watts = straight_w(robot, &coefficients, robot.mass_no_load_kg(), speed)?;
    Ok((watts, export(robot, &coefficients, standing.mean_mass_kg, speed, robot.static_power_w())?))
}

/// Writes a file a robot, and reads of the one before what its friction was.
///
/// # Errors
/// What the operating system refuses.
pub(super) fn write(
    folder: &Path,
    robot: &Robot,
    standings: &[Standing],
    models: &[Option<Export>],
) -> Result<Vec<Exported>> {
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    let known =
        standings.iter().zip(models).filter_map(|(standing, model)| Some((standing, model.as_ref()?)));
    let write = |(standing, model): (&Standing, &Export)| {
        let file = folder.join(format!("{}.yaml", standing.robot));
        let before = std::fs::read_to_string(&file).ok().as_deref().and_then(friction);
        write_content(&file, model.yaml(robot))?;
        let friction_coefficient = model.mechanical_system.friction_coefficient;
        Ok(Exported { robot: standing.robot.clone(), file, friction_coefficient, before })
    };
    known.map(write).collect()
}

/// Of a file as [`Export::yaml`] writes it.
fn friction(yaml: &str) -> Option<f64> {
    let (_, behind) = yaml.split_once("friction_coefficient: ")?;
    behind.split_whitespace().next()?.parse().ok()
}
