//! The work on seeds: its folder, its cores, and its end.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use support::error::{Error, Result};
use tempfile::TempDir;

/// For the logs of the work; deleted with it, whatever its end.
pub(super) fn temporary_folder() -> Result<TempDir> {
    let folder = tempfile::Builder::new().prefix("gmr-").tempdir();
    folder.map_err(|error| Error::io(std::env::temp_dir(), &error))
}

/// Ends the work between two of its parts.
pub(super) fn go_on(stopped: &AtomicBool) -> Result<()> {
    if stopped.load(Ordering::Relaxed) {
        return Err(Error::failed("stopped before the last seed was done; nothing was written"));
    }
    Ok(())
}

/// `work` for 0 … `count` on all cores; the results in order, or a failure. Once `stopped` is set
/// no more is begun.
pub(super) fn on_all_cores<T: Send>(
    count: u64,
    stopped: &AtomicBool,
    work: impl Fn(u64) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    // One at a time: seeds take long, and a thread with several would leave others idle.
    let seeds: Vec<u64> = (0..count).collect();
    seeds.into_par_iter().with_max_len(1).map(|index| go_on(stopped).and_then(|()| work(index))).collect()
}
