//! What a run leaves behind as it goes: time, heading, standstill, warmth.

use crate::real::Real;

/// Time, heading and standstill since the start of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course<T> {
    /// Time in whole multiples of [`CARRY_S`], s, and the rest: single precision would soon lose
    /// steps of milliseconds.
    whole: T,
    rest: T,
    /// Since the last [`Self::see`], s.
    passed: T,
    began: bool,
    heading: [T; 2],
    still: T,
}

/// Steps are added up to this sum before they are added to the whole, s.
const CARRY_S: f64 = 16.0;

/// In a longer step, s, the turn of the robot is unknown.
const LONGEST_TURN_S: f64 = 1.0;

/// Largest angle that is turned by at once, rad: the series of its half's tangent is good to 10⁻¹⁰
/// there.
const LARGEST_ANGLE: f64 = 0.1;

/// Steps in which a larger angle is turned.
const STEPS: u8 = 32;

impl<T: Real> Default for Course<T> {
    fn default() -> Self {
        let zero = T::ZERO;
        Self {
            whole: zero,
            rest: zero,
            passed: zero,
            began: false,
            heading: [T::ONE, zero],
            still: T::INFINITY,
        }
    }
}

impl<T: Real> Course<T> {
    /// Time passes, s. Time before the first sample does not count, nor does a step of no time.
    #[inline]
    pub fn pass(&mut self, elapsed: T) {
        if !self.began {
            self.began = true;
            return;
        }
        let carry = T::from_f64(CARRY_S);
        if elapsed > carry && elapsed.is_finite() {
            self.whole += elapsed;
            self.passed += elapsed;
        } else if elapsed > T::ZERO && elapsed <= carry {
            self.rest += elapsed;
            self.passed += elapsed;
            if self.rest >= carry {
                self.rest -= carry;
                self.whole += carry;
            }
        }
    }

    /// Takes how the robot moves after the time that passed: its turn rate in rad/s, and whether
    /// any wheel turns.
    #[inline]
    pub fn see(&mut self, turn_rate: T, is_moving: bool) {
        let passed = self.passed;
        self.passed = T::ZERO;
        self.still = if is_moving { T::ZERO } else { self.still + passed };
        if turn_rate == T::ZERO || passed >= T::from_f64(LONGEST_TURN_S) {
            return;
        }
        let angle = turn_rate * passed;
        if angle.abs() <= T::from_f64(LARGEST_ANGLE) {
            self.heading = turned(self.heading, angle);
        } else {
            let step = angle / T::from_f64(f64::from(STEPS));
            for _ in 0..STEPS {
                self.heading = turned(self.heading, step);
            }
        }
    }

    /// Since the start of the run, s.
    #[inline]
    pub fn time(&self) -> T {
        self.whole + self.rest
    }

    /// Cosine and sine of the heading since the start of the run.
    #[inline]
    pub fn heading(&self) -> [T; 2] {
        self.heading
    }

    /// How long the robot has not moved, s: infinite before it first does.
    #[inline]
    pub fn still(&self) -> T {
        self.still
    }
}

/// A direction, turned by a small angle in rad: by the tangent t of its half, cos = (1 − t²) /
/// (1 + t²), sin = 2 t / (1 + t²), so that its length stays 1 whatever t.
#[inline]
fn turned<T: Real>([x, y]: [T; 2], angle: T) -> [T; 2] {
    let half = angle * T::HALF;
    let square = half * half;
    // tan x = x + x³/3 + 2 x⁵/15 + …
    let t = half * (T::ONE + square * (T::from_f64(1.0 / 3.0) + square * T::from_f64(2.0 / 15.0)));
    let length = T::ONE / (T::ONE + t * t);
    let (cos, sin) = ((T::ONE - t * t) * length, T::TWO * t * length);
    let (turned_x, turned_y) = (x * cos - y * sin, x * sin + y * cos);
    // Rounding lengthens or shortens it by 10⁻⁷ a step: one step of Newton's keeps it at 1.
    let correct = T::HALF * (T::from_f64(3.0) - (turned_x * turned_x + turned_y * turned_y));
    [turned_x * correct, turned_y * correct]
}

