//! Samples some time ago: a late signal is aligned with the early one.

use crate::real::Real;
use crate::sample::Sample;

/// Samples that are kept. At the board's 200 Hz they reach back half a second, at 20 Hz five: on
/// the board they cost 1.7 KB.
pub const FRAMES: usize = 104;

/// Samples beyond the delay that interpolation and jitter take.
const SPARE: f64 = 3.0;

/// Lagrange's cubic through values at −1, 0, 1 and 2. Straight lines would smooth a signal more the
/// farther from a sample.
#[inline]
pub fn cubic<T: Real>([a, b, c, d]: [T; 4], x: T) -> T {
    let (below, above, far) = (x + T::ONE, x - T::ONE, x - T::TWO);
    let sixth = T::from_f64(1.0 / 6.0);
    -a * x * above * far * sixth + b * below * above * far * T::HALF - c * below * x * far * T::HALF
        + d * below * x * above * sixth
}

/// What is kept of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Frame<T, const N: usize> {
    wheel_speed: [T; N],
    power: T,
    /// Since the frame before, s.
    step: T,
}

impl<T: Real, const N: usize> Frame<T, N> {
    const NOTHING: Self = Self { wheel_speed: [T::ZERO; N], power: T::ZERO, step: T::ZERO };
}

/// The latest samples, and how long each came after the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayLine<T, const N: usize> {
    /// By how much the power is later than the speed, s; negative: earlier.
    delay: T,
    /// Longer steps are gaps, s.
    longest_step: T,
    frames: [Frame<T, N>; FRAMES],
    newest: usize,
    filled: usize,
    /// Since the newest frame, s.
    since: T,
    /// The last frame that is later than the time asked for, counted back from the newest, and how
    /// long it was before that, s.
    later: usize,
    behind: T,
}

impl<T: Real, const N: usize> DelayLine<T, N> {
    /// For samples `period_s` apart, steps beyond `longest_step` being gaps. `None` for a delay
    /// that the line does not reach.
    pub fn new(delay: T, period_s: f64, longest_step: T) -> Option<Self> {
        Self::reaches(delay, period_s).then_some(Self {
            delay,
            longest_step,
            frames: [Frame::NOTHING; FRAMES],
            newest: 0,
            filled: 0,
            since: T::ZERO,
            later: 0,
            behind: T::ZERO,
        })
    }

    /// Whether a line of samples `period_s` apart reaches back so far.
    pub fn reaches(delay: T, period_s: f64) -> bool {
        // False for what is no number.
        delay.abs().to_f64() <= (FRAMES as f64 - SPARE) * period_s
    }

    /// Nothing is late.
    #[inline]
    pub fn is_off(&self) -> bool {
        self.delay == T::ZERO
    }

    /// Takes a sample, `elapsed` (s) after the one before, and gives it with the speeds of the time
    /// that its power is from, their accelerations being left to their derivative: or its speeds
    /// with the power of theirs. What was before the first sample and before a gap is taken as it
    /// was then. What is not finite is given back as it came, and leaves no trace but its time.
    // Once a sample, and only where something is late: a function of its own, for the board's
    // flash.
    #[inline(never)]
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Sample<T, N> {
        if self.is_off() {
            return *sample;
        }
        self.since += elapsed;
        if !sample.is_finite() {
            return *sample;
        }
        let follows = self.since >= T::ZERO && self.since <= self.longest_step;
        if follows {
            self.filled = (self.filled + 1).min(FRAMES);
            self.later += 1;
            self.behind += self.since;
        } else {
            (self.filled, self.later, self.behind) = (1, 0, T::ZERO);
        }
        self.newest = if self.newest + 1 < FRAMES { self.newest + 1 } else { 0 };
        if let Some(frame) = self.frames.get_mut(self.newest) {
            let Sample { wheel_speed, power, .. } = *sample;
            *frame = Frame { wheel_speed, power, step: self.since };
        }
        self.since = T::ZERO;
        let then = self.ago(self.delay.abs());
        if self.delay > T::ZERO {
            Sample { wheel_speed: then.wheel_speed, wheel_acceleration: None, power: sample.power }
        } else {
            Sample { power: then.power, ..*sample }
        }
    }

    /// The frame so many before the newest; the oldest where there is none.
    fn frame(&self, back: usize) -> Frame<T, N> {
        let back = back.min(self.filled.saturating_sub(1));
        let place = if back <= self.newest { self.newest - back } else { self.newest + FRAMES - back };
        self.frames.get(place).copied().unwrap_or(Frame::NOTHING)
    }

