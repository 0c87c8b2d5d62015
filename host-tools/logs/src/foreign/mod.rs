//! Logs in other formats: bags of ROS 2 (MCAP, SQLite), ULog, Parquet. A call turns each into rows
//! once, in a temporary file that whoever opens the log reads in its place; a Parquet file has such
//! rows already.

mod choose;
mod columns;
mod drivers;
mod glance;
mod known;
mod rows;
mod spool;
#[cfg(test)]
mod tests;
mod wrong;

use std::collections::HashMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use log_formats::table::Columns;
use log_formats::{Bag, Format, folder};
use rayon::prelude::*;
use support::context::Context;
use support::error::{Error, Result};
use support::input::Input;

use crate::robot::Robot;

pub use wrong::wrong;

pub use choose::{Chosen, NamedPower, choose, named_power};
pub use columns::{Column, Expression};
pub use glance::{CHARGE, CURRENT, SPEED, TURN, glance};
pub use known::wheel_joints;
pub(crate) use spool::Spool;
use spool::Writer;

/// How a call reads logs in other formats ([`Context::with_reading`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Its kinematics and topics.
    pub robot: Robot,
    /// What is left of a file that was cut off is read as well.
    pub allow_cut: bool,
    /// Which topic became which column is said.
    pub verbose: bool,
}

/// Logs that a call has turned into rows, by their name. Each has a lock of its own: others are
/// read meanwhile.
type Known = Mutex<HashMap<PathBuf, Arc<Mutex<Option<Turned>>>>>;

/// Length and time of the file, the way that it was read, and its rows.
struct Turned {
    version: Version,
    reading: Option<Reading>,
    spool: Spool,
    said: Vec<String>,
}

/// Of a file that may have been written again since.
type Version = (u64, Option<SystemTime>);

/// Gives up the rows of a log that the call does not open again.
pub fn forget(context: &Context, path: &Path) {
    context.kept::<Known>().lock().unwrap_or_else(PoisonError::into_inner).remove(path);
}

/// Turns logs into rows, as many at once as there are cores, for whoever opens them after this.
/// What is wrong with one, its reader says. Pipes are left alone: they are opened in the order in
/// which they are read.
pub fn prepare(context: &Context, paths: &[PathBuf]) {
    let stays = |path: &&PathBuf| std::fs::metadata(path).is_ok_and(|data| data.is_file() || data.is_dir());
    paths.par_iter().filter(stays).for_each(|path| drop(turned(context, path, false)));
}

/// Where rows are that are no text.
pub(super) enum Rows {
    /// In a Parquet file.
    File(Columns),
    /// Made of a bag or a pipe.
    Spool(Spool),
}

/// Opens a log in another format; `None` of one that is text.
///
/// # Errors
/// What the operating system refuses; a format that is not read, or content that gives no rows.
pub(super) fn open(context: &Context, path: &Path) -> Result<Option<Rows>> {
    match columns(context, path)? {
        Some(columns) => Ok(Some(Rows::File(columns))),
        None => Ok(turned(context, path, true)?.map(Rows::Spool)),
    }
}

/// A bag's rows; `None` of a log that is text or a Parquet file. What there is to say of them is
/// said once, to whoever opens them first.
fn turned(context: &Context, path: &Path, is_opened: bool) -> Result<Option<Spool>> {
    let mut input = Input::open(context, path)?;
    let is_folder = input.metadata().is_dir();
    if is_folder && !folder::is_bag(path) {
        return Ok(None);
    }
    let format =
        if is_folder { None } else { format_of(&mut input).map_err(|error| Error::io(path, &error))? };
    let has_rows = format == Some(Format::Parquet) && input.metadata().is_file();
    if has_rows || format.is_none() && !is_folder {
        return Ok(None);
    }
    let version = (input.metadata().len(), input.metadata().modified().ok());
    let reading = context.reading::<Reading>();
    let log = {
        let known = context.kept::<Known>();
        let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(known.entry(path.to_owned()).or_default())
    };
    // Locked while it is read: whoever else of this call wants this log waits for it.
    let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
    let is_as_before = |log: &Turned| log.version == version && log.reading.as_ref() == reading;
    if !log.as_ref().is_some_and(is_as_before) {
        let (spool, said) =
            turn(context, path, &input, format, reading).map_err(|error| error.in_file(path))?;
        *log = Some(Turned { version, reading: reading.cloned(), spool, said });
    }
    let Some(turned) = log.as_mut() else { return Ok(None) };
    if is_opened {
        for line in std::mem::take(&mut turned.said) {
            context.notice(format_args!("{}: {line}", path.display()));
        }
    }
    Ok(Some(turned.spool.clone()))
}

/// Opens a Parquet file by its columns: it needs no rows as text. `None` of anything else, and of a
/// pipe.
///
/// # Errors
/// What the operating system refuses; a file that is cut off or damaged.
fn columns(context: &Context, path: &Path) -> Result<Option<Columns>> {
    let mut input = Input::open(context, path)?;
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

/// Opens a bag, of a pipe as well: the file holds what came through it, as long as it is needed.
/// `None` of a table or text.
///
/// # Errors
/// Content that is not what its format says.
pub fn bag_of(
    context: &Context,
    path: &Path,
    allow_cut: bool,
) -> Result<Option<(Bag, Option<tempfile::NamedTempFile>)>> {
    let mut input = Input::open(context, path)?;
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
    let (file, kept) = on_disk(context, path, &input)?;
    let bag = Bag::open(&file, allow_cut).map_err(named)?;
    Ok(log_formats::table::topic(&bag).is_none().then_some((bag, kept)))
}

/// A file that can be sought in.
fn on_disk(
    context: &Context,
    path: &Path,
    input: &Input,
) -> Result<(PathBuf, Option<tempfile::NamedTempFile>)> {
    if input.metadata().is_file() {
        return Ok((path.to_owned(), None));
    }
    let refused = |error: io::Error| Error::io(path, &error);
    let mut kept = tempfile::NamedTempFile::new().map_err(refused)?;
    io::copy(&mut Input::open(context, path)?, &mut kept).map_err(refused)?;
    Ok((kept.path().to_owned(), Some(kept)))
}

/// The rows of a file, or of a bag's folder, which has no format of its own.
fn turn(
    context: &Context,
    path: &Path,
    input: &Input,
    format: Option<Format>,
    reading: Option<&Reading>,
) -> Result<(Spool, Vec<String>)> {
    let (file, _kept) = match format {
        Some(format) => {
            format.check().map_err(wrong)?;
            on_disk(context, path, input)?
        }
        None => (path.to_owned(), None),
    };
    let allow_cut = reading.is_some_and(|reading| reading.allow_cut);
    let mut writer = Writer::new().map_err(|error| Error::io(path, &error))?;
    let said = if format == Some(Format::Parquet) {
        rows::of_parquet(&file, &mut writer)?
    } else {
        let bag = Bag::open(&file, allow_cut).map_err(wrong)?;
        match (log_formats::table::topic(&bag), reading) {
            (Some(topic), _) => rows::of_table(&bag, topic, &mut writer)?,
            (None, Some(reading)) => rows::of_bag(&bag, &reading.robot, reading.verbose, &mut writer)?,
            (None, None) => rows::of_bag(&bag, &Robot::named("burger")?, false, &mut writer)?,
        }
    };
    Ok((writer.finish()?, said))
}
