//! From a commanded motion to the goals of the wheels' servos, with the stock firmware's
//! arithmetic, limit for limit.
//!
//! Source: OpenCR, turtlebot3_ros2: turtlebot3.cpp and turtlebot3_motor_driver.cpp; numbers of a
//! TurtleBot3 Burger.

use crate::parameters::{HIGHEST_ANGULAR_RAD_S, HIGHEST_LINEAR_M_S, TRACK_M};
use crate::wheels::WHEELS;

/// A commanded motion as the node writes it: 0.01 m/s along x, y, z and 0.01 rad/s about them.
pub type Command = [i32; 6];

/// Servo units for a wheel's 1 m/s: 1 / (0.033 m · 0.229 rev/min · 2π / 60).
const PER_M_S: f32 = 1_263.633;
/// No goal is beyond, in servo units; the servo's own limit (register 44) may be lower.
pub const GOAL_LIMIT: i32 = 337;

/// Left and right goal: each of the two motions clamped by itself, then each wheel, fractions cut
/// off.
#[must_use]
pub fn goals(command: &Command) -> [i32; WHEELS] {
    let [forward, _, _, _, _, turn] = *command;
    let linear = clamped(forward, HIGHEST_LINEAR_M_S);
    let angular = clamped(turn, HIGHEST_ANGULAR_RAD_S);
    let across = angular * (TRACK_M / 2.0);
    [linear - across, linear + across].map(|speed| ((speed * PER_M_S) as i32).clamp(-GOAL_LIMIT, GOAL_LIMIT))
}

fn clamped(hundredths: i32, limit: f32) -> f32 {
    (hundredths as f32 * 0.01).clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(forward: i32, turn: i32) -> [i32; 2] {
        goals(&[forward, 7, -7, 7, -7, turn])
    }

    /// By hand: 0.1 m/s are 126.36; 0.5 rad/s are ±0.04 m/s, 50.54.
    #[test]
    fn fractions_are_cut_off_towards_zero() {
        assert_eq!(of(0, 0), [0, 0]);
        assert_eq!(of(10, 0), [126, 126]);
        assert_eq!(of(-10, 0), [-126, -126]);
        assert_eq!(of(0, 50), [-50, 50]);
        assert_eq!(of(10, 50), [75, 176]);
        assert_eq!(of(1, 0), [12, 12]);
    }

    /// 0.2108 m/s are 266.4, 2.635 rad/s likewise; together 532.8, which the wheel's limit cuts.
    #[test]
    fn limits_are_those_of_the_stock_firmware() {
        assert_eq!(of(22, 0), [266, 266]);
        assert_eq!(of(1_000_000, 0), [266, 266]);
        assert_eq!(of(0, i32::MAX), [-266, 266]);
        assert_eq!(of(i32::MAX, i32::MAX), [0, 337]);
        assert_eq!(of(i32::MIN, i32::MIN), [0, -337]);
    }
}
