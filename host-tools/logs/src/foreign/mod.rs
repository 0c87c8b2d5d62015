//! Logs in other formats: bags of ROS 2 (MCAP, SQLite), ULog, Parquet. Each is turned into rows of this dialect once, in a temporary file that
//! whoever opens the log reads in its place, so that all that stands on rows stays as it is.
//!
//! Numbers are written with as many digits as give them back bit for bit.

mod choose;
mod columns;
mod drivers;
mod glance;
mod known;
mod rows;
mod wrong;

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::SystemTime;

use log_formats::table::Columns;
use log_formats::{Bag, Format, folder};
use support::error::{Error, Result};
use support::input::{Input, Spool};

use crate::robot::Robot;

pub use wrong::wrong;

pub use choose::{Chosen, choose};
pub use columns::{Column, Expression};
pub use glance::{CHARGE, CURRENT, SPEED, TURN, glance};
pub use known::wheel_joints;

/// How logs in other formats are read, for the whole of this process: a command reads its robot before its logs.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Its kinematics and topics.
    pub robot: Robot,
    /// What is left of a file that was cut off is read as well.
    pub allow_cut: bool,
    /// Which topic became which column is said.
    pub verbose: bool,
}

static READING: Mutex<Option<Arc<Reading>>> = Mutex::new(None);

/// Logs that have been turned into rows, by their name: length and time of the file, the way that it was read, and its rows.
type Known = HashMap<PathBuf, (Version, Option<Arc<Reading>>, Spool)>;

/// Of a file that may have been written again since.
type Version = (u64, Option<SystemTime>);
static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(Mutex::default);

/// Sets how logs in other formats are read from now on.
pub fn read_as(reading: Reading) {
    *READING.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(reading));
}

/// Gives up the rows of a log that nobody opens again.
pub fn forget(path: &Path) {
    KNOWN.lock().unwrap_or_else(PoisonError::into_inner).remove(path);
}

/// Opens a log: itself where it is text, its rows where it is in another format.
///
/// # Errors
/// What the operating system refuses; a format that is not read, or content that gives no rows.
pub(super) fn open(path: &Path) -> Result<Input> {
    let mut input = Input::open(path)?;
    let is_folder = input.metadata().is_dir();
    if is_folder && !folder::is_bag(path) {
        return Ok(input);
    }
    let format =
        if is_folder { None } else { format_of(&mut input).map_err(|error| Error::io(path, &error))? };
    if format.is_none() && !is_folder {
        return Input::open(path);
    }
    let version = (input.metadata().len(), input.metadata().modified().ok());
    let reading = READING.lock().unwrap_or_else(PoisonError::into_inner).clone();
    // Locked while it is read: whoever else wants this log waits for it.
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((read, as_before, spool)) = known.get(path)
        && (*read, as_before) == (version, &reading)
    {
        return Input::of_spool(path, spool);
    }
    let spool = turn(path, input, format, reading.as_deref()).map_err(|error| error.in_file(path))?;
    known.insert(path.to_owned(), (version, reading, spool.clone()));
    Input::of_spool(path, &spool)
}

/// Opens a Parquet file by its columns: it needs no rows as text. `None` of anything else, and of a pipe.
///
/// # Errors
/// What the operating system refuses; a file that is cut off or damaged.
pub(super) fn columns(path: &Path) -> Result<Option<Columns>> {
    let mut input = Input::open(path)?;
    if !input.metadata().is_file() {
        return Ok(None);
    }
    match format_of(&mut input).map_err(|error| Error::io(path, &error))? {
        Some(Format::Parquet) => Columns::open(path).map(Some).map_err(|error| wrong(error).in_file(path)),
        _ => Ok(None),
    }
}

fn format_of(input: &mut Input) -> io::Result<Option<Format>> {
    let mut head = Vec::new();
    input.take(Format::HEAD_BYTES as u64).read_to_end(&mut head)?;
    Ok(Format::of(&head))
}

/// Opens a bag, of a pipe as well: the file holds what came through it, as long as it is needed. `None` of a table or text.
///
/// # Errors
/// Content that is not what its format says.
pub fn bag_of(path: &Path, allow_cut: bool) -> Result<Option<(Bag, Option<tempfile::NamedTempFile>)>> {
    let mut input = Input::open(path)?;
    let named = |error| wrong(error).in_file(path);
    if input.metadata().is_dir() {
        if !folder::is_bag(path) {
            return Ok(None);
        }
        let bag = Bag::open(path, allow_cut).map_err(named)?;
        return Ok(log_formats::table::topic(&bag).is_none().then_some((bag, None)));
    }
    let format = format_of(&mut input).map_err(|error| Error::io(path, &error))?;
    let Some(format) = format.filter(|format| *format != Format::Parquet) else { return Ok(None) };
    format.check().map_err(named)?;
    let (file, kept) = on_disk(path, &input)?;
    let bag = Bag::open(&file, allow_cut).map_err(named)?;
    Ok(log_formats::table::topic(&bag).is_none().then_some((bag, kept)))
}

/// A file that can be sought in.
fn on_disk(path: &Path, input: &Input) -> Result<(PathBuf, Option<tempfile::NamedTempFile>)> {
    if input.metadata().is_file() {
        return Ok((path.to_owned(), None));
    }
    let refused = |error: io::Error| Error::io(path, &error);
    let mut kept = tempfile::NamedTempFile::new().map_err(refused)?;
    io::copy(&mut Input::open(path)?, &mut kept).map_err(refused)?;
    Ok((kept.path().to_owned(), Some(kept)))
}

/// The rows of a file, or of a bag's folder, which has no format of its own.
fn turn(path: &Path, input: Input, format: Option<Format>, reading: Option<&Reading>) -> Result<Spool> {
    let (file, _kept) = match format {
        Some(format) => {
            format.check().map_err(wrong)?;
            on_disk(path, &input)?
        }
        None => (path.to_owned(), None),
    };
    let allow_cut = reading.is_some_and(|reading| reading.allow_cut);
    let spool: File = tempfile::tempfile().map_err(|error| Error::io(path, &error))?;
    let said = if format == Some(Format::Parquet) {
        rows::of_parquet(&file, &spool)?
    } else {
        let bag = Bag::open(&file, allow_cut).map_err(wrong)?;
        match (log_formats::table::topic(&bag), reading) {
            (Some(topic), _) => rows::of_table(&bag, topic, &spool)?,
            (None, Some(reading)) => rows::of_bag(&bag, &reading.robot, reading.verbose, &spool)?,
            (None, None) => rows::of_bag(&bag, &Robot::load("burger")?, false, &spool)?,
        }
    };
    for line in said {
        support::notice!("{}: {line}", path.display());
    }
    Spool::new(spool).map_err(|error| Error::io(path, &error))
}
