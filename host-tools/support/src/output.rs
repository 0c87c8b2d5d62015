//! Files are written whole or not at all; whoever reads standard output may leave at any time.

use std::fmt;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::error::{Error, Result};
use crate::{job, printable, temporary};

/// Writes `file` through a temporary file in the same folder that takes its name only when
/// complete. Gives what `write` gives.
///
/// # Errors
/// What `write` or the operating system reports; the old file, if any, is then still there.
pub fn write_whole<T>(file: &Path, write: impl FnOnce(&mut dyn Write) -> Result<T>) -> Result<T> {
    let (mut write, mut written) = (Some(write), None);
    write_once(file, &mut |to| {
        written = write.take().map(|write| write(to)).transpose()?;
        Ok(())
    })?;
    Ok(written.expect("written, or refused"))
}

fn write_once(file: &Path, write: &mut dyn FnMut(&mut dyn Write) -> Result<()>) -> Result<()> {
    let refused = |error: io::Error| Error::io(file, &error);
    // A link keeps pointing at its file. A device or a pipe has no content to keep, and no file may
    // take its place.
    let target = target_of(file).map_err(refused)?;
    if std::fs::metadata(&target).is_ok_and(|file| !file.is_file() && !file.is_dir()) {
        let mut device = std::fs::File::options().write(true).open(&target).map_err(refused)?;
        return write(&mut device);
    }
    let folder = folder_of(&target).map_err(|error| error.in_file(file))?;
    let (mut temporary, _known) = temporary::file_in(folder).map_err(refused)?;
    let mut buffered = io::BufWriter::new(temporary.as_file_mut());
    write(&mut buffered)?;
    buffered.into_inner().map_err(|error| refused(error.into_error()))?;
    temporary.persist(&target).map(drop).map_err(|error| refused(error.error))
}

/// [`write_whole`] of content that is there already.
///
/// # Errors
/// What the operating system reports.
pub fn write_content(file: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write_bytes(file, content.as_ref())
}

fn write_bytes(file: &Path, content: &[u8]) -> Result<()> {
    write_whole(file, |to| to.write_all(content).map_err(|error| Error::io(file, &error)))
}

/// What a file's name leads to, whether it is there yet or not: links are followed.
///
/// # Errors
/// Links that lead in a circle.
fn target_of(file: &Path) -> io::Result<PathBuf> {
    let mut target = file.to_owned();
    // As many as the kernel follows.
    for _ in 0..40 {
        let Ok(next) = std::fs::read_link(&target) else { return Ok(target) };
        target = target.parent().map_or_else(|| next.clone(), |folder| folder.join(&next));
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// Refuses outputs that are inputs as well, or one another, before any work: writing them would
/// lose what was read.
///
/// # Errors
/// Names the first (wrong usage).
pub fn check_apart<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    let identified = |path: &'a Path| (path, Identity::of(path));
    are_apart(outputs.into_iter().map(identified).collect(), inputs.into_iter().map(identified).collect())
}

type Identified<'a> = (&'a Path, Option<Identity>);

fn are_apart(outputs: Vec<Identified<'_>>, inputs: Vec<Identified<'_>>) -> Result<()> {
    let mut written: Vec<Identified<'_>> = Vec::new();
    for (output, identity) in outputs {
        let same = |other: &&Identified<'_>| identity.is_some() && identity == other.1;
        if let Some((input, _)) = inputs.iter().find(same) {
            let message =
                format!("is to be written, but read as well, as {}; expected another file", input.display());
            return Err(Error::usage(message).in_file(output));
        }
        let twice = |other: &&Identified<'_>| same(other) || other.0 == output;
        if let Some((other, _)) = written.iter().find(twice) {
            let message =
                format!("is to be written twice, as {} as well; expected another file", other.display());
            return Err(Error::usage(message).in_file(output));
        }
        written.push((output, identity));
    }
    Ok(())
}

