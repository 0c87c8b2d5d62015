//! What was driven since start.

use crate::parameters::{LONGEST_STEP_US, WHEEL_RADIUS_M};
use crate::wheels::WHEELS;

/// Counts, left and right together, that the wheels may go to and fro without having driven: 0.4
/// mm. A wheel that stands on the edge of a count would drive 4 m a day otherwise.
const PLAY: u32 = 16;

/// Way of the middle between the wheels for one count of one of them, nm.
const NM_PER_COUNT: u64 = (core::f64::consts::TAU * WHEEL_RADIUS_M as f64 / 4096.0 / 2.0 * 1e9) as u64;
const NM_PER_CM: u64 = 10_000_000;
const US_PER_S: u64 = 1_000_000;

/// Way and time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Trip {
    /// Of both wheels together.
    counts: u64,
    driving_us: u64,
    /// Where the wheels were when `counts` was counted last.
    anchor: Option<[i32; WHEELS]>,
    last_us: Option<u64>,
}

impl Trip {
    /// Nothing driven.
    pub const START: Self = Self { counts: 0, driving_us: 0, anchor: None, last_us: None };

    /// A sample `time_us` since start: positions that go on, counted forward, where both are known.
    pub fn update(&mut self, positions: Option<[i32; WHEELS]>, is_driving: bool, time_us: u64) {
        let before = self.last_us.replace(time_us);
        if let Some(before) = before
            && is_driving
        {
            self.driving_us += time_us.saturating_sub(before).min(LONGEST_STEP_US);
        }
        let Some(now) = positions else { return };
        let anchor = *self.anchor.get_or_insert(now);
        let way =
            now.iter().zip(anchor).map(|(now, anchor)| now.wrapping_sub(anchor)).fold(0, i32::wrapping_add);
        if way.unsigned_abs() >= PLAY {
            self.counts += u64::from(way.unsigned_abs());
            self.anchor = Some(now);
        }
    }

    /// cm
    #[must_use]
    pub fn distance_cm(&self) -> u32 {
        u32::try_from(self.counts.saturating_mul(NM_PER_COUNT) / NM_PER_CM).unwrap_or(u32::MAX)
    }

    /// s
    #[must_use]
    pub fn driving_s(&self) -> u32 {
        u32::try_from(self.driving_us / US_PER_S).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten turns of both wheels are 10 · 2π · 3.3 cm = 207.3 cm, there and back as much again; on
    /// the spot nothing.
    #[test]
    fn counts_the_way_of_the_middle() {
        let mut trip = Trip::START;
        for step in 0..=4096 {
            trip.update(Some([(i32::MAX - 5).wrapping_add(10 * step), 7 + 10 * step]), true, 5_000);
        }
        assert_eq!(trip.distance_cm(), 207);
        for step in (0..=4096).rev() {
            trip.update(Some([(i32::MAX - 5).wrapping_add(10 * step), 7 + 10 * step]), true, 5_000);
        }
        assert_eq!(trip.distance_cm(), 414);
        for step in 0..=4096 {
            trip.update(Some([(i32::MAX - 5).wrapping_sub(10 * step), 7 + 10 * step]), true, 5_000);
        }
        assert_eq!(trip.distance_cm(), 414);
    }

    #[test]
    fn a_wheel_on_the_edge_of_a_count_drives_nowhere() {
        let mut trip = Trip::START;
        for step in 0..10_000 {
            trip.update(Some([step % 2, step % 3]), false, 0);
            trip.update(None, false, 0);
        }
        assert_eq!(trip.counts, 0);
    }

    /// 40 samples of 5 ms in motion, and a gap of a second that counts for 25 ms.
    #[test]
    fn time_counts_in_motion() {
        let mut trip = Trip::START;
        (0..=100).for_each(|i| trip.update(None, i > 60, 5_000 * i));
        assert_eq!(trip.driving_us, 200_000);
        trip.update(None, true, 1_500_000);
        assert_eq!((trip.driving_us, trip.driving_s()), (225_000, 0));
    }
}
