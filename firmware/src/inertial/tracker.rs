//! From readings to an orientation that never jumps.
//!
//! The filter is VQF (D. Laidig, T. Seel, "VQF: Highly accurate IMU orientation estimation with
//! bias estimation and magnetic disturbance rejection", Information Fusion 2023) in the port
//! `vqf-rs`, six axes: rotation summed up, inclination from gravity. What is left of the
//! gyroscope's bias it learns while the wheels stand; turning slowly and evenly it would take for
//! bias, so meanwhile it may not.

use model_core::real::Real;
use vqf_rs::{Params, VQF};

use super::Motion;
use crate::parameters::SAMPLE_PERIOD_US;

/// Readings of a calibration: the stock firmware's, 2.56 s.
const CALIBRATION: u16 = 512;
/// At rest no reading is further from the mean of those before, rad/s: 2 °/s, some thirty times the
/// noise.
const STILL_RAD_S: f32 = 0.035;
/// No bias is greater, rad/s: 20 °/s, four times the MPU-9250's tolerance (its specification, table
/// 1).
const MOST_BIAS_RAD_S: f32 = 0.35;

/// A quaternion: w, x, y, z.
type Quaternion = [f32; 4];

/// The orientation, from the sensor or from the wheels.
pub struct Tracker {
    filter: VQF,
    /// rad/s; `None` before the first calibration.
    bias: Option<[f32; 3]>,
    calibration: Option<Calibration>,
    /// Turns the source's yaw into the yaw that is shown: w and z of a rotation about the vertical.
    anchor: [f32; 2],
    /// What is shown.
    shown: Quaternion,
    /// Who told it last.
    source: Source,
}

/// Who tells the orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Wheels,
    Sensor,
    /// The sensor did, and does not any more.
    Nobody,
}

/// Readings summed up while the robot stands.
#[derive(Debug, Clone, Copy, Default)]
struct Calibration {
    sum: [f32; 3],
    count: u16,
}

impl Default for Tracker {
    fn default() -> Self {
        Self::new()
    }
}

impl Tracker {
    /// At start: level, towards where it is.
    #[must_use]
    pub fn new() -> Self {
        Self {
            filter: filter(),
            bias: None,
            calibration: Some(Calibration::default()),
            anchor: [1.0, 0.0],
            shown: [1.0, 0.0, 0.0, 0.0],
            source: Source::Wheels,
        }
    }

    /// Learns the bias anew the next time that the robot stands for 2.56 s; the one before counts
    /// until then.
    pub fn calibrate(&mut self) {
        self.calibration = Some(Calibration::default());
    }

    /// Whether a calibration is under way.
    #[must_use]
    pub const fn is_calibrating(&self) -> bool {
        self.calibration.is_some()
    }

    /// rad/s; `None` before the first calibration.
    #[must_use]
    pub fn bias(&self) -> Option<[f32; 3]> {
        let (rest, _) = self.filter.bias_estimate();
        self.bias.map(|bias| plus(bias, rest))
    }

    /// A reading, `elapsed_s` after the one before; whether the wheels stand. Gives the rotation
    /// without bias, rad/s, once that is known.
    pub fn feel(&mut self, motion: Motion, elapsed_s: f32, is_standing: bool) -> Option<[f32; 3]> {
        self.learn(&motion, is_standing);
        let bias = self.bias?;
        let rotation = minus(motion.angular_velocity, bias);
        self.filter.set_rest_bias_est_enabled(is_standing);
        self.filter.update_gyr_with_ts(rotation, elapsed_s);
        self.filter.update_acc(motion.acceleration);
        let attitude = self.filter.quat_6d();
        let attitude = [attitude.0, attitude.1, attitude.2, attitude.3];
        if attitude.iter().all(|component| component.is_finite()) {
            self.show(attitude, Source::Sensor);
        } else {
            // Nothing that a chip can say; begins anew where it was.
            self.filter = filter();
            self.source = Source::Nobody;
        }
        let (rest, _) = self.filter.bias_estimate();
        Some(minus(rotation, rest))
    }

    /// The sensor's readings have a gap: where it is now only the wheels say.
    pub fn lose(&mut self) {
        if self.source == Source::Sensor {
            self.filter = filter();
            self.source = Source::Nobody;
        }
        // The rest of a calibration would be of another chip.
        self.calibration = self.calibration.map(|_| Calibration::default());
    }

