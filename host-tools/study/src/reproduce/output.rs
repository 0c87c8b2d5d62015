//! The folder of a reproduction: written beside its place, and moved there whole.

use std::path::{Path, PathBuf};

use support::error::{Error, Result};
use support::output::write_content;
use support::temporary;

use super::study::Study;
use super::{figures, page};

/// Only a reproduction has this file.
const STUDY: &str = "study.json";

const INDEX: &str = "index.html";

const TABLES: &str = "tables.txt";

/// The folder of the drawings.
const FIGURES: &str = "figures";

/// Each is drawn in all of them.
const FORMATS: [&str; 2] = ["svg", "png"];

/// What may stand in a folder's place.
const EXPECTED: &str = "expected a new or empty folder, or an earlier reproduction";

/// Refuses a place that holds anything but an earlier reproduction: before the long work.
///
/// # Errors
/// A file, a folder with anything in it that no reproduction writes, or no folder to put it into.
pub fn check(folder: &Path) -> Result<()> {
    place(folder).map(|_| ())
}

/// Where the reproduction goes: the target of a link, which stays.
fn place(folder: &Path) -> Result<PathBuf> {
    let refused = |what: String| Err(Error::failed(format!("{what}; {EXPECTED}")).in_file(folder));
    let Ok(real) = std::fs::canonicalize(folder) else {
        if folder.is_symlink() {
            return refused("is a link to nothing".to_owned());
        }
        support::output::folder_of(folder)?;
        return Ok(folder.to_owned());
    };
    if !real.is_dir() {
        return refused("is not a folder".to_owned());
    }
    let failed = |error: std::io::Error| Error::io(folder, &error);
    if let Some(foreign) = foreign(&real).map_err(failed)? {
        return refused(format!("holds {foreign}, which is not of a reproduction"));
    }
    if !real.join(STUDY).is_file() && std::fs::read_dir(&real).map_err(failed)?.next().is_some() {
        return refused(format!("holds no {STUDY}"));
    }
    Ok(real)
}

/// The first name in the folder, or in its figures, that [`write`] does not make.
fn foreign(folder: &Path) -> std::io::Result<Option<String>> {
    let is_file = |path: &Path| std::fs::symlink_metadata(path).is_ok_and(|file| file.is_file());
    let ours = [INDEX, TABLES, STUDY];
    let mut foreign = Vec::new();
    for (name, path) in entries(folder)? {
        if name == FIGURES && path.is_dir() && !path.is_symlink() {
            let figure = |name: &str| {
                let stem = FORMATS.iter().find_map(|format| name.strip_suffix(format)?.strip_suffix('.'));
                stem.is_some_and(|stem| figures::NAMES.contains(&stem))
            };
            let others = entries(&path)?.into_iter().filter(|(name, path)| !(figure(name) && is_file(path)));
            foreign.extend(others.map(|(inner, _)| format!("{name}/{inner}")));
        } else if !(ours.contains(&name.as_str()) && is_file(&path)) {
            foreign.push(name);
        }
    }
    Ok(foreign.into_iter().min())
}

/// Names and paths of what is in a folder.
fn entries(folder: &Path) -> std::io::Result<Vec<(String, PathBuf)>> {
    let named = |entry: std::fs::DirEntry| (entry.file_name().to_string_lossy().into_owned(), entry.path());
    std::fs::read_dir(folder)?.map(|entry| entry.map(named)).collect()
}

/// Writes page, tables, figures and `study.json`; what an earlier reproduction left is replaced.
///
/// # Errors
/// As [`check`]; a figure cannot be drawn or a file not written: then the place is as it was.
pub fn save(study: &Study, folder: &Path) -> Result<()> {
    let place = place(folder)?;
    let beside = support::output::folder_of(&place)?;
    let refused = |error: std::io::Error| Error::io(folder, &error);
    let (new, _new) = temporary::folder_in(beside).map_err(refused)?;
    write(study, new.path())?;
    open_to_others(new.path()).map_err(refused)?;
    // The earlier one is removed only when the new one is complete, and restored if the new one
    // cannot take its place.
    let old = tempfile::Builder::new().prefix(".gmr-").tempdir_in(beside).map_err(refused)?;
    let kept = old.path().join("earlier");
    let had = place.exists();
    if had {
        std::fs::rename(&place, &kept).map_err(refused)?;
    }
    let moved = std::fs::rename(new.path(), &place);
    if moved.is_err() && had {
        std::fs::rename(&kept, &place).map_err(refused)?;
    }
    moved.map_err(refused)
}

fn write(study: &Study, folder: &Path) -> Result<()> {
    let put = |name: &str, text: &str| write_content(&folder.join(name), text);
    put(TABLES, &study.text())?;
    let json =
        serde_json::to_string_pretty(&study.json()).map_err(|error| Error::failed(error.to_string()))?;
    put(STUDY, &(json + "\n"))?;
    let drawings: PathBuf = folder.join(FIGURES);
    std::fs::create_dir(&drawings).map_err(|error| Error::io(&drawings, &error))?;
    for figure in &study.figures {
        for format in FORMATS {
            figure.page.save(&drawings.join(figure.name).with_extension(format))?;
        }
    }
    put(INDEX, &page::text(study)?)
}

/// A temporary folder is private; this one is to be like any other.
#[cfg(unix)]
fn open_to_others(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn open_to_others(_: &Path) -> std::io::Result<()> {
    Ok(())
}
