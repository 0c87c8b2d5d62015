//! Files are written whole or not at all; whoever reads standard output may leave at any time.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Mutex;

use crate::error::{Error, Result};

/// Writes `file` through a temporary file in the same folder that takes its name only when complete. Gives what `write` gives.
///
/// # Errors
/// What `write` or the operating system reports; the old file, if any, is then still there.
pub fn write_whole<T>(file: &Path, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
    let refused = |error: io::Error| Error::io(file, &error);
    // A link keeps pointing at its file. A device or a pipe has no content to keep, and no file may take its place.
    let target = std::fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    if std::fs::metadata(&target).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        let mut device = std::fs::File::options().write(true).open(&target).map_err(refused)?;
        return write(&mut device);
    }
    let mut temporary =
        temporary(folder_of(&target).map_err(|error| error.in_file(file))?).map_err(refused)?;
    let written = {
        let mut buffered = io::BufWriter::new(temporary.as_file_mut());
        let written = write(&mut buffered)?;
        buffered.flush().map_err(refused)?;
        written
    };
    temporary.persist(&target).map_err(|error| refused(error.error))?;
    Ok(written)
}

/// The folder that a file is written into: commands ask before they start long work.
///
/// # Errors
/// There is no such folder.
pub fn folder_of(file: &Path) -> Result<&Path> {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.is_dir() {
        return Ok(folder);
    }
    let message = format!("the folder {} does not exist; expected one to write into", folder.display());
    Err(Error::failed(message).in_file(file))
}

fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gmr-").suffix(".tmp");
    // As readable as any other new file: what the umask leaves of it.
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666))
    };
    builder.tempfile_in(folder)
}

/// The first text that standard output did not take.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints to standard output; that it could not is told by [`finish`].
pub fn print(text: fmt::Arguments<'_>) {
    note(io::stdout().write_fmt(text));
}

/// Prints figures for scripts, on standard output.
///
/// # Errors
/// A value that JSON does not have.
pub fn print_json(report: &impl serde::Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(report).map_err(|error| Error::failed(error.to_string()))?;
    println!("{text}");
    Ok(())
}

/// Ends standard output.
///
/// # Errors
/// Some text was not printed. [`Error::is_quiet`] where its reader has just left.
pub fn finish() -> Result<()> {
    note(io::stdout().flush());
    match UNPRINTED.lock().ok().and_then(|mut first| first.take()) {
        Some(error) => Err(Error::stdout(&error)),
        None => Ok(()),
    }
}

fn note(printed: io::Result<()>) {
    if let (Err(error), Ok(mut first)) = (printed, UNPRINTED.lock()) {
        first.get_or_insert(error);
    }
}
