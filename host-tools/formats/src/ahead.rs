//! Results that are made ahead of whoever takes them, in order, by threads that have nothing else
//! to do.
//!
//! The threads are those of rayon's pool. One that is busy does not help, so that of many logs each
//! is read by the core that it is on, and of one log by all of them. Whoever takes results makes
//! what nobody has begun, and waits only for what another thread is working on: no pool is too
//! small, or too full.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Results in order, made in pieces.
pub trait Work: Send + 'static {
    /// A piece to be made.
    type Job: Send;
    /// A piece that was made.
    type Done: Send;
    /// What is taken.
    type Next;

    /// What is to be made next, of what nobody has begun; none where nothing can be begun, or
    /// enough waits to be taken.
    fn claim(&mut self) -> Option<Self::Job>;
    /// Makes it, on any thread.
    fn make(job: Self::Job) -> Self::Done;
    /// Keeps what was made.
    fn keep(&mut self, done: Self::Done);
    /// What comes next, if all that it takes was made. Where no job is claimed or can be, there is
    /// something: the end, at least.
    fn take(&mut self) -> Option<Self::Next>;
    /// Whether so much could be begun that another thread is worth its while.
    fn is_behind(&self) -> bool;
}

/// Work and whoever takes its results.
pub struct Ahead<W: Work> {
    shared: Arc<Shared<W>>,
    /// Results that are taken before others are asked to help.
    alone: u32,
}

struct Shared<W> {
    state: Mutex<State<W>>,
    changed: Condvar,
}

struct State<W> {
    /// None when nobody takes results any more.
    work: Option<W>,
    /// Nothing more is to be begun.
    is_over: bool,
    /// Threads that were asked to help, and have not gone.
    helpers: usize,
    /// Pieces that they are making.
    running: usize,
    /// Of a helper.
    panic: Option<Box<dyn Any + Send>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<W: Work> Ahead<W> {
    /// Of work that nobody has begun. Others are asked to help when so many results were taken:
    /// whoever looks at a log's first rows only needs no more of it.
    pub fn new(work: W, alone: u32) -> Self {
        let state = State { work: Some(work), is_over: false, helpers: 0, running: 0, panic: None };
        Self { shared: Arc::new(Shared { state: Mutex::new(state), changed: Condvar::new() }), alone }
    }

    /// What comes next.
    ///
    /// # Panics
    /// As the work did, on whichever thread.
    pub fn take_next(&mut self) -> Option<W::Next> {
        let mut state = lock(&self.shared.state);
        loop {
            if let Some(panic) = state.panic.take() {
                drop(state);
                resume_unwind(panic);
            }
            let work = state.work.as_mut()?;
            if let Some(next) = work.take() {
                let is_behind = self.alone == 0 && work.is_behind();
                self.alone = self.alone.saturating_sub(1);
                if is_behind && state.helpers + 1 < rayon::current_num_threads() {
                    state.helpers += 1;
                    let shared = Arc::clone(&self.shared);
                    rayon::spawn(move || help(&shared));
                }
                return Some(next);
            }
            state = match work.claim() {
                Some(job) => {
                    drop(state);
                    let done = W::make(job);
                    let mut state = lock(&self.shared.state);
                    if let Some(work) = &mut state.work {
                        work.keep(done);
                    }
                    state
                }
                None => self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner),
            };
        }
    }

    /// Does something to the work itself, between two pieces.
    pub fn with<T>(&self, change: impl FnOnce(&mut W) -> T) -> Option<T> {
        lock(&self.shared.state).work.as_mut().map(change)
    }

