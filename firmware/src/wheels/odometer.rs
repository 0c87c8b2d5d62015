//! A wheel's position that goes on counting where its servo forgets its turns.

use crate::dynamixel::xl430::{Position, Present, Velocity};
use crate::parameters::{LONGEST_STEP_US, WHEEL_ACCELERATION_RAD_S2};
use crate::time::seconds;

/// Counts of one turn.
const TURN: i32 = 4096;

/// Continuous over a servo's restart, after which the servo counts from within one turn: the node
/// takes every jump for a way driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Odometer {
    /// Position, and the servo's own, at a time, µs since start.
    last: Option<(i32, Position, u64)>,
}

impl Odometer {
    /// With what a servo measures `time_us` since start. Begins with the servo's own position.
    pub fn update(&mut self, now: &Present, time_us: u64) -> i32 {
        let position = match self.last {
            None => now.position.0,
            Some((position, raw, at_us)) => {
                position.wrapping_add(way(raw, now, time_us.saturating_sub(at_us)))
            }
        };
        self.last = Some((position, now.position, time_us));
        position
    }

    /// Where the wheel was last seen.
    #[must_use]
    pub fn position(&self) -> Option<i32> {
        self.last.map(|(position, ..)| position)
    }
}

/// The counts since `before`: as the servo says, or, where it has restarted, the fewest that lead
/// to the same angle within a turn.
fn way(before: Position, now: &Present, elapsed_us: u64) -> i32 {
    let counts = now.position.0.wrapping_sub(before.0);
    let has_restarted = if elapsed_us <= LONGEST_STEP_US {
        let elapsed = seconds(elapsed_us);
        let expected = now.velocity.rad_per_s() * elapsed;
        let reach = 2.0 * (Position::COUNT + Velocity::COUNT * elapsed)
            + WHEEL_ACCELERATION_RAD_S2 * elapsed * (elapsed + crate::parameters::SERVO_VELOCITY_LAG_S);
        (counts as f32 * Position::COUNT - expected).abs() > reach
    } else {
        // It was silent: only a servo that has just started counts from within its first turn.
        let is_within = |position: Position| (0..TURN).contains(&position.0);
        is_within(now.position) && (!is_within(before) || counts.abs() > TURN / 2)
    };
    if !has_restarted {
        return counts;
    }
    let within = counts.rem_euclid(TURN);
    if within > TURN / 2 { within - TURN } else { within }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn present(position: i32, velocity: i32) -> Present {
        Present { position: Position(position), velocity: Velocity(velocity), ..Present::default() }
    }

    /// Code 100, 2.4 rad/s, is 7.8 counts a sample.
    #[test]
    fn counts_as_the_servo_does() {
        let mut odometer = Odometer::default();
        assert_eq!(odometer.position(), None);
        for (i, position) in [-70_000, -69_992, -69_984, -69_976].into_iter().enumerate() {
            assert_eq!(odometer.update(&present(position, 100), 5_000 * i as u64), position);
        }
        // Two samples without an answer.
        assert_eq!(odometer.update(&present(-69_953, 100), 30_000), -69_953);
    }

    /// -69,976 is 3752 within its turn.
    #[test]
    fn a_restart_is_no_way() {
        for (gap_us, moved) in [(5_000, 0), (5_000, 8), (400_000, 0), (400_000, -30)] {
            let mut odometer = Odometer::default();
            odometer.update(&present(-69_976, 0), 0);
            let velocity = if gap_us == 5_000 && moved == 8 { 100 } else { 0 };
            let back = odometer.update(&present((3752 + moved) % 4096, velocity), gap_us);
            assert_eq!(back, -69_976 + moved, "{gap_us} µs, {moved}");
            assert_eq!(odometer.update(&present(3752 + moved + 1, velocity), gap_us + 5_000), back + 1);
        }
    }

    /// A cable that was pulled for a second while the wheel went on.
    #[test]
    fn a_gap_without_a_restart_keeps_its_way() {
        let mut odometer = Odometer::default();
        odometer.update(&present(100_000, 200), 0);
        assert_eq!(odometer.update(&present(103_120, 200), 1_000_000), 103_120);
    }

    #[test]
    fn counters_wrap() {
        let mut odometer = Odometer::default();
        odometer.update(&present(i32::MAX - 3, 100), 0);
        assert_eq!(odometer.update(&present(i32::MIN + 4, 100), 5_000), i32::MIN + 4);
    }
}
