//! The time between messages of the wheels: by their stamps, as long as these can be believed.
//!
//! A sender's clock may differ from ours, jump, or stand still; a receipt is late by what the
//! network does. So steps are those of the stamps where receipts do not contradict them, and those
//! of the receipts where they do.

use std::collections::VecDeque;

/// Stamps and receipts contradict each other where they differ by more over one step, s. No network
/// of a robot is so late.
const JUMP_S: f64 = 0.5;

/// Steps that the period is the median of: at 20 Hz the first two seconds.
const STEPS: usize = 41;

/// Another rate, not jitter.
const OTHER_RATE: f64 = 0.3;

/// A message in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// The first one, or the first after a gap of unknown length.
    First,
    /// So much later than the one before, s.
    After(f64),
    /// The same, but the sender's clock has jumped.
    Jumped(f64),
    /// Not later than the one before: not used.
    Late,
}

/// Measures steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Clock {
    last: Option<(f64, Option<f64>)>,
    steps: VecDeque<f64>,
}

impl Clock {
    /// A message, received at `at` s, with its stamp, s on the sender's clock.
    pub(super) fn step(&mut self, at: f64, stamp: Option<f64>) -> Step {
        let Some((last_at, last_stamp)) = self.last else {
            self.last = Some((at, stamp));
            return Step::First;
        };
        let received = (at - last_at).max(0.0);
        let step = match (last_stamp, stamp) {
            (Some(before), Some(now)) => {
                let stamped = now - before;
                if stamped <= 0.0 && stamped > -JUMP_S {
                    return Step::Late;
                }
                if (stamped - received).abs() > JUMP_S {
                    Step::Jumped(received)
                } else {
                    Step::After(stamped)
                }
            }
            _ => Step::After(received),
        };
        self.last = Some((at, stamp));
        if let Step::After(seconds) = step {
            if self.steps.len() == STEPS {
                self.steps.pop_front();
            }
            self.steps.push_back(seconds);
        }
        step
    }

    /// A new sender, with its own clock and rate.
    pub(super) fn restart(&mut self) {
        *self = Self::default();
    }

    /// Time between messages, s; `None` before there were enough of them.
    pub(super) fn period_s(&self) -> Option<f64> {
        if self.steps.len() < STEPS {
            return None;
        }
        let mut sorted: Vec<f64> = self.steps.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        Some(sorted[STEPS / 2]).filter(|period| *period > 0.0)
    }

    /// The time between messages, s, where it differs from this one.
    pub(super) fn other_period_s(&self, period_s: f64) -> Option<f64> {
        self.period_s().filter(|now| (now / period_s - 1.0).abs() > OTHER_RATE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Received late by turns, but stamped evenly: the stamps count.
    #[test]
    fn stamps_count_where_receipts_do_not_contradict_them() {
        let mut clock = Clock::default();
        assert_eq!(clock.step(0.0, Some(1e6)), Step::First);
        for index in 1..=STEPS as u32 {
            let time = 0.05 * f64::from(index);
            let Step::After(step) = clock.step(time + 0.02 * f64::from(index % 2), Some(1e6 + time)) else {
                panic!("message {index}")
            };
            assert!((step - 0.05).abs() < 1e-9, "{step}");
        }
        assert!((clock.period_s().unwrap() - 0.05).abs() < 1e-9);
        assert_eq!(clock.other_period_s(0.06), None);
        assert!(clock.other_period_s(0.1).is_some());
    }

    #[test]
    fn a_clock_that_jumps_is_not_believed() {
        let mut clock = Clock::default();
        clock.step(0.0, Some(100.0));
        // Forward by an hour, then back by two; a message that is out of order, and one that comes
        // twice.
        assert_eq!(clock.step(1.0, Some(3701.0)), Step::Jumped(1.0));
        assert_eq!(clock.step(1.25, Some(-3500.0)), Step::Jumped(0.25));
        assert_eq!(clock.step(1.5, Some(-3500.25)), Step::Late);
        assert_eq!(clock.step(1.5, Some(-3500.0)), Step::Late);
        // The step is since the last that was used.
        assert_eq!(clock.step(1.75, Some(-3499.5)), Step::After(0.5));
    }

    #[test]
    fn without_stamps_receipts_count() {
        let mut clock = Clock::default();
        clock.step(0.0, None);
        assert_eq!(clock.step(0.25, None), Step::After(0.25));
        assert_eq!(clock.step(0.5, Some(9.0)), Step::After(0.25));
        assert_eq!(clock.period_s(), None);
    }
}
