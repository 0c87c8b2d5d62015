//! Steps between samples that add up.

use crate::parameters::{BUCKET_S, MOST_BUCKETS};

/// In units of 2⁻²⁰ s, just below 1 µs: single precision adds these up without rounding as long as
/// the sum stays below 16 s. The estimator adds steps up to a bucket's length; steps of 0.005 s,
/// rounded each, would shift its end by a sample or two an hour against the host's.
const PER_SECOND: u64 = 1 << 20;

/// One bucket.
const BUCKET: u64 = BUCKET_S as u64 * PER_SECOND;

/// The time of the last sample that the estimator took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Clock {
    last_us: Option<u64>,
}

impl Clock {
    /// Time since the last sample, s: 0 for the first.
    ///
    /// A gap that the buckets' ring cannot hold is cut by whole buckets: what was known is
    /// forgotten all the same, and the buckets behind it end when they would have, as with the
    /// host's longer ring. The second number is what was cut, s: effects of time count it.
    pub(super) fn advance(&mut self, time_us: u64) -> (f32, f32) {
        let elapsed = self.last_us.map_or(0, |last| ticks(time_us).saturating_sub(ticks(last)));
        self.last_us = Some(time_us);
        let most = BUCKET * MOST_BUCKETS as u64;
        let kept = if elapsed < most { elapsed } else { most - BUCKET + elapsed % BUCKET };
        let number = |ticks: u64| u32::try_from(ticks).map_or(ticks as f32, |short| short as f32);
        let seconds = |ticks: u64| number(ticks) / PER_SECOND as f32;
        (seconds(kept), seconds(elapsed.saturating_sub(kept)))
    }

    /// Time since the last sample, µs.
    pub(super) fn since_us(&self, time_us: u64) -> u64 {
        self.last_us.map_or(u64::MAX, |last| time_us.saturating_sub(last))
    }
}

/// 2²⁰ / 10⁶ = 2¹⁴ / 5⁶. Good for 35 years.
const fn ticks(time_us: u64) -> u64 {
    time_us.saturating_mul(1 << 14) / 15_625
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An hour of 5 ms, a second at a time: every second ends where it should, which steps of
    /// 0.005_f32 miss by 10 ms.
    #[test]
    fn steps_add_up() {
        let mut clock = Clock::default();
        clock.advance(0);
        let mut phase = 0.0_f32;
        for sample in 1..=3600 * 200_u64 {
            phase += clock.advance(5_000 * sample).0;
            if sample.is_multiple_of(200) {
                assert_eq!(phase, 1.0, "sample {sample}");
                phase -= 1.0;
            }
        }
    }

    #[test]
    fn one_step_is_the_time_that_passed() {
        let mut clock = Clock::default();
        assert_eq!(clock.advance(7), (0.0, 0.0));
        for step in [1_000, 5_000, 25_000, 12_000_000] {
            let start = clock.last_us.unwrap();
            assert_eq!(clock.since_us(start + step), step);
            let (elapsed, cut) = clock.advance(start + step);
            assert_eq!(cut, 0.0);
            let elapsed = f64::from(elapsed);
            assert!((elapsed - step as f64 * 1e-6).abs() < 1e-6, "{step}: {elapsed}");
        }
        // Backwards is no time.
        assert_eq!(clock.advance(3), (0.0, 0.0));
    }

    /// 100.25 s are 31.25 s to a ring of 32 buckets.
    #[test]
    fn long_gaps_keep_their_fraction() {
        let mut clock = Clock::default();
        clock.advance(0);
        assert_eq!(clock.advance(100_250_000), ((MOST_BUCKETS - 1) as f32 + 0.25, 69.0));
        assert_eq!(clock.advance(100_250_000 + 31_500_000), (31.5, 0.0));
    }
}
