//! Files are written whole or not at all.

use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};

/// Writes `file` through a temporary file in the same folder that takes its name only when complete.
///
/// # Errors
/// What `write` or the operating system reports; the old file, if any, is then still there.
pub fn write_whole(file: &Path, write: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gmr-").suffix(".tmp");
    // A temporary file is private unless told otherwise; an output is as readable as the user's umask says.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder).map_err(|error| Error::io(file, &error))?;
    {
        let mut buffered = std::io::BufWriter::new(temporary.as_file_mut());
        write(&mut buffered)?;
        buffered.flush().map_err(|error| Error::io(file, &error))?;
    }
    temporary.persist(file).map_err(|error| Error::io(file, &error.error))?;
    Ok(())
}
