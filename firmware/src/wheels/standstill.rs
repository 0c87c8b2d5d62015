//! Whether the robot stands: only then may the flash be written, because that stops the processor
//! for a while.

use super::{WHEELS, WheelReading};
use crate::dynamixel::xl430::{Position, Velocity};
use crate::parameters::STANDSTILL_US;
use crate::time::seconds;

/// Watches for how long the wheels have been at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standstill {
    /// Where the wheels are at rest, and since when, µs since start.
    rest: Option<([Position; WHEELS], u64)>,
}

impl Standstill {
    /// Whether the wheels have stood still long enough, with this sample taken `time_us` since
    /// start.
    ///
    /// A wheel is at rest while it is slower than `dead_band` (rad/s): by its velocity register, to
    /// whose one count that has to be widened, and by its position, which over the whole time may
    /// not go further than at that speed. A wheel that does not answer may be turning.
    pub fn update(
        &mut self,
        readings: &[Option<WheelReading>; WHEELS],
        time_us: u64,
        dead_band: f32,
    ) -> bool {
        let now = positions_at_rest(readings, dead_band.max(Velocity::COUNT));
        let Some(now) = now else {
            self.rest = None;
            return false;
        };
        let reach = dead_band * seconds(STANDSTILL_US);
        let held = self.rest.filter(|(rest, since)| {
            let stayed = now.iter().zip(rest).all(|(now, rest)| now.radians_since(*rest).abs() <= reach);
            stayed && time_us >= *since
        });
        let (_, since) = *self.rest.insert(held.unwrap_or((now, time_us)));
        time_us - since >= STANDSTILL_US
    }
}

/// Where the wheels are, when both answered and neither register is above `slow` (rad/s).
fn positions_at_rest(readings: &[Option<WheelReading>; WHEELS], slow: f32) -> Option<[Position; WHEELS]> {
    let [Some(left), Some(right)] = readings else { return None };
    let wheels = [left.present, right.present];
    let at_rest = wheels.iter().all(|present| present.velocity.rad_per_s().abs() <= slow);
    at_rest.then_some(wheels.map(|present| present.position))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamixel::xl430::Present;

    fn reading(position: i32, velocity: i32) -> Option<WheelReading> {
        let present =
            Present { position: Position(position), velocity: Velocity(velocity), ..Present::default() };
        Some(WheelReading { speed: 0.0, present })
    }

    /// Every 5 ms a sample of both wheels: after how many ms they stand, if they do within 3 s.
    fn stands_after(wheels: impl Fn(u64) -> [Option<WheelReading>; WHEELS]) -> Option<u64> {
        let mut standstill = Standstill::default();
        (0..600).map(|i| 5 * i).find(|&ms| standstill.update(&wheels(ms), 1000 * ms, 0.02))
    }

    #[test]
    fn at_rest_for_the_time_asked() {
        assert_eq!(stands_after(|_| [reading(7, 0), reading(-7, 0)]), Some(STANDSTILL_US / 1000));
        // One count of the register, and one of the position, are noise.
        let noisy = |ms: u64| [reading((ms % 2) as i32, 1), reading(0, -((ms % 2) as i32))];
        assert_eq!(stands_after(noisy), Some(STANDSTILL_US / 1000));
    }

    #[test]
    fn from_the_end_of_the_motion_on() {
        let stops = |ms: u64| {
            let (position, velocity) = if ms < 500 { ((ms / 5) as i32, 100) } else { (100, 0) };
            [reading(position, velocity), reading(0, 0)]
        };
        assert_eq!(stands_after(stops), Some(500 + STANDSTILL_US / 1000));
    }

    /// 0.04 rad/s are 26 counts a second; the register says 0 in vain.
    #[test]
    fn creeping_is_no_standstill() {
        assert_eq!(stands_after(|ms| [reading((ms * 26 / 1000) as i32, 0), reading(0, 0)]), None);
        assert_eq!(stands_after(|_| [reading(0, 0), reading(0, 2)]), None);
    }

    #[test]
    fn a_wheel_that_does_not_answer_may_be_turning() {
        assert_eq!(stands_after(|_| [reading(0, 0), None]), None);
        let once = |ms: u64| [reading(0, 0), if ms == 600 { None } else { reading(0, 0) }];
        assert_eq!(stands_after(once), Some(605 + STANDSTILL_US / 1000));
    }

    #[test]
    fn moving_off_ends_it_at_once() {
        let mut standstill = Standstill::default();
        let still = [reading(0, 0); WHEELS];
        assert!((0..=200).any(|i| standstill.update(&still, 5_000 * i, 0.02)));
        assert!(!standstill.update(&[reading(0, 0), reading(2, 20)], 1_005_000, 0.02));
    }
}
