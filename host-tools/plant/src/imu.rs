//! An inertial measurement unit in the middle of the robot, axes along the body's: forward, left,
//! up.

use rand_chacha::ChaCha8Rng;

use super::body::GRAVITY;
use super::kinematics::Twist;
use super::noise::{Stream, bounded, stream};

/// Noise at rest, m/s²: 300 µg/√Hz over 41 Hz (TDK InvenSense MPU-9250, the Burger's; product
/// specification, Table 2).
const NOISE_M_S2: f64 = 300e-6 * GRAVITY * 6.403;

/// What the floor's roughness adds for every m/s of speed, m/s²: chosen, a fifth of a m/s² at a
/// small robot's cruise.
const ROUGHNESS_PER_S: f64 = 1.0;

/// How the ground lies under the robot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground {
    /// Rise per length ahead and to the left.
    pub(super) rise: [f64; 2],
    /// Acceleration that presses the robot to the floor, m/s².
    pub(super) normal_gravity: f64,
}

/// The unit, between two readings.
#[derive(Debug, Clone)]
pub(super) struct Imu {
    noise: ChaCha8Rng,
    last: Option<(f64, Twist)>,
}

impl Imu {
    pub(super) fn new(seed: u64) -> Self {
        Self { noise: stream(seed, Stream::Imu), last: None }
    }

    /// Specific force, m/s², as the mean since the last reading: at rest on level floor (0, 0, g).
    pub(super) fn read(&mut self, time_s: f64, twist: Twist, ground: Ground) -> [f64; 3] {
        let [vx, vy, omega] = twist;
        let [ax, ay] = match self.last.replace((time_s, twist)) {
            Some((before_s, before)) if time_s > before_s => {
                [0, 1].map(|i| (twist[i] - before[i]) / (time_s - before_s))
            }
            _ => [0.0; 2],
        };
        let [ahead, left] = ground.rise;
        let true_m_s2 = [
            // The body frame turns with the robot.
            ax - omega * vy + GRAVITY * ahead,
            ay + omega * vx + GRAVITY * left,
            ground.normal_gravity,
        ];
        let spread = NOISE_M_S2 + ROUGHNESS_PER_S * vx.hypot(vy);
        true_m_s2.map(|axis| axis + spread * bounded(&mut self.noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVEL: Ground = Ground { rise: [0.0; 2], normal_gravity: GRAVITY };

    /// Mean and spread of each axis over many readings of one state.
    fn held(twist: Twist, ground: Ground) -> ([f64; 3], [f64; 3]) {
        let mut imu = Imu::new(1);
        let rows: Vec<[f64; 3]> = (0..10_000).map(|k| imu.read(f64::from(k) * 0.01, twist, ground)).collect();
        let mean = [0, 1, 2].map(|i| rows.iter().map(|row| row[i]).sum::<f64>() / 1e4);
        let square = |i: usize| rows.iter().map(|row| (row[i] - mean[i]).powi(2)).sum::<f64>();
        (mean, [0, 1, 2].map(|i| (square(i) / 1e4).sqrt()))
    }

    /// 10 000 readings: a mean errs by σ/100, a spread by 0.7 %; four of each, and 0.4 % less
    /// spread for the clipping at 3 σ.
    #[test]
    fn feels_gravity_the_turn_and_the_floor() {
        let (mean, spread) = held([0.0; 3], LEVEL);
        for i in 0..3 {
            assert!((mean[i] - [0.0, 0.0, GRAVITY][i]).abs() < 0.04 * NOISE_M_S2, "{mean:?}");
            assert!((spread[i] / NOISE_M_S2 - 0.996).abs() < 0.03, "{spread:?}");
        }
        // 0.5 m/s at 2 rad/s: 1 m/s² to the left. On 0.1 rad, nose uphill to the right: (cos, sin)
        // of −30°.
        let (sin, cos) = 0.1_f64.sin_cos();
        let rise = [sin * 0.75_f64.sqrt(), -0.5 * sin];
        let slope = Ground { rise, normal_gravity: GRAVITY * cos };
        let (mean, spread) = held([0.5, 0.0, 2.0], slope);
        let expected = [GRAVITY * rise[0], 1.0 + GRAVITY * rise[1], GRAVITY * cos];
        for i in 0..3 {
            let sigma = NOISE_M_S2 + 0.5 * ROUGHNESS_PER_S;
            assert!((mean[i] - expected[i]).abs() < 0.04 * sigma, "{mean:?} {expected:?}");
            assert!((spread[i] / sigma - 0.996).abs() < 0.03, "{spread:?}");
        }
    }

    /// From 0 to 1 m/s forwards, 0.5 m/s sideways, in 0.1 s: 10 and 5 m/s², less and more what the
    /// turn adds.
    #[test]
    fn feels_acceleration_between_readings() {
        let mut imu = Imu::new(1);
        imu.read(0.0, [0.0; 3], LEVEL);
        let [x, y, _] = imu.read(0.1, [1.0, 0.5, 2.0], LEVEL);
        // At most three of 1.1 m/s of roughness and noise.
        let bound = 3.0 * (NOISE_M_S2 + 1.0_f64.hypot(0.5));
        assert!((x - 9.0).abs() <= bound && (y - 7.0).abs() <= bound, "{x} {y}");
    }
}
