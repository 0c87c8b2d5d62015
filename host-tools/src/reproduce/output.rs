//! The folder of a reproduction: written beside its place, and moved there whole.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::price::Price;
use super::print::Difference;
use super::standing::{Goal, Standings, goals};
use super::study::{
    Knob, ModelRow, Nearness, PublishedSimulation, Recalibration, Settings, SimulationRow, Spread, Study,
    WindowRow,
};
use super::{figures, page, table};
use crate::compare::LeftOut;
use crate::error::{Error, Result};
use crate::output::write_whole;

/// Only a reproduction has this file.
const STUDY: &str = "study.json";

/// The study's figures without its traces.
#[derive(Serialize)]
pub struct Figures<'a> {
    settings: &'a Settings,
    goals: Vec<Goal>,
    standings: Standings,
    published_simulation: &'a PublishedSimulation,
    simulation: &'a [SimulationRow],
    knobs: &'a [Knob],
    nearness: &'a [Nearness],
    static_power_w: (f64, f64),
    windows: &'a [WindowRow],
    models: &'a [ModelRow],
    left_out: &'a [LeftOut],
    share_known: &'a Spread,
    recalibration: &'a [Recalibration],
    price: &'a Price,
    print: &'a [Difference],
}

impl<'a> Figures<'a> {
    /// Of a study.
    pub fn of(study: &'a Study) -> Self {
        let (simulation, experiment) = (&study.simulation, &study.experiment);
        Self {
            settings: &study.settings,
            goals: goals(experiment),
            standings: Standings::of(&experiment.models),
            published_simulation: &simulation.published,
            simulation: &simulation.rows,
            knobs: &experiment.knobs,
            nearness: &experiment.nearness,
            static_power_w: experiment.rails.gaussian_w,
            windows: &experiment.windows,
            models: &experiment.models,
            left_out: &experiment.left_out,
            share_known: &experiment.share_known,
            recalibration: &study.recalibration,
            price: &study.price,
            print: &study.print,
        }
    }
}

/// Refuses a place that is taken by anything but an earlier reproduction: asked before the long work.
///
/// # Errors
/// A file, a folder of something else, or no folder to put it into.
pub fn check(folder: &Path) -> Result<()> {
    crate::output::folder_of(folder)?;
    let refused = |what: &str| Err(Error::failed(what.to_owned()).in_file(folder));
    match std::fs::read_dir(folder) {
        Ok(entries) => {
            if entries.count() == 0 || folder.join(STUDY).is_file() {
                return Ok(());
            }
            refused("holds something else; expected a new or empty folder, or an earlier reproduction")
        }
        Err(_) if std::fs::symlink_metadata(folder).is_err() => Ok(()),
        Err(error) => Err(Error::io(folder, &error)),
    }
}

/// Writes page, tables, figures and `study.json`; what an earlier reproduction left is replaced.
///
/// # Errors
/// As [`check`]; a figure cannot be drawn or a file not written: then the place is as it was.
pub fn save(study: &Study, folder: &Path) -> Result<()> {
    check(folder)?;
    let beside = crate::output::folder_of(folder)?;
    let refused = |error: std::io::Error| Error::io(folder, &error);
    let new = tempfile::Builder::new().prefix(".gmr-").tempdir_in(beside).map_err(refused)?;
    write(study, new.path())?;
    open_to_others(new.path()).map_err(refused)?;
    // The earlier one goes only when the new one is complete, and comes back if that cannot take its place.
    let old = tempfile::Builder::new().prefix(".gmr-").tempdir_in(beside).map_err(refused)?;
    let kept = old.path().join("earlier");
    let had = folder.exists();
    if had {
        std::fs::rename(folder, &kept).map_err(refused)?;
    }
    let moved = std::fs::rename(new.path(), folder);
    if moved.is_err() && had {
        std::fs::rename(&kept, folder).map_err(refused)?;
    }
    moved.map_err(refused)
}

fn write(study: &Study, folder: &Path) -> Result<()> {
    let put = |name: &str, text: &str| {
        let file = folder.join(name);
        write_whole(&file, |write| write.write_all(text.as_bytes()).map_err(|error| Error::io(&file, &error)))
    };
    put("tables.txt", &table::text(study))?;
    let json = serde_json::to_string_pretty(&Figures::of(study))
        .map_err(|error| Error::failed(error.to_string()))?;
    put(STUDY, &(json + "\n"))?;
    let drawings: PathBuf = folder.join("figures");
    std::fs::create_dir(&drawings).map_err(|error| Error::io(&drawings, &error))?;
    let figures = figures::all(study);
    for figure in &figures {
        for format in ["svg", "png"] {
            figure.page.save(&drawings.join(figure.name).with_extension(format))?;
        }
    }
    put("index.html", &page::text(study, figures)?)
}

/// A temporary folder is its owner's alone; this one is to be like any other.
#[cfg(unix)]
fn open_to_others(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn open_to_others(_: &Path) -> std::io::Result<()> {
    Ok(())
}
