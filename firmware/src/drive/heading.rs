//! The robot's heading from its wheels: what stands for an inertial sensor's orientation, which
//! this firmware does not read.

use crate::dynamixel::xl430::Position;
use crate::parameters::{TRACK_M, WHEEL_RADIUS_M};

/// A rotation about the vertical axis since start, as a unit quaternion: never all zeros, which the
/// node takes for a robot that never turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    /// Cosine and sine of half the angle.
    half: [f32; 2],
    last: Option<[i32; 2]>,
}

impl Default for Heading {
    fn default() -> Self {
        Self::START
    }
}

impl Heading {
    /// At start.
    pub const START: Self = Self { half: [1.0, 0.0], last: None };

    /// The wheels stand at these positions, left and right, counted forward.
    pub fn update(&mut self, positions: [i32; 2]) {
        let before = self.last.replace(positions);
        let Some([left_before, right_before]) = before else { return };
        let [left, right] = positions;
        let counts = right.wrapping_sub(right_before).wrapping_sub(left.wrapping_sub(left_before));
        if counts == 0 {
            return;
        }
        let half = counts as f32 * (Position::COUNT * WHEEL_RADIUS_M / TRACK_M / 2.0);
        // Beyond what two samples can be apart it is turned in parts that the series below holds
        // for.
        let parts = (half.abs() * 10.0) as u32 + 1;
        let step = half / parts as f32;
        for _ in 0..parts.min(1000) {
            self.turn(step);
        }
    }

    /// By half an angle below 0.1 rad: sine and cosine to 1e-8, and back to length 1.
    fn turn(&mut self, half: f32) {
        let square = half * half;
        let sine = half * (1.0 - square / 6.0 * (1.0 - square / 20.0));
        let cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0);
        let [w, z] = self.half;
        let (w, z) = (w * cosine - z * sine, z * cosine + w * sine);
        let correction = 1.5 - 0.5 * (w * w + z * z);
        self.half = [w * correction, z * correction];
    }

    /// w, x, y, z.
    #[must_use]
    pub const fn quaternion(&self) -> [f32; 4] {
        let [w, z] = self.half;
        [w, 0.0, 0.0, z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn yaw(heading: &Heading) -> f64 {
        let [w, x, y, z] = heading.quaternion().map(f64::from);
        assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-6);
        2.0 * z.atan2(w)
    }

    /// Counts of one wheel, the other going back as far, for one turn of the robot: π · 0.160 m /
    /// (2π · 0.033 m) turns.
    const TURN: f64 = 4096.0 * 0.160 / 2.0 / 0.033;

    #[test]
    fn a_turn_on_the_spot_by_its_geometry() {
        let mut heading = Heading::START;
        heading.update([5, -5]);
        assert_eq!(heading.quaternion(), [1.0, 0.0, 0.0, 0.0]);
        let quarter = (TURN / 4.0) as i32;
        for step in 0..=quarter {
            heading.update([5 - step, -5 + step]);
        }
        let expected = f64::from(quarter) / TURN * std::f64::consts::TAU;
        assert!((yaw(&heading) - expected).abs() < 1e-4, "{}", yaw(&heading));
    }

    /// An hour of turning without a stop, 500 turns: 720,000 roundings of 6e-8 each are 0.04 rad,
    /// if all went the same way.
    #[test]
    fn it_stays_exact_for_an_hour() {
        let mut heading = Heading::START;
        let mut count = 0;
        for _ in 0..720_000 {
            count += 7;
            heading.update([-count, count]);
        }
        let turns = f64::from(count) / TURN;
        let expected = (turns - turns.round()) * std::f64::consts::TAU;
        let off = (yaw(&heading) - expected).rem_euclid(std::f64::consts::TAU);
        let off = off.min(std::f64::consts::TAU - off);
        assert!(off < 0.01, "{off}");
    }

    /// After a gap, across the counters' end, straight on.
    #[test]
    fn large_steps_and_wrapping_counters() {
        let mut heading = Heading::START;
        heading.update([i32::MIN + 3, i32::MAX - 3]);
        let eighth = (TURN / 8.0) as i32;
        heading.update([(i32::MIN + 3).wrapping_sub(eighth), (i32::MAX - 3).wrapping_add(eighth)]);
        assert!((yaw(&heading) - std::f64::consts::FRAC_PI_4).abs() < 1e-3);
        let before = heading.quaternion();
        heading.update([0, 0]);
        heading.update([5000, 5000]);
        let turned = heading;
        heading.update([9000, 9000]);
        assert_eq!(heading.quaternion(), turned.quaternion());
        assert_ne!(before, turned.quaternion());
    }
}
