//! Keeps the virtual board and its robot on one processor core.
//!
//! They take turns: while one works the other waits, some thousand times a second. On one core such
//! a turn is a switch between two processes; across two it wakes a core that has gone to sleep,
//! which on a virtual machine takes several times as long (measured on two cores of one: 9 µs an
//! exchange instead of 35 to 57).

use std::sync::atomic::{AtomicUsize, Ordering};

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Boards of this process so far: each takes the next core.
static STARTED: AtomicUsize = AtomicUsize::new(0);

/// While it lives, this thread and the processes that it starts stay on one core. Only a matter of
/// speed: where the system does not allow it, nothing happens.
#[derive(Debug)]
pub(super) struct OneCore {
    before: Option<CpuSet>,
}

impl OneCore {
    pub(super) fn choose() -> Self {
        let Ok(before) = sched_getaffinity(None) else { return Self { before: None } };
        let allowed: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&core| before.is_set(core)).collect();
        // Several processes with a board each do not all take the same.
        let turn = STARTED.fetch_add(1, Ordering::Relaxed).wrapping_add(std::process::id() as usize);
        let chosen = turn.checked_rem(allowed.len()).and_then(|place| allowed.get(place));
        let mut one = CpuSet::new();
        chosen.iter().for_each(|&&core| one.set(core));
        let is_set = chosen.is_some() && sched_setaffinity(None, &one).is_ok();
        Self { before: is_set.then_some(before) }
    }
}

impl Drop for OneCore {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // It was allowed before.
            let _ = sched_setaffinity(None, before);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// And a child as well; afterwards all cores again.
    #[test]
    fn a_child_stays_on_the_same_core() {
        let before = sched_getaffinity(None).unwrap().count();
        let one = OneCore::choose();
        assert_eq!(sched_getaffinity(None).unwrap().count(), 1);
        let child = std::process::Command::new("nproc").output().unwrap();
        assert_eq!(String::from_utf8_lossy(&child.stdout).trim(), "1");
        drop(one);
        assert_eq!(sched_getaffinity(None).unwrap().count(), before);
    }
}