/// A winding's heat: what it loses, after a first-order lag, W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Heat<T> {
    level: T,
    /// What the level's last digit could not take (Kahan).
    owed: T,
}

impl<T: Real> Heat<T> {
    /// Takes the winding's loss (W) over `elapsed` (s); the lag's time constant in s.
    #[inline]
    pub fn take(&mut self, loss: T, elapsed: T, time_constant: T) {
        let x = elapsed / time_constant;
        // 1 − exp(−x), which for small x single precision would cancel.
        let share = if x < T::from_f64(0.01) {
            x * (T::ONE - x * T::HALF * (T::ONE - x / T::from_f64(3.0)))
        } else {
            T::ONE - (-x).exp()
        };
        let term = share * (loss - self.level) - self.owed;
        let level = self.level + term;
        self.owed = (level - self.level) - term;
        self.level = level;
    }

    /// W
    #[inline]
    pub fn level(&self) -> T {
        self.level
    }
}

#[cfg(test)]
mod tests {
    use super::{Course, Heat};

    /// Ten hours of 5 ms: plain single precision stops counting at 18 hours and drifts long before.
    #[test]
    fn counts_time_for_hours_in_single_precision() {
        let mut course = Course::<f32>::default();
        let step = 5243.0 / 1_048_576.0_f32;
        for _ in 0..=7_200_000 {
            course.pass(step);
        }
        let expected = 7_200_000.0 * f64::from(step);
        assert!((f64::from(course.time()) / expected - 1.0).abs() < 1e-7, "{}", course.time());
    }

    /// By sine and cosine; small steps by a thousand, and large ones.
    #[test]
    fn headings_turn() {
        for (rate, step, count) in [(0.7, 0.005, 100_000), (-2.8, 0.1, 1000), (2.0, 0.9, 200)] {
            let mut course = Course::<f64>::default();
            let mut single = Course::<f32>::default();
            for _ in 0..=count {
                course.pass(step);
                course.see(rate, true);
                single.pass(step as f32);
                single.see(rate as f32, true);
            }
            let angle = rate * step * f64::from(count);
            let [cos, sin] = course.heading();
            assert!((cos - angle.cos()).abs() < 1e-4 && (sin - angle.sin()).abs() < 1e-4, "{rate} {step}");
            let [x, y] = single.heading();
            assert!((x * x + y * y - 1.0).abs() < 1e-6, "{rate} {step}");
        }
    }

    #[test]
    fn standstill_is_infinite_until_the_first_motion() {
        let mut course = Course::<f64>::default();
        course.pass(9.0);
        course.see(0.0, false);
        assert_eq!((course.time(), course.still()), (0.0, f64::INFINITY));
        for (step, moving, still) in [(0.5, true, 0.0), (0.5, false, 0.5), (100.0, false, 100.5)] {
            course.pass(step);
            course.see(0.0, moving);
            assert_eq!(course.still(), still);
        }
        course.pass(f64::NAN);
        course.pass(-1.0);
        assert_eq!(course.time(), 101.0);
    }

    /// The step response 1 − exp(−t / T), in single precision with steps of T / 24000.
    #[test]
    fn heat_follows_its_time_constant() {
        let mut heat = Heat::<f32>::default();
        for _ in 0..24_000 {
            heat.take(2.0, 0.005, 120.0);
        }
        let expected = 2.0 * (1.0 - (-1.0_f64).exp());
        assert!((f64::from(heat.level()) / expected - 1.0).abs() < 1e-5, "{}", heat.level());
        heat.take(0.0, 120.0, 120.0);
        assert!((f64::from(heat.level()) / (expected * (-1.0_f64).exp()) - 1.0).abs() < 1e-5);
    }
}
