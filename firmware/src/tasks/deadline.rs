//! When samples are due, and which of them are late.

use crate::parameters::SAMPLE_PERIOD_US;

/// A sample that begins later than this after it was due is late, µs.
const MOST_LATE_US: u64 = SAMPLE_PERIOD_US / 2;

/// The grid on which samples are taken. Times are µs since start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Schedule {
    next_us: u64,
}

impl Schedule {
    /// The first one is due a period from now.
    pub(super) const fn new(now_us: u64) -> Self {
        Self { next_us: now_us + SAMPLE_PERIOD_US }
    }

    /// When the next sample is due.
    pub(super) const fn next_us(&self) -> u64 {
        self.next_us
    }

    /// A sample begins: how many deadlines were missed, this one's and those of samples that are
    /// left out because their time has passed. The grid stays where it was.
    pub(super) fn begin(&mut self, now_us: u64) -> u32 {
        let late_us = now_us.saturating_sub(self.next_us);
        let left_out = late_us / SAMPLE_PERIOD_US;
        self.next_us += (left_out + 1) * SAMPLE_PERIOD_US;
        let is_late = late_us % SAMPLE_PERIOD_US > MOST_LATE_US;
        u32::try_from(left_out).unwrap_or(u32::MAX).saturating_add(u32::from(is_late))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a period of 5 ms is allowed; the grid does not drift.
    #[test]
    fn late_is_what_begins_after_half_a_period() {
        let mut schedule = Schedule::new(1_000);
        let due: Vec<u64> = [0, 2_500, 2_501, 4_999, 0]
            .map(|late| {
                let due = schedule.next_us();
                assert_eq!(schedule.begin(due + late), u32::from(late > 2_500), "{late}");
                due
            })
            .into();
        assert_eq!(due, [6_000, 11_000, 16_000, 21_000, 26_000]);
    }

    #[test]
    fn what_is_left_out_is_counted_and_not_made_up_for() {
        let mut schedule = Schedule::new(0);
        assert_eq!(schedule.begin(5_000 + 3 * 5_000 + 100), 3);
        assert_eq!(schedule.next_us(), 25_000);
        assert_eq!(schedule.begin(25_000 + 5_000 + 3_000), 2);
        assert_eq!(schedule.begin(35_000), 0);
    }
}
