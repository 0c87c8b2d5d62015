//! A drive: cruises, turns, spins on the spot, firm starts and stops, rests; a payload that changes
//! once.

use model_core::estimator::Sample;
use model_core::kinematics::MassMatrix;

pub(super) const WHEELS: usize = 2;
pub(super) const PERIOD_S: f64 = 0.005;
pub(super) const SECONDS: usize = 80;
pub(super) const SAMPLES: usize = SECONDS * 200;

/// Wheel speeds to reach one after the other, each held for [`LEG_SAMPLES`], rad/s.
const LEGS: [[f32; WHEELS]; 10] = [
    [4.0, 4.0],
    [6.0, 5.0],
    [2.5, 2.5],
    [0.0, 0.0],
    [3.0, -3.0],
    [5.0, 6.0],
    [6.5, 6.5],
    [1.0, 3.0],
    [-2.0, -2.0],
    [4.5, 3.5],
];
const LEG_SAMPLES: usize = 330;
/// rad/s²
const ACCELERATION: f32 = 6.0;
/// Total masses before and after the change, kg.
const MASSES: [f32; 2] = [2.5, 4.5];
/// Largest error of the speed, rad/s, and of the power, W.
const SPEED_NOISE: f32 = 0.005;
const POWER_NOISE: f32 = 0.1;

/// Where the drive is.
pub(crate) struct Profile {
    mass_matrix: MassMatrix<f32, WHEELS>,
    sample: usize,
    speed: [f32; WHEELS],
    /// Of the noise.
    state: u32,
}

impl Profile {
    pub(crate) fn new(mass_matrix: MassMatrix<f32, WHEELS>) -> Self {
        Self { mass_matrix, sample: 0, speed: [0.0; WHEELS], state: 1 }
    }

    pub(crate) fn next(&mut self) -> Sample<f32, WHEELS> {
        let target = LEGS[self.sample / LEG_SAMPLES % LEGS.len()];
        let mass = MASSES[usize::from(self.sample >= SAMPLES * 5 / 8)];
        self.sample += 1;
        let most = ACCELERATION * PERIOD_S as f32;
        let mut acceleration = [0.0; WHEELS];
        for ((speed, acceleration), target) in self.speed.iter_mut().zip(&mut acceleration).zip(target) {
            let step = (target - *speed).clamp(-most, most);
            *speed += step;
            *acceleration = step / PERIOD_S as f32;
        }
        let torque = self.mass_matrix.torque_per_kg(&acceleration);
        let mut power = 0.0;
        for ((w, a), k) in self.speed.into_iter().zip(acceleration).zip(torque) {
            let direction = if w == 0.0 { 0.0 } else { w.signum() };
            let t = (0.03 + 0.01 * mass) * direction + 0.01 * w + 0.003 * a + 1.3 * mass * k;
            power += (t * w + 3.0 * t * t).max(0.0);
        }
        Sample {
            wheel_speed: self.speed.map(|speed| speed + SPEED_NOISE * self.noise()),
            wheel_acceleration: None,
            power: power + POWER_NOISE * self.noise(),
        }
    }

    /// Evenly between −1 and 1 (a linear congruential generator's upper bits).
    fn noise(&mut self) -> f32 {
        self.state = self.state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.state >> 8) as f32 / (1 << 23) as f32 - 1.0
    }
}