    /// The work, with nobody at it any more.
    ///
    /// # Panics
    /// As a helper did.
    pub fn into_work(self) -> Option<W> {
        let mut state = lock(&self.shared.state);
        state.is_over = true;
        while state.running > 0 {
            state = self.shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let (work, panic) = (state.work.take(), state.panic.take());
        drop(state);
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
        work
    }
}

impl<W: Work> Drop for Ahead<W> {
    fn drop(&mut self) {
        let mut state = lock(&self.shared.state);
        state.is_over = true;
        let work = state.work.take();
        drop(state);
        drop(work);
    }
}

/// Makes pieces as long as there are some to begin.
fn help<W: Work>(shared: &Shared<W>) {
    let mut state = lock(&shared.state);
    while !state.is_over
        && state.panic.is_none()
        && let Some(job) = state.work.as_mut().and_then(W::claim)
    {
        state.running += 1;
        drop(state);
        let done = catch_unwind(AssertUnwindSafe(|| W::make(job)));
        state = lock(&shared.state);
        state.running -= 1;
        match done {
            Ok(done) => {
                if let Some(work) = &mut state.work {
                    work.keep(done);
                }
            }
            Err(panic) => state.panic = Some(panic),
        }
        shared.changed.notify_all();
    }
    state.helpers -= 1;
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    use rayon::ThreadPoolBuilder;

    use super::*;

    const LAST: usize = 500;
    const WAITING: usize = 8;

    /// Squares, which take the longer the less there are left of them.
    #[derive(Default)]
    struct Squares {
        begun: usize,
        taken: usize,
        made: VecDeque<Option<usize>>,
        threads: Arc<AtomicUsize>,
        fails_at: Option<usize>,
    }

    impl Work for Squares {
        type Job = (usize, Option<usize>, Arc<AtomicUsize>);
        type Done = (usize, usize);
        type Next = usize;

        fn claim(&mut self) -> Option<Self::Job> {
            assert!(self.made.len() <= WAITING, "no more than asked for");
            if self.made.len() == WAITING || self.begun == LAST {
                return None;
            }
            self.made.push_back(None);
            self.begun += 1;
            Some((self.begun - 1, self.fails_at, Arc::clone(&self.threads)))
        }

        fn make((place, fails_at, threads): Self::Job) -> (usize, usize) {
            if fails_at == Some(place) {
                resume_unwind(Box::new("out of squares"));
            }
            if rayon::current_thread_index() != Some(0) {
                threads.fetch_add(1, Ordering::Relaxed);
            }
            std::thread::sleep(Duration::from_micros(((7 * place) % 11 * 10) as u64));
            (place, place * place)
        }

        fn keep(&mut self, (place, square): (usize, usize)) {
            self.made[place - self.taken] = Some(square);
        }

        fn take(&mut self) -> Option<usize> {
            if self.taken == LAST {
                return Some(usize::MAX);
            }
            let next = self.made.front_mut()?.take()?;
            self.made.pop_front();
            self.taken += 1;
            Some(next)
        }

        fn is_behind(&self) -> bool {
            self.made.len() < WAITING / 2
        }
    }

    fn within<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
    }

    /// All in order, whoever made them; with one thread, that one, and with several not it alone.
    #[test]
    fn results_come_in_order() {
        for threads in [1, 2, 5] {
            let squares = Squares::default();
            let by_others = Arc::clone(&squares.threads);
            let mut ahead = Ahead::new(squares, 3);
            let (taken, work) = within(threads, || {
                let taken: Vec<usize> = (0..LAST).filter_map(|_| ahead.take_next()).collect();
                assert_eq!(ahead.take_next(), Some(usize::MAX));
                (taken, ahead.into_work().unwrap())
            });
            assert!(taken.iter().copied().eq((0..LAST).map(|place| place * place)), "{threads}");
            assert_eq!((work.begun, work.made.len()), (LAST, 0));
            assert_eq!(by_others.load(Ordering::Relaxed) > 0, threads > 1, "{threads}");
        }
    }

    /// The pool's threads are all busy until this one is done.
    #[test]
    fn a_pool_that_is_full_is_no_reason_to_wait() {
        let sums = within(2, || {
            let all = |_| {
                let mut ahead = Ahead::new(Squares::default(), 3);
                (0..LAST).filter_map(|_| ahead.take_next()).sum::<usize>()
            };
            rayon::join(|| all(()), || all(()))
        });
        assert_eq!(sums.0, sums.1);
    }

    /// A panic is the taker's, on whichever thread it was, and ends neither the pool nor the
    /// process.
    #[test]
    fn a_panic_reaches_whoever_takes() {
        for threads in [1, 3] {
            let told = within(threads, || {
                let mut ahead = Ahead::new(Squares { fails_at: Some(300), ..Squares::default() }, 3);
                let all =
                    catch_unwind(AssertUnwindSafe(|| (0..LAST).filter_map(|_| ahead.take_next()).count()));
                all.unwrap_err().downcast_ref::<&str>().copied()
            });
            assert_eq!(told, Some("out of squares"), "{threads}");
        }
    }
}
