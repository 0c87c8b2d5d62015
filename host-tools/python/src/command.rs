//! A command, away from Python's lock, and ended by Ctrl-C.

use std::ffi::OsString;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use host_tools::cli;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use support::context::Context;
use support::error::Result;
use support::job::{self, Job, Kept};

use crate::failure::exception;

/// How often Ctrl-C is looked for: people do not notice, and it costs nothing.
const WATCH: Duration = Duration::from_millis(20);

/// `gmr` with these arguments: what it prints, and what it says on standard error, line by line.
/// `progress` is called with what is being done, how much of it and of how much (0: unknown),
/// whenever that has changed, every 20 ms at most; what it raises ends the work.
#[pyfunction]
#[pyo3(signature = (arguments, progress=None))]
pub(crate) fn run(
    py: Python<'_>,
    arguments: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Vec<String>)> {
    let ((), Kept { printed, said }) =
        watched(py, move |context| cli::answer(context, &arguments), progress.as_ref(), 0)?;
    Ok((printed, said))
}

/// The command `gmr` itself with these arguments: it prints, and gives its exit code.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| cli::run(std::iter::once("gmr".into()).chain(arguments)))
}

/// Does `work` on a thread of its own while Python goes on; Ctrl-C stops it at its next point.
pub(crate) fn stoppable<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Context) -> Result<T> + Send + 'static,
) -> PyResult<(T, Kept)> {
    watched(py, work, None, 0)
}

/// The same on one core: what an engine lends a worker.
pub(crate) fn on_one_core<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Context) -> Result<T> + Send + 'static,
) -> PyResult<(T, Kept)> {
    watched(py, work, None, 1)
}

/// The same on so many threads, 0 for as many as there are cores; `progress` hears how far it is.
fn watched<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Context) -> Result<T> + Send + 'static,
    progress: Option<&Py<PyAny>>,
    threads: usize,
) -> PyResult<(T, Kept)> {
    let mut last = None;
    let mut tell = |job: &Job| -> PyResult<()> {
        let now = job.context.progress();
        if let (Some(callback), Some(progress)) = (progress, &now)
            && now != last
        {
            callback.call1(py, (&progress.what, progress.done, progress.total))?;
            last.clone_from(&now);
        }
        Ok(())
    };
    let job = Arc::new(Job::on(threads));
    let (done, answer) = channel();
    let for_worker = Arc::clone(&job);
    thread::Builder::new().name("gmr".to_owned()).spawn(move || {
        // Whoever asked twice for its end does not listen any more.
        let _ = done.send(job::run(&for_worker, work));
    })?;
    let answer = Mutex::new(answer);
    let mut interrupted = None;
    loop {
        match py.detach(|| wait(&answer)) {
            Ok(result) => {
                return match (result, interrupted) {
                    (_, Some(interrupt)) => Err(interrupt),
                    (Ok(Some(value)), None) => Ok((value, job.take())),
                    (Ok(None), None) => Err(PyRuntimeError::new_err("the work was stopped")),
                    (Err(error), None) => Err(exception(py, &error)),
                };
            }
            Err(RecvTimeoutError::Timeout) => {
                let told = if interrupted.is_none() { tell(&job) } else { Ok(()) };
                if let Err(interrupt) = py.check_signals().and(told) {
                    if interrupted.is_some() {
                        return Err(interrupt);
                    }
                    job.context.stop();
                    interrupted = Some(interrupt);
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("gmr panicked: a fault of its own; see standard error"));
            }
        }
    }
}

fn wait<T>(answer: &Mutex<Receiver<T>>) -> std::result::Result<T, RecvTimeoutError> {
    answer.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(WATCH)
}