    /// The heading from the wheels: shown while the sensor tells nothing.
    pub fn roll(&mut self, heading: Quaternion) {
        self.show(heading, Source::Wheels);
    }

    /// A unit quaternion w, x, y, z.
    #[must_use]
    pub const fn quaternion(&self) -> Quaternion {
        self.shown
    }

    /// Takes a source's orientation: one that comes after another source goes on from the yaw that
    /// is shown.
    fn show(&mut self, told: Quaternion, by: Source) {
        if self.source != by {
            self.source = by;
            let [w, z] = yaw(self.shown);
            let [v, y] = yaw(told);
            // That of what is shown, after the source's turned back.
            self.anchor = [w * v + z * y, z * v - w * y];
        }
        let [c, s] = self.anchor;
        let [w, x, y, z] = told;
        self.shown = unit([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]);
    }

    fn learn(&mut self, motion: &Motion, is_standing: bool) {
        let Some(calibration) = &mut self.calibration else { return };
        let rates = motion.angular_velocity;
        let share = 1.0 / f32::from(calibration.count.max(1));
        let mean = calibration.sum.map(|sum| sum * share);
        let strays = calibration.count > 0
            && minus(rates, mean).iter().any(|difference| difference.abs() > STILL_RAD_S);
        if !is_standing || strays || rates.iter().any(|rate| rate.abs() > MOST_BIAS_RAD_S) {
            *calibration = Calibration::default();
            return;
        }
        calibration.sum = plus(calibration.sum, rates);
        calibration.count += 1;
        if calibration.count >= CALIBRATION {
            self.bias = Some(calibration.sum.map(|sum| sum / f32::from(CALIBRATION)));
            self.calibration = None;
            // What it had learned was of the bias before.
            self.filter.set_bias_estimate([0.0; 3], Some(0.1));
        }
    }
}

fn filter() -> VQF {
    let params =
        Params { rest_bias_est_enabled: false, mag_dist_rejection_enabled: false, ..Params::default() };
    VQF::new(SAMPLE_PERIOD_US as f32 * 1e-6, None, None, Some(params))
}

/// w and z of its rotation about the vertical; of one that has none, none.
fn yaw([w, _, _, z]: Quaternion) -> [f32; 2] {
    let length = Real::sqrt(w * w + z * z);
    if length > 1e-6 { [w / length, z / length] } else { [1.0, 0.0] }
}

fn unit(parts: Quaternion) -> Quaternion {
    let length = Real::sqrt(parts.iter().map(|component| component * component).sum::<f32>());
    parts.map(|component| component / length)
}

