//! What one call has of its own: how its logs are read, what it keeps of them, what it has to say
//! beside its answer, how far it is, and whether it is to end. It travels with the call, so that
//! two calls in one process do not mix.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt::Display;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// More notices are counted only.
const MOST_NOTICES: usize = 1_000;

/// Of one call; clones are the same call's. What it keeps (rows of bags, content of pipes) goes
/// with the last clone.
#[derive(Clone, Default)]
pub struct Context {
    call: Arc<Call>,
    /// How logs are read: a type of the readers.
    reading: Option<Arc<dyn Any + Send + Sync>>,
}

#[derive(Default)]
struct Call {
    is_stopped: AtomicBool,
    notices: Mutex<Notices>,
    progress: Mutex<Option<Progress>>,
    kept: Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>,
}

/// How far a call is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// What it does: a few words.
    pub what: String,
    /// Of `total`, in bytes or pieces.
    pub done: u64,
    /// 0 where nobody knows.
    pub total: u64,
}

/// What a call has to say of its inputs besides its answer: rows left out, keys that it does not
/// know, masses taken for granted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notices {
    /// In the order in which they came.
    pub lines: Vec<String>,
    /// How many more there were.
    pub dropped: usize,
}

/// Unwinds out of the work of a stopped call. Nothing is printed, and whoever began the work
/// catches it.
pub(crate) struct Stopped;

impl Context {
    /// The same call, with its logs read in this way.
    #[must_use]
    pub fn with_reading(&self, reading: impl Any + Send + Sync) -> Self {
        Self { call: Arc::clone(&self.call), reading: Some(Arc::new(reading)) }
    }

    /// How logs are read, where that has been said.
    pub fn reading<T: Any>(&self) -> Option<&T> {
        self.reading.as_ref()?.downcast_ref()
    }

    /// What the call keeps of this kind; empty at first.
    pub fn kept<T: Any + Default + Send + Sync>(&self) -> Arc<T> {
        let mut kept = lock(&self.call.kept);
        let value = kept.entry(TypeId::of::<T>()).or_insert_with(|| Arc::new(T::default()));
        // What stands under a type's key is of that type.
        Arc::clone(value).downcast().unwrap_or_default()
    }

    /// Adds a line. It is printed when the call has done its work. A refusal is one line and holds
    /// what led to it.
    pub fn notice(&self, line: impl Display) {
        let mut notices = lock(&self.call.notices);
        if notices.lines.len() < MOST_NOTICES {
            notices.lines.push(line.to_string());
        } else {
            notices.dropped += 1;
        }
    }

    /// The lines so far, which are then forgotten.
    pub fn take_notices(&self) -> Notices {
        std::mem::take(&mut *lock(&self.call.notices))
    }

    /// Says how far the call is.
    pub fn at(&self, what: &str, done: u64, total: u64) {
        *lock(&self.call.progress) = Some(Progress { what: what.to_owned(), done, total });
    }

    /// How far it is, where it has said so.
    pub fn progress(&self) -> Option<Progress> {
        lock(&self.call.progress).clone()
    }

    /// Ends the call at its next [`point`](Self::point).
    pub fn stop(&self) {
        self.call.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Where a stopped call ends. Long work calls it several times a second. It unwinds, since
    /// computations cannot fail otherwise.
    #[inline]
    pub fn point(&self) {
        if self.call.is_stopped.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A context with another way of reading is the same call; another context is another call.
    #[test]
    fn what_a_call_says_and_keeps_is_its_own() {
        let (one, other) = (Context::default(), Context::default());
        let reading = one.with_reading("as it is".to_owned());
        reading.notice("one");
        other.notice("other");
        lock(&reading.kept::<Mutex<Vec<u32>>>()).push(1);
        assert_eq!(one.take_notices().lines, ["one"]);
        assert_eq!(other.take_notices(), Notices { lines: vec!["other".to_owned()], dropped: 0 });
        assert_eq!(*lock(&one.kept::<Mutex<Vec<u32>>>()), [1]);
        assert!(lock(&other.kept::<Mutex<Vec<u32>>>()).is_empty());
        assert_eq!(reading.reading::<String>().map(String::as_str), Some("as it is"));
        assert!(one.reading::<String>().is_none());
    }

    #[test]
    fn more_notices_than_anybody_reads_are_counted() {
        let context = Context::default();
        (0..MOST_NOTICES + 3).for_each(|line| context.notice(line));
        let notices = context.take_notices();
        assert_eq!((notices.lines.len(), notices.dropped), (MOST_NOTICES, 3));
    }
}
