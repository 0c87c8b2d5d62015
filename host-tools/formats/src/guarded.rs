//! Crates that panic on what a file says: neither the panic nor its text gets out.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// How many calls of [`guarded`] this thread is within.
    static WITHIN: Cell<u32> = const { Cell::new(0) };
}

/// What `work` gives; `None` where it panicked. The text of the panic, with the place in somebody
/// else's source, is for nobody who reads a log: it is not printed. Panics elsewhere are, as
/// before.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |panic| {
            if WITHIN.get() == 0 {
                usual(panic);
            }
        }));
    });
    WITHIN.set(WITHIN.get() + 1);
    let done = catch_unwind(AssertUnwindSafe(work));
    WITHIN.set(WITHIN.get() - 1);
    done.ok()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    /// The hook of whoever uses this crate is asked for panics of his alone.
    #[test]
    fn a_panic_within_is_silent() {
        static SEEN: AtomicU32 = AtomicU32::new(0);
        set_hook(Box::new(|panic| {
            SEEN.fetch_add(u32::from(panic.to_string().contains("seen")), Ordering::Relaxed);
        }));
        assert_eq!(guarded(|| 7), Some(7));
        assert_eq!(guarded(|| guarded(|| panic!("hidden")).is_none()), Some(true));
        assert_eq!(SEEN.load(Ordering::Relaxed), 0);
        assert!(catch_unwind(|| panic!("seen")).is_err());
        assert_eq!(SEEN.load(Ordering::Relaxed), 1);
    }
}
