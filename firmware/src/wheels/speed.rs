//! A wheel's speed from the two registers that tell it.
//!
//! The difference of positions is the mean speed since the last sample: coarse, a count in 5 ms
//! being 0.31 rad/s, but what one sample rounds away the next has, so that nothing is left of it
//! behind the filter. The servo's velocity register is finer, 0.024 rad/s, but smoothed and late in
//! ways that nobody documents. So the position counts, unless it contradicts the register.

use crate::dynamixel::xl430::{Position, Present, Velocity};
use crate::parameters::{LONGEST_STEP_US, SERVO_VELOCITY_LAG_S, WHEEL_ACCELERATION_RAD_S2};
use crate::time::seconds;

/// Turns what a servo says into a speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Speedometer {
    last: Option<(Position, u64)>,
}

impl Speedometer {
    /// The wheel's speed, rad/s in the servo's direction, at a sample taken `time_us` since start.
    ///
    /// It is the velocity register's where there is no position to compare with, or none within a
    /// longest step: a mean over a gap is no speed at its end. So it is where the position has
    /// jumped: a servo that restarts forgets its turns.
    pub fn update(&mut self, now: &Present, time_us: u64) -> f32 {
        let register = now.velocity.rad_per_s();
        let difference = self.last.and_then(|(position, at_us)| {
            let elapsed = time_us.checked_sub(at_us).filter(|step| (1..=LONGEST_STEP_US).contains(step))?;
            let elapsed = seconds(elapsed);
            let speed = now.position.radians_since(position) / elapsed;
            ((speed - register).abs() <= disagreement(elapsed)).then_some(speed)
        });
        self.last = Some((now.position, time_us));
        difference.unwrap_or(register)
    }
}

/// How far the two may be apart, rad/s, over `elapsed` s: a count of either, and what the wheel can
/// have gained meanwhile.
fn disagreement(elapsed: f32) -> f32 {
    Position::COUNT / elapsed + Velocity::COUNT + WHEEL_ACCELERATION_RAD_S2 * (elapsed + SERVO_VELOCITY_LAG_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_US: u64 = 5_000;

    fn present(position: i32, velocity: i32) -> Present {
        Present { position: Position(position), velocity: Velocity(velocity), ..Present::default() }
    }

    /// The register's speed at code 100 is 2.398 rad/s; so are 7.82 counts in 5 ms.
    fn update(speedometer: &mut Speedometer, position: i32, time_us: u64) -> f32 {
        speedometer.update(&present(position, 100), time_us)
    }

    const REGISTER: f32 = 100.0 * Velocity::COUNT;

    fn is_register(speed: f32) -> bool {
        (speed - REGISTER).abs() < 1e-6
    }

    /// 8 counts in 5.12 ms are 0.01227 rad, 2.3968 rad/s.
    #[test]
    fn counts_over_the_time_that_really_passed() {
        let mut speedometer = Speedometer::default();
        assert!(is_register(update(&mut speedometer, 0, 0)));
        let speed = update(&mut speedometer, 8, 5_120);
        assert!((speed - 2.396_844).abs() < 1e-5, "{speed}");
        // One period was left out: the mean over two is still no gap.
        let speed = update(&mut speedometer, 24, 5_120 + 10_240);
        assert!((speed - 2.396_844).abs() < 1e-5, "{speed}");
    }

    /// At any speed the sum of the steps is the angle: quantisation does not add up.
    #[test]
    fn the_mean_is_exact() {
        for speed in [-6.3_f64, -0.05, 0.3, 1.0, 6.3] {
            let mut speedometer = Speedometer::default();
            let count = |i: u64| (speed * 0.005 * i as f64 / f64::from(Position::COUNT)).floor() as i32;
            let code = (speed / f64::from(Velocity::COUNT)).round() as i32;
            let speeds: Vec<f64> = (0..=2000)
                .map(|i| f64::from(speedometer.update(&present(count(i), code), STEP_US * i)))
                .collect();
            let mean = speeds[1..].iter().sum::<f64>() / 2000.0;
            // One count in 10 s.
            assert!((mean - speed).abs() < 1.6e-4, "{speed}: {mean}");
        }
    }

    #[test]
    fn positions_wrap_without_a_jump() {
        let mut speedometer = Speedometer::default();
        update(&mut speedometer, i32::MAX - 3, 0);
        let speed = update(&mut speedometer, i32::MIN + 4, STEP_US);
        assert!((speed - 8.0 * Position::COUNT / 0.005).abs() < 1e-4, "{speed}");
    }

    /// After a restart the servo counts from within one turn.
    #[test]
    fn a_jump_is_no_speed() {
        for jump in [-70_000, -4096, -40, 40, 2048, i32::MAX] {
            let mut speedometer = Speedometer::default();
            update(&mut speedometer, 0, 0);
            assert!(is_register(update(&mut speedometer, jump, STEP_US)), "{jump}");
            assert!(!is_register(update(&mut speedometer, jump.wrapping_add(7), 2 * STEP_US)), "{jump}");
        }
    }

    #[test]
    fn starts_anew_behind_a_gap() {
        for (elapsed, expected) in [(LONGEST_STEP_US, false), (LONGEST_STEP_US + 1, true), (0, true)] {
            let mut speedometer = Speedometer::default();
            update(&mut speedometer, 0, 1_000);
            assert_eq!(is_register(update(&mut speedometer, 39, 1_000 + elapsed)), expected, "{elapsed} µs");
        }
        let mut speedometer = Speedometer::default();
        update(&mut speedometer, 0, 1_000);
        assert!(is_register(update(&mut speedometer, 8, 999)));
    }
}
