//! Temporary files and folders of this process: known by name, so that whoever ends it from outside
//! leaves none behind.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// How often the removal of one is tried. Chosen: a thread that still writes makes few files meanwhile.
const ATTEMPTS: usize = 10;

/// Those that there are now.
static THERE: LazyLock<Mutex<BTreeSet<PathBuf>>> = LazyLock::new(Mutex::default);

fn there() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    THERE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A name that is forgotten when the file or folder is gone, or has taken its own name.
#[derive(Debug)]
pub struct Known(PathBuf);

impl Drop for Known {
    fn drop(&mut self) {
        there().remove(&self.0);
    }
}

/// A file beside the one that it is to become.
pub fn file_in(folder: &Path) -> io::Result<(tempfile::NamedTempFile, Known)> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gmr-").suffix(".tmp");
    // As readable as any other new file: what the umask leaves of it.
    #[cfg(unix)]
    let builder = {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666))
    };
    // Under the lock: between the two nobody may end this process.
    let mut there = there();
    let file = builder.tempfile_in(folder)?;
    there.insert(file.path().to_owned());
    let known = Known(file.path().to_owned());
    Ok((file, known))
}

/// A folder beside the one that it is to become.
pub fn folder_in(folder: &Path) -> io::Result<(tempfile::TempDir, Known)> {
    let mut there = there();
    let folder = tempfile::Builder::new().prefix(".gmr-").tempdir_in(folder)?;
    there.insert(folder.path().to_owned());
    let known = Known(folder.path().to_owned());
    Ok((folder, known))
}

/// Removes them all, and lets nobody make others: for a process that is about to end.
pub fn remove_all() -> impl Sized {
    let there = there();
    for path in there.iter() {
        let remove =
            || if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
        // Others may still write into a folder. Whatever cannot be removed stays: there is nobody
        // left to tell.
        let _ = (0..ATTEMPTS).any(|_| remove().is_ok());
    }
    there
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What took its own name is no temporary file any more.
    #[test]
    fn names_are_known_as_long_as_they_are_temporary() {
        let folder = tempfile::tempdir().unwrap();
        let (file, known) = file_in(folder.path()).unwrap();
        let (path, place) = (file.path().to_owned(), folder.path().join("done"));
        assert!(there().contains(&path));
        file.persist(&place).unwrap();
        drop(known);
        assert!(!there().contains(&path) && place.exists());
    }
}