fn plus([a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> [f32; 3] {
    [a + d, b + e, c + f]
}

fn minus([a, b, c]: [f32; 3], [d, e, f]: [f32; 3]) -> [f32; 3] {
    [a - d, b - e, c - f]
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f32 = 0.005;
    /// °/s: as large as the MPU-9250's specification allows.
    const BIAS: [f32; 3] = [-3.0, 2.0, 5.0];

    /// A robot whose sensor has a bias and noise of 0.1 °/s.
    struct Robot {
        tracker: Tracker,
        random: u32,
    }

    impl Robot {
        fn new() -> Self {
            Self { tracker: Tracker::new(), random: 1 }
        }

        /// Uniform in ±1.
        fn noise(&mut self) -> f32 {
            self.random = self.random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from((self.random >> 16) as u16) / 32_767.5 - 1.0
        }

        /// Turns at °/s for so long, inclined to the front by so many degrees.
        fn turn(&mut self, degrees_s: f32, seconds: f32, is_standing: bool) {
            for _ in 0..(seconds / PERIOD_S).round() as u32 {
                let mut rates = BIAS.map(|bias| bias + 0.17 * self.noise());
                rates[2] += degrees_s;
                let motion = Motion {
                    angular_velocity: rates.map(f32::to_radians),
                    acceleration: [0.0, 0.0, 9.81].map(|axis| axis + 0.03 * self.noise()),
                };
                self.tracker.feel(motion, PERIOD_S, is_standing);
            }
        }

        /// Degrees.
        fn yaw(&self) -> f32 {
            let [w, x, y, z] = self.tracker.quaternion();
            assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-5);
            (2.0 * z.atan2(w)).to_degrees()
        }
    }

    #[test]
    fn a_quarter_turn_ends_within_a_degree_and_stays() {
        let mut robot = Robot::new();
        robot.turn(0.0, 3.0, true);
        assert!(!robot.tracker.is_calibrating());
        for (bias, expected) in robot.tracker.bias().unwrap().into_iter().zip(BIAS) {
            assert!((bias.to_degrees() - expected).abs() < 0.02, "{bias} {expected}");
        }
        let before = robot.yaw();
        robot.turn(45.0, 2.0, false);
        assert!((robot.yaw() - before - 90.0).abs() < 1.0, "{}", robot.yaw() - before);
        robot.turn(0.0, 60.0, true);
        assert!((robot.yaw() - before - 90.0).abs() < 1.0, "{}", robot.yaw() - before);
        // Slowly and evenly, which at rest would be bias: 1 °/s for a minute.
        robot.turn(1.0, 60.0, false);
        assert!((robot.yaw() - before - 150.0).abs() < 1.5, "{}", robot.yaw() - before);
    }

    /// Until it has stood still the wheels tell; then it goes on from there, and back.
    #[test]
    fn yaw_goes_on_from_source_to_source() {
        let mut robot = Robot::new();
        let heading = |degrees: f32| {
            let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
            [cos, 0.0, 0.0, sin]
        };
        robot.turn(20.0, 3.0, false);
        robot.tracker.roll(heading(40.0));
        assert!((robot.yaw() - 40.0).abs() < 0.01 && robot.tracker.is_calibrating());
        robot.turn(0.0, 3.0, true);
        assert!((robot.yaw() - 40.0).abs() < 0.1, "{}", robot.yaw());
        robot.turn(30.0, 1.0, false);
        assert!((robot.yaw() - 70.0).abs() < 0.3, "{}", robot.yaw());
        robot.tracker.lose();
        robot.tracker.roll(heading(-100.0));
        assert!((robot.yaw() - 70.0).abs() < 0.3, "{}", robot.yaw());
        robot.tracker.roll(heading(-90.0));
        assert!((robot.yaw() - 80.0).abs() < 0.3, "{}", robot.yaw());
        robot.turn(30.0, 1.0, false);
        assert!((robot.yaw() - 110.0).abs() < 0.5, "{}", robot.yaw());
    }

    /// Asked for while it turns, it waits; what was known counts until it is done.
    #[test]
    fn a_calibration_waits_for_standstill() {
        let mut robot = Robot::new();
        robot.turn(0.0, 3.0, true);
        let known = robot.tracker.bias();
        robot.tracker.calibrate();
        robot.turn(45.0, 2.0, false);
        assert!(robot.tracker.is_calibrating() && robot.tracker.bias() == known);
        // Pushed while the wheels stand.
        robot.turn(0.0, 2.0, true);
        robot.turn(5.0, 1.0, true);
        assert!(robot.tracker.is_calibrating());
        robot.turn(0.0, 3.0, true);
        assert!(!robot.tracker.is_calibrating());
    }

    /// Nose down by 10 degrees: a rotation about the left axis.
    #[test]
    fn gravity_tells_the_inclination() {
        let mut robot = Robot::new();
        robot.turn(0.0, 3.0, true);
        let (sin, cos) = 10.0_f32.to_radians().sin_cos();
        for _ in 0..6000 {
            let rates = BIAS.map(|bias| (bias + 0.17 * robot.noise()).to_radians());
            let motion = Motion { angular_velocity: rates, acceleration: [-9.81 * sin, 0.0, 9.81 * cos] };
            robot.tracker.feel(motion, PERIOD_S, true);
        }
        let [w, x, y, _] = robot.tracker.quaternion();
        assert!(
            (2.0 * y.atan2(w).to_degrees() - 10.0).abs() < 0.5 && x.abs() < 0.01,
            "{:?}",
            robot.tracker.quaternion()
        );
        // What is no number changes nothing for good.
        let spoiled = Motion { angular_velocity: [f32::NAN; 3], acceleration: [0.0; 3] };
        robot.tracker.feel(spoiled, PERIOD_S, true);
        assert!(robot.tracker.quaternion().iter().all(|component| component.is_finite()));
    }
}