    /// What was `ago` s before the newest, the same at every call.
    fn ago(&mut self, ago: T) -> Frame<T, N> {
        // One frame came, so mostly one step brings the frame in question up to the time asked for.
        while self.later > 0 && self.behind >= ago {
            self.later -= 1;
            self.behind -= self.frame(self.later).step;
        }
        if self.later >= self.filled {
            // Steps were so short that the ring has let go of it.
            self.later -= 1;
            self.behind -= self.frame(self.later).step;
        }
        let later = self.frame(self.later);
        if self.later + 1 >= self.filled {
            return later;
        }
        let x = if later.step > T::ZERO { T::ONE - (ago - self.behind) / later.step } else { T::ONE };
        let around = [
            self.frame(self.later + 2),
            self.frame(self.later + 1),
            later,
            self.frame(self.later.saturating_sub(1)),
        ];
        between(&around, x)
    }
}

/// Between the second and the third of four frames in a row.
fn between<T: Real, const N: usize>(around: &[Frame<T, N>; 4], x: T) -> Frame<T, N> {
    let [a, b, c, d] = around;
    let mut wheel_speed = [T::ZERO; N];
    let wheels = a.wheel_speed.iter().zip(&b.wheel_speed).zip(&c.wheel_speed).zip(&d.wheel_speed);
    for (speed, (((a, b), c), d)) in wheel_speed.iter_mut().zip(wheels) {
        *speed = cubic([*a, *b, *c, *d], x);
    }
    Frame { wheel_speed, power: cubic([a.power, b.power, c.power, d.power], x), step: c.step }
}

#[cfg(test)]
mod tests {
    use super::{DelayLine, FRAMES};
    use crate::sample::Sample;

    const PERIOD: f64 = 0.005;

    fn wave(t: f64) -> f64 {
        (4.0 * t).sin()
    }

    fn sample(t: f64) -> Sample<f64, 1> {
        Sample { wheel_speed: [wave(t)], wheel_acceleration: Some([2.0 * wave(t)]), power: 10.0 * wave(t) }
    }

    /// A cubic leaves (3/128) h⁴ f'''' of a sine: 4 × 10⁻⁹ at 4 rad/s and 5 ms; steps that jitter
    /// by a tenth leave more.
    #[test]
    fn the_delay_aligns_power_and_speeds() {
        for (delay, jitter, tolerance) in [(0.0237, 0.0, 1e-8), (-0.0837, 0.0, 1e-8), (0.25, 0.0005, 1e-4)] {
            let mut line = DelayLine::new(delay, PERIOD, 5.0 * PERIOD).unwrap();
            let mut time = 0.0;
            for i in 0..2000 {
                let step = if i == 0 { 0.0 } else { PERIOD + if i % 2 == 0 { jitter } else { -jitter } };
                time += step;
                let out = line.push(&sample(time), step);
                if i < 200 {
                    continue;
                }
                let (speed, power) = if delay > 0.0 { (time - delay, time) } else { (time, time + delay) };
                assert!((out.wheel_speed[0] - wave(speed)).abs() < tolerance, "{delay} {i}");
                assert_eq!(out.wheel_acceleration.is_none(), delay > 0.0);
                assert!((out.power - 10.0 * wave(power)).abs() < 10.0 * tolerance, "{delay} {i}");
            }
        }
    }

    /// After a gap, and before the first sample, everything was as it is.
    #[test]
    fn starts_and_gaps_hold_what_there_is() {
        let mut line = DelayLine::new(0.05, PERIOD, 5.0 * PERIOD).unwrap();
        let alone = |t| Sample { wheel_acceleration: None, ..sample(t) };
        assert_eq!(line.push(&sample(0.3), 0.0), alone(0.3));
        for i in 1..50 {
            line.push(&sample(0.3 + 0.005 * f64::from(i)), PERIOD);
        }
        assert_ne!(line.push(&sample(9.0), PERIOD).wheel_speed, sample(9.0).wheel_speed);
        let broken = Sample { power: f64::NAN, ..sample(9.0) };
        assert!(line.push(&broken, PERIOD).power.is_nan());
        assert_eq!(line.push(&sample(9.1), 0.1), alone(9.1));
    }

    #[test]
    fn refuses_what_it_does_not_reach() {
        let longest = (FRAMES - 3) as f64 * PERIOD;
        assert!(DelayLine::<f64, 1>::new(-longest, PERIOD, 0.025).is_some());
        for delay in [longest + 1e-9, f64::NAN, f64::INFINITY] {
            assert!(DelayLine::<f64, 1>::new(delay, PERIOD, 0.025).is_none(), "{delay}");
        }
    }
}
