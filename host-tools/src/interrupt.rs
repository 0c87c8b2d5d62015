//! Ctrl-C, for commands that run until somebody ends them.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// Set by Ctrl-C, and by what else asks a program to end. Once a process.
///
/// # Errors
/// The operating system refuses, or somebody else catches them already.
pub fn catch() -> Result<&'static AtomicBool> {
    static STOPPED: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| STOPPED.store(true, Ordering::Relaxed))
        .map_err(|error| Error::failed(format!("Ctrl-C cannot be caught: {error}")))?;
    Ok(&STOPPED)
}
