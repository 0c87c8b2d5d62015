//! The logs that coefficients were fitted to: where they are, and whether they are still what was
//! fitted.

use std::path::{Path, PathBuf};

use support::error::{Error, Result};

use super::fingerprint;

/// A log that coefficients were fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedLog {
    /// Its path, as seen from here.
    pub path: PathBuf,
    /// Its size and a checksum; none for what was no file.
    pub fingerprint: Option<String>,
    /// Total mass that somebody weighed with it, kg, where the log itself does not say it.
    pub weighed_kg: Option<f64>,
}

impl FittedLog {
    /// A log as it is now.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn now(path: &Path) -> Result<Self> {
        let fingerprint = fingerprint::of(path).map_err(|error| Error::io(path, &error))?;
        Ok(Self { path: path.to_owned(), fingerprint, weighed_kg: None })
    }

    /// Whether it is there, and still what was fitted; `coefficients` is the file that says so.
    ///
    /// # Errors
    /// It has changed, or cannot be read.
    pub(super) fn is_there(&self, coefficients: &Path) -> Result<bool> {
        if !self.path.exists() {
            return Ok(false);
        }
        let now = Self::now(&self.path)?.fingerprint;
        if let (Some(then), Some(now)) = (&self.fingerprint, now)
            && *then != now
        {
            let message = format!(
                "has changed since the coefficients of {} were fitted to it; expected the log as it was, or the clean runs \
                 with --base",
                coefficients.display()
            );
            return Err(Error::failed(message).in_file(&self.path));
        }
        Ok(true)
    }
}

/// The path of a log as seen from the folder of the coefficients, so that both can move together;
/// absolute where they share none.
pub(super) fn seen_from(coefficients: &Path, log: &Path) -> PathBuf {
    let folder = folder_of(coefficients);
    match (std::fs::canonicalize(log), std::fs::canonicalize(folder)) {
        (Ok(log), Ok(folder)) => log.strip_prefix(&folder).map(Path::to_owned).unwrap_or(log),
        _ => log.to_owned(),
    }
}

/// The folder of a file.
pub(super) fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
