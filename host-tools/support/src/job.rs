//! A command's work inside another program: what it would print is kept for that program, and that
//! program can stop it.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::ThreadPoolBuilder;

use crate::context::{Context, Stopped};
use crate::error::{Error, Result};
use crate::printable;

/// Work of which somebody else decides when it ends, and who reads what it says.
#[derive(Default)]
pub struct Job {
    /// Of the work.
    pub context: Context,
    /// Threads that it works on; 0 for as many as there are cores.
    threads: usize,
    kept: Mutex<Kept>,
}

/// What a job would have printed.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Kept {
    /// On standard output.
    pub printed: String,
    /// On standard error, line by line.
    pub said: Vec<String>,
}

thread_local! {
    /// The job that this thread works for.
    static CURRENT: RefCell<Option<Arc<Job>>> = const { RefCell::new(None) };
}

impl Job {
    /// On so many threads; 0 for as many as there are cores.
    pub fn on(threads: usize) -> Self {
        Self { threads, ..Self::default() }
    }

    /// What it has said so far, which is then forgotten: notices first.
    pub fn take(&self) -> Kept {
        let Kept { printed, said } = std::mem::take(&mut *self.kept());
        let notices = self.context.take_notices().lines;
        let notices = notices.iter().map(|line| printable::line(&format!("gmr: {line}")));
        Kept { printed, said: notices.chain(said).collect() }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Works for `job` on threads of its own, so that two jobs do not mix.
/// `None` if it was stopped.
///
/// # Errors
/// What `work` reports; the operating system gives no threads.
///
/// # Panics
/// As `work`.
pub fn run<T: Send>(job: &Arc<Job>, work: impl FnOnce(&Context) -> Result<T> + Send) -> Result<Option<T>> {
    let for_threads = Arc::clone(job);
    let threads = ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .start_handler(move |_| CURRENT.set(Some(Arc::clone(&for_threads))))
        .build()
        .map_err(|error| Error::failed(format!("no threads to work on: {error}")))?;
    match catch_unwind(AssertUnwindSafe(|| threads.install(|| work(&job.context)))) {
        Ok(result) => result.map(Some),
        Err(payload) if is_stop(&*payload) => Ok(None),
        Err(panic) => resume_unwind(panic),
    }
}

fn is_stop(payload: &(dyn Any + Send)) -> bool {
    payload.is::<Stopped>()
}

/// [`Context::point`] of the job that this thread works for; outside of jobs it does nothing.
#[inline]
pub fn point() {
    let context = CURRENT.with_borrow(|job| job.as_ref().map(|job| job.context.clone()));
    if let Some(context) = context {
        context.point();
    }
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
    use crate::output;

    /// Whatever thread it is printed on.
    #[test]
    fn what_a_job_says_is_its_own() {
        let jobs = [Arc::new(Job::default()), Arc::new(Job::default())];
        let work = |job: &Arc<Job>, what: &str| {
            let all = |context: &Context| {
                (0..100).into_par_iter().for_each(|_| output::print(format_args!("{what}\n")));
                output::say(format_args!("{what} is done"));
                context.notice(format_args!("{what} was there"));
                Ok(what.len())
            };
            run(job, all).unwrap()
        };
        std::thread::scope(|scope| {
            let first = scope.spawn(|| work(&jobs[0], "one"));
            assert_eq!((work(&jobs[1], "three"), first.join().unwrap()), (Some(5), Some(3)));
        });
        for (kept, what) in jobs.map(|job| job.take()).iter().zip(["one", "three"]) {
            assert_eq!(kept.printed, format!("{what}\n").repeat(100));
            assert_eq!(kept.said, [format!("gmr: {what} was there"), format!("{what} is done")]);
        }
    }

    #[test]
    fn a_stopped_job_ends_on_all_its_threads() {
        let job = Arc::new(Job::default());
        job.context.stop();
        let endless = |_: &Context| {
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
