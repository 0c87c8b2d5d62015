//! Ctrl-C, and what else asks a program to end: some commands end in good order, the others at
//! once, without leaving temporary files.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};
use crate::temporary;

/// Whether a command looks at [`STOPPED`].
static CAUGHT: AtomicBool = AtomicBool::new(false);
static STOPPED: AtomicBool = AtomicBool::new(false);

/// Exit code of a program that a signal ended, as shells have it for SIGINT.
const INTERRUPTED: i32 = 130;

/// From now on Ctrl-C ends the process and removes its temporary files. Writing beyond a limit of
/// the size of files is an ordinary error. Once a process.
///
/// # Errors
/// The operating system refuses.
#[cfg(unix)]
pub fn install() -> Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};

    let refused = |error: std::io::Error| Error::failed(format!("signals cannot be caught: {error}"));
    // With a handler, whatever it does, the write that went too far says so itself (setrlimit(2)).
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default()).map_err(refused)?;
    let mut signals = signal_hook::iterator::Signals::new([SIGHUP, SIGINT, SIGTERM]).map_err(refused)?;
    let watch = move || signals.forever().for_each(|_| end());
    std::thread::Builder::new().name("signals".to_owned()).spawn(watch).map_err(refused)?;
    Ok(())
}

/// The same, where there are no signals.
///
/// # Errors
/// The operating system refuses.
#[cfg(not(unix))]
pub fn install() -> Result<()> {
    ctrlc::set_handler(end).map_err(|error| Error::failed(format!("Ctrl-C cannot be caught: {error}")))
}

/// What a signal asks for.
fn end() {
    // Whoever asks twice does not want to wait.
    if CAUGHT.load(Ordering::Relaxed) && !STOPPED.swap(true, Ordering::Relaxed) {
        return;
    }
    let _held = temporary::remove_all();
    std::process::exit(INTERRUPTED);
}

/// Set by Ctrl-C from now on, which no longer ends the process; a second one does.
pub fn catch() -> &'static AtomicBool {
    CAUGHT.store(true, Ordering::Relaxed);
    &STOPPED
}
