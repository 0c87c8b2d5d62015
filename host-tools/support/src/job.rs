//! A command's work inside another program: what it would print is kept for that program, and that program can stop it.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::ThreadPoolBuilder;

use crate::error::{Error, Result};

/// Work of which somebody else decides when it ends, and who reads what it says.
#[derive(Debug, Default)]
pub struct Job {
    is_stopped: AtomicBool,
    kept: Mutex<Kept>,
    progress: Mutex<Option<Progress>>,
}

/// How far a job is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// What it does: a few words.
    pub what: String,
    /// Of `total`, in bytes or pieces.
    pub done: u64,
    /// 0 where nobody knows.
    pub total: u64,
}

/// What a job would have printed.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Kept {
    /// On standard output.
    pub printed: String,
    /// On standard error, line by line.
    pub said: Vec<String>,
}

/// Unwinds out of the work of a stopped job. No panic: nothing is printed, and [`run`] catches it.
struct Stopped;

thread_local! {
    /// The job that this thread works for.
    static CURRENT: RefCell<Option<Arc<Job>>> = const { RefCell::new(None) };
}

impl Job {
    /// Ends the work at its next [`point`].
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// What it has said so far, which is then forgotten.
    pub fn take(&self) -> Kept {
        std::mem::take(&mut *self.kept())
    }

    /// How far it is, where it has said so.
    pub fn progress(&self) -> Option<Progress> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Works for `job` on threads of its own, as many as there are cores, so that two jobs do not mix. `None` if it was stopped.
///
/// # Errors
/// What `work` reports; the operating system gives no threads.
///
/// # Panics
/// As `work`.
pub fn run<T: Send>(job: &Arc<Job>, work: impl FnOnce() -> Result<T> + Send) -> Result<Option<T>> {
    let for_threads = Arc::clone(job);
    let threads = ThreadPoolBuilder::new()
        .start_handler(move |_| CURRENT.set(Some(Arc::clone(&for_threads))))
        .build()
        .map_err(|error| Error::failed(format!("no threads to work on: {error}")))?;
    match catch_unwind(AssertUnwindSafe(|| threads.install(work))) {
        Ok(result) => result.map(Some),
        Err(payload) if is_stop(&*payload) => Ok(None),
        Err(panic) => resume_unwind(panic),
    }
}

fn is_stop(payload: &(dyn Any + Send)) -> bool {
    payload.is::<Stopped>()
}

/// Where a stopped job ends: long work comes by several times a second. It unwinds, as whoever computes cannot fail otherwise. Outside
/// of jobs it does nothing.
#[inline]
pub fn point() {
    let is_stopped =
        CURRENT.with_borrow(|job| job.as_ref().is_some_and(|job| job.is_stopped.load(Ordering::Relaxed)));
    if is_stopped {
        resume_unwind(Box::new(Stopped));
    }
}

/// Says how far this thread's job is; outside of jobs nothing.
pub(crate) fn at(what: &str, done: u64, total: u64) {
    CURRENT.with_borrow(|job| {
        if let Some(job) = job {
            let now = Progress { what: what.to_owned(), done, total };
            *job.progress.lock().unwrap_or_else(PoisonError::into_inner) = Some(now);
        }
    });
}

/// Keeps what would go to standard output; false outside of jobs.
pub(crate) fn keep_printed(text: &str) -> bool {
    keep(|kept| kept.printed.push_str(text))
}

/// Keeps what would go to standard error, a line; false outside of jobs.
pub(crate) fn keep_said(line: &str) -> bool {
    keep(|kept| kept.said.push(line.to_owned()))
}

fn keep(add: impl FnOnce(&mut Kept)) -> bool {
    CURRENT.with_borrow(|job| job.as_ref().map(|job| add(&mut job.kept())).is_some())
}

#[cfg(test)]
mod tests {
    use rayon::prelude::*;

    use super::*;

    /// Whatever thread it is printed on.
    #[test]
    fn what_a_job_says_is_its_own() {
        let jobs = [Arc::new(Job::default()), Arc::new(Job::default())];
        let work = |job: &Arc<Job>, what: &str| {
            let all = || {
                (0..100).into_par_iter().for_each(|_| println!("{what}"));
                eprintln!("{what} is done");
                Ok(what.len())
            };
            run(job, all).unwrap()
        };
        std::thread::scope(|scope| {
            let first = scope.spawn(|| work(&jobs[0], "one"));
            assert_eq!((work(&jobs[1], "three"), first.join().unwrap()), (Some(5), Some(3)));
        });
        let kept = jobs.map(|job| job.take());
        assert_eq!(kept[0], Kept { printed: "one\n".repeat(100), said: vec!["one is done".to_owned()] });
        assert_eq!(kept[1], Kept { printed: "three\n".repeat(100), said: vec!["three is done".to_owned()] });
    }

    #[test]
    fn a_stopped_job_ends_on_all_its_threads() {
        let job = Arc::new(Job::default());
        job.stop();
        let endless = || {
            (0..4).into_par_iter().for_each(|_| {
                loop {
                    point();
                }
            });
            Ok(())
        };
        assert_eq!(run(&job, endless).unwrap(), None);
        // Outside of it, nothing ends.
        point();
    }
}