/// Which file it is, by whatever name.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Identity {
    /// By device and inode, which two names of one file share.
    #[cfg(unix)]
    Node(u64, u64),
    /// By its canonical path.
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    /// Of a file that is there; devices and pipes have nothing to lose.
    fn of(file: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(file).ok().filter(std::fs::Metadata::is_file)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            Some(Self::Node(metadata.dev(), metadata.ino()))
        }
        #[cfg(not(unix))]
        {
            let _ = metadata;
            std::fs::canonicalize(file).ok().map(Self::Path)
        }
    }
}

/// The folder that a file is written into: commands ask before they start long work.
///
/// # Errors
/// There is no such folder.
pub fn folder_of(file: &Path) -> Result<&Path> {
    let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if folder.is_dir() {
        return Ok(folder);
    }
    let message = format!("the folder {} does not exist; expected one to write into", folder.display());
    Err(Error::failed(message).in_file(file))
}

/// Refuses a folder with less room than a command is going to need, before its long work.
///
/// # Errors
/// Says how much there is.
#[cfg(unix)]
pub fn check_room(file: &Path, bytes: u64) -> Result<()> {
    let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A file system that does not tell has to be tried.
    let Ok(space) = rustix::fs::statvfs(folder) else { return Ok(()) };
    let room = space.f_bavail.saturating_mul(space.f_frsize);
    if room >= bytes {
        return Ok(());
    }
    let message = format!("{} MB are left there; expected {} MB", room >> 20, bytes >> 20);
    Err(Error::failed(message).in_file(folder))
}

/// Other systems have to be tried.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn check_room(_: &Path, _: u64) -> Result<()> {
    Ok(())
}

/// The first text that standard output did not take.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints to standard output, printable ([`crate::printable`]); [`finish`] reports failures.
pub fn print(text: fmt::Arguments<'_>) {
    let text = text.to_string();
    let text = printable::text(&text);
    if !job::keep_printed(&text) {
        note(io::stdout().write_all(text.as_bytes()));
    }
}

/// Says a line on standard error, printable and of bounded length. Where nobody reads it, there is
/// nobody left to tell.
pub fn say(line: fmt::Arguments<'_>) {
    let line = printable::line(&line.to_string());
    if !job::keep_said(&line) {
        let _ = io::stderr().write_all((line + "\n").as_bytes());
    }
}

/// Moves the cursor of a terminal on standard output: the one escape sequence that this program
/// writes.
///
/// So many lines up, and clear from there (ECMA-48 CPL and ED).
pub fn redraw(lines: usize) {
    note(write!(io::stdout(), "\x1b[{lines}F\x1b[J"));
}

/// The version of all JSON that `gmr` prints (docs/json.md): it changes where a key goes or changes
/// its meaning, not where one is added.
pub const JSON_VERSION: u32 = 1;

/// A report with the version before its keys.
#[derive(serde::Serialize)]
struct Versioned<'a, R: serde::Serialize> {
    version: u32,
    #[serde(flatten)]
    report: &'a R,
}

/// A report, which has keys, as JSON with its version, several lines of it.
///
/// # Errors
/// A value that JSON does not have; a report without keys.
pub fn json(report: &impl serde::Serialize) -> Result<String> {
    let versioned = Versioned { version: JSON_VERSION, report };
    serde_json::to_string_pretty(&versioned).map_err(|error| Error::failed(error.to_string()))
}

/// The same on one line.
///
/// # Errors
/// As [`json`].
pub fn json_line(report: &impl serde::Serialize) -> Result<String> {
    let versioned = Versioned { version: JSON_VERSION, report };
    serde_json::to_string(&versioned).map_err(|error| Error::failed(error.to_string()))
}

/// Prints figures for scripts, on standard output.
///
/// # Errors
/// As [`json`].
pub fn print_json(report: &impl serde::Serialize) -> Result<()> {
    print(format_args!("{}\n", json(report)?));
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
