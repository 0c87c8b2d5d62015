//! What logs that are looked at whole have to be, before any long work: each once, and of a size
//! that the robot can have.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use support::context::Context;
use support::error::{Error, Result};

pub use super::masses::{check_mass, masses};
use super::robot::chassis::Together;
use super::runs::Runs;

/// Refuses logs that are there twice: a run that is open and locked, or clean and in the field,
/// confirms itself.
///
/// # Errors
/// Names the log and its double; a log cannot be read.
pub fn each_once(field: &[PathBuf], clean: &[PathBuf]) -> Result<()> {
    let sized = |files: &[PathBuf]| -> Result<Vec<(PathBuf, Option<u64>)>> {
        let size = |file: &PathBuf| {
            let metadata = std::fs::metadata(file).map_err(|error| Error::io(file, &error))?;
            Ok((file.clone(), metadata.is_file().then_some(metadata.len())))
        };
        files.iter().map(size).collect()
    };
    let (field, clean) = (sized(field)?, sized(clean)?);
    for (place, (file, size)) in field.iter().enumerate() {
        if let Some((other, _)) = double(file, *size, &field[..place])? {
            let message = format!("the same log as {}; expected every run once", other.display());
            return Err(Error::usage(message).in_file(file));
        }
        if let Some((other, _)) = double(file, *size, &clean)? {
            let message = format!(
                "the same log as {}, to which the coefficients were fitted; expected runs of the field that they have not seen",
                other.display()
            );
            return Err(Error::usage(message).in_file(file));
        }
    }
    for (place, (file, size)) in clean.iter().enumerate() {
        if let Some((other, _)) = double(file, *size, &clean[..place])? {
            let message = format!("the same clean log as {}; expected every run once", other.display());
            return Err(Error::usage(message).in_file(file));
        }
    }
    Ok(())
}

/// The first of some files with the content of this one.
fn double<'a>(
    file: &Path,
    size: Option<u64>,
    others: &'a [(PathBuf, Option<u64>)],
) -> Result<Option<&'a (PathBuf, Option<u64>)>> {
    for other in others {
        // What is no file cannot be read twice.
        if size.is_some() && size == other.1 && is_same(file, &other.0)? {
            return Ok(Some(other));
        }
    }
    Ok(None)
}

fn is_same(one: &Path, other: &Path) -> Result<bool> {
    let open = |file: &Path| -> Result<BufReader<File>> {
        Ok(BufReader::new(File::open(file).map_err(|error| Error::io(file, &error))?))
    };
    let (mut first_log, mut second_log) = (open(one)?, open(other)?);
    let (mut a, mut b) = ([0; 8192], [0; 8192]);
    loop {
        let read = |reader: &mut BufReader<File>, file: &Path, buffer: &mut [u8]| -> Result<usize> {
            let mut filled = 0;
            while filled < buffer.len() {
                match reader.read(&mut buffer[filled..]).map_err(|error| Error::io(file, &error))? {
                    0 => break,
                    count => filled += count,
                }
            }
            Ok(filled)
        };
        let (first, second) = (read(&mut first_log, one, &mut a)?, read(&mut second_log, other, &mut b)?);
        if a[..first] != b[..second] {
            return Ok(false);
        }
        if first == 0 {
            return Ok(true);
        }
    }
}

/// Says where no run moves.
pub fn say_where_none_moves(context: &Context, runs: &Runs) {
    if !runs.runs.iter().any(|run| run.rows.iter().any(|row| row.wheels.is_moving())) {
        context.notice("the robot moves in none of these runs: effects of motion cannot be seen");
    }
}
