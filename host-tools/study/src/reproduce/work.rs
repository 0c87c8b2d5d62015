//! The work on seeds: its folder and its cores.

use std::path::Path;

use rayon::prelude::*;
use support::error::{Error, Result};
use support::temporary::{self, Known};
use tempfile::TempDir;

/// For the logs of the work; deleted with it, whatever its end.
pub(super) struct Folder(TempDir, #[expect(dead_code, reason = "it is known as long as it is there")] Known);

impl Folder {
    pub(super) fn new() -> Result<Self> {
        let place = std::env::temp_dir();
        let (folder, known) = temporary::folder_in(&place).map_err(|error| Error::io(&place, &error))?;
        Ok(Self(folder, known))
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }
}

/// `work` for 0 … `count` on all cores; the results in order, or a failure.
pub(super) fn on_all_cores<T: Send>(
    count: u64,
    work: impl Fn(u64) -> Result<T> + Send + Sync,
) -> Result<Vec<T>> {
    // One at a time: seeds take long, and a thread with several would leave others idle.
    let seeds: Vec<u64> = (0..count).collect();
    seeds.into_par_iter().with_max_len(1).map(work).collect()
}
