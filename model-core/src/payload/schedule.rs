//! When the mass is estimated, and from which buckets (Algorithm 2, Fig. 4).

/// The policy; all lengths in buckets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Schedule {
    /// The latest `window` buckets, at every bucket (MATW).
    Moving {
        /// Length of the window.
        window: usize,
    },
    /// Everything since the last known change.
    Cumulative,
    /// The first `window` buckets after a known change; that mass is held until the next.
    KnownChange {
        /// Length of the window.
        window: usize,
    },
    /// The first `window` buckets of every `every`; that mass is held until the next round.
    Periodic {
        /// Length of the window.
        window: usize,
        /// Length of a round.
        every: usize,
    },
}

/// Counts the buckets and says which to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timeline {
    schedule: Schedule,
    /// Buckets since the start, the last change or the start of the round.
    age: usize,
}

impl Timeline {
    /// Nothing seen yet.
    pub fn new(schedule: Schedule) -> Self {
        Self { schedule, age: 0 }
    }

    /// The policy.
    pub fn schedule(&self) -> Schedule {
        self.schedule
    }

    /// Buckets counted since the start, the last change or the start of the round.
    pub fn age(&self) -> usize {
        self.age
    }

    /// The payload is another since `ago` buckets.
    pub fn restart(&mut self, ago: usize) {
        self.age = ago;
    }

    /// What [`Self::advance`] will say.
    pub fn next(&self) -> Option<usize> {
        let age = self.age_with_one_more();
        match self.schedule {
            Schedule::Moving { window } => Some(age.min(window)),
            Schedule::Cumulative => Some(age),
            Schedule::KnownChange { window } | Schedule::Periodic { window, .. } => {
                (age <= window).then_some(age)
            }
        }
    }

    /// Counts one more bucket. `Some(n)`: estimate from the latest `n`; `None`: hold what was
    /// estimated.
    pub fn advance(&mut self) -> Option<usize> {
        let count = self.next();
        self.age = self.age_with_one_more();
        count
    }

    fn age_with_one_more(&self) -> usize {
        match self.schedule {
            Schedule::Periodic { every, .. } if self.age >= every => 1,
            _ => self.age.saturating_add(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Schedule, Timeline};
    use std::vec::Vec;

    fn run(schedule: Schedule, buckets: usize, change: usize) -> Vec<Option<usize>> {
        let mut timeline = Timeline::new(schedule);
        (0..buckets)
            .map(|i| {
                if i == change {
                    timeline.restart(0);
                }
                timeline.advance()
            })
            .collect()
    }

    #[test]
    fn policies_of_algorithm_2() {
        let some = |values: &[usize]| values.iter().map(|v| Some(*v)).collect::<Vec<_>>();
        assert_eq!(run(Schedule::Moving { window: 3 }, 7, 4), some(&[1, 2, 3, 3, 1, 2, 3]));
        assert_eq!(run(Schedule::Cumulative, 6, 4), some(&[1, 2, 3, 4, 1, 2]));
        assert_eq!(
            run(Schedule::KnownChange { window: 2 }, 7, 4),
            [Some(1), Some(2), None, None, Some(1), Some(2), None]
        );
        assert_eq!(
            run(Schedule::Periodic { window: 1, every: 3 }, 7, 99),
            [Some(1), None, None, Some(1), None, None, Some(1)]
        );
    }
}
