//! Ctrl-C, and what else asks a program to end: some commands end in good order, the others at once, without leaving temporary files.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};
use crate::temporary;

/// Whether a command looks at [`STOPPED`].
static CAUGHT: AtomicBool = AtomicBool::new(false);
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Exit code of a program that a signal ended, as shells have it for SIGINT.
const INTERRUPTED: i32 = 130;

/// From now on Ctrl-C ends the process and takes its temporary files away; behind a limit of the size of files writing is an error as any
/// other. Once a process.
///
/// # Errors
/// The operating system refuses, or somebody else catches them already.
pub fn install() -> Result<()> {
    #[cfg(unix)]
    {
        // With a handler, whatever it does, the write that went too far says so itself (setrlimit(2)).
        let seen = std::sync::Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen)
            .map_err(|error| Error::failed(format!("SIGXFSZ cannot be caught: {error}")))?;
    }
    ctrlc::set_handler(|| {
        // Whoever asks twice does not want to wait.
        if CAUGHT.load(Ordering::Relaxed) && !STOPPED.swap(true, Ordering::Relaxed) {
            return;
        }
        let _held = temporary::remove_all();
        std::process::exit(INTERRUPTED);
    })
    .map_err(|error| Error::failed(format!("Ctrl-C cannot be caught: {error}")))
}

/// Set by Ctrl-C from now on, which no longer ends the process; a second one does.
pub fn catch() -> &'static AtomicBool {
    CAUGHT.store(true, Ordering::Relaxed);
    &STOPPED
}
