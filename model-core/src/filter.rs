//! The causal low-pass filter that speed and power both pass, with the derivative of its output.
//!
//! Fifth-order Butterworth (Section 7.1), bilinear transform with the cutoff prewarped: two
//! second-order sections and, last, one first-order section, whose input and output give the
//! derivative for one subtraction.

use crate::real::Real;

/// A cutoff that this sample rate cannot have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvalidCutoff {
    /// What was asked for, Hz.
    pub cutoff_hz: f64,
    /// Cutoffs have to be above 0 and below this, Hz.
    pub below_hz: f64,
}

/// One second-order section, transposed direct form II. Its numerator is (1 + z⁻¹)², which takes
/// sums only: the gain that lets a constant pass unchanged is the business of [`LowPass`], once for
/// all sections.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Section<T> {
    a1: T,
    a2: T,
}

impl<T: Real> Section<T> {
    /// Butterworth section of quality `q` at tan(π f / f_s) = `k`, and the gain that lets a
    /// constant pass it unchanged.
    fn new(k: f64, q: f64) -> (Self, T) {
        let norm = 1.0 / (1.0 + k / q + k * k);
        let a1 = T::from_f64(2.0 * (k * k - 1.0) * norm);
        let a2 = T::from_f64((1.0 - k / q + k * k) * norm);
        // From the rounded denominator, so that a constant passes unchanged in single precision as
        // well.
        let gain = T::from_f64((1.0 + a1.to_f64() + a2.to_f64()) / 4.0);
        (Self { a1, a2 }, gain)
    }

    #[inline]
    fn step(&self, state: &mut [T; 2], input: T) -> T {
        let [s1, s2] = *state;
        let output = input + s1;
        *state = [input + input + s2 - self.a1 * output, input - self.a2 * output];
        output
    }

    /// As if `input` had come for ever, `gain` being the section's; the output that is then.
    fn settle(&self, gain: T, state: &mut [T; 2], input: T) -> T {
        let output = input / gain;
        *state = [output - input, input - self.a2 * output];
        output
    }
}

/// The filter's coefficients; the state of each signal is a [`Channel`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass<T> {
    steps: Steps<T>,
    /// Of each section, and of the last, where a constant passes it unchanged.
    section_gains: [T; 2],
    last_gain: T,
    settling_samples: u32,
}

/// What every step takes of the coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps<T> {
    sections: [Section<T>; 2],
    /// Of the first-order section after them.
    a1: T,
    /// Of all sections together: what a sample is multiplied by as it comes in.
    gain: T,
    /// Factor of the derivative, for the change of the last section's state, 1/s.
    rate: T,
}

/// State of one filtered signal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Channel<T> {
    sections: [[T; 2]; 2],
    last: T,
}

impl<T: Real> Channel<T> {
    /// Nothing came yet.
    pub(crate) const NOTHING: Self = Self { sections: [[T::ZERO; 2]; 2], last: T::ZERO };
}

/// One number of each channel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
struct Each<T, const N: usize> {
    speeds: [T; N],
    power: T,
}

/// The channels of a robot's wheels and of its power, read and written at once ([`crate::block`]).
///
/// Their order is that in which a step lets go of them: what a number of one row becomes may take
/// the register of the next row, so that the step moves none.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Channels<T, const N: usize> {
    last: Each<T, N>,
    second: [Each<T, N>; 2],
    first: [Each<T, N>; 2],
}

impl<T: Real, const N: usize> Channels<T, N> {
    /// Nothing came yet.
    pub(crate) const NOTHING: Self = {
        let nothing = Each { speeds: [T::ZERO; N], power: T::ZERO };
        Self { last: nothing, second: [nothing; 2], first: [nothing; 2] }
    };

    /// What `take` makes of each channel and its input: of the wheels, and of the power.
    #[inline(always)]
    pub(crate) fn each<R: Copy + Default>(
        &mut self,
        speeds: &[T; N],
        power: T,
        take: impl Fn(&mut Channel<T>, T) -> R,
    ) -> ([R; N], R) {
        let Self { last, second: [c, d], first: [a, b] } = self;
        let take = |[a, b, c, d, last]: [&mut T; 5], input: T| {
            let mut channel = Channel { sections: [[*a, *b], [*c, *d]], last: *last };
            let taken = take(&mut channel, input);
            [[*a, *b], [*c, *d]] = channel.sections;
            *last = channel.last;
            taken
        };
        let of_power = take([&mut a.power, &mut b.power, &mut c.power, &mut d.power, &mut last.power], power);
        let mut of_speeds = [R::default(); N];
        let first = a.speeds.iter_mut().zip(&mut b.speeds);
        let second = c.speeds.iter_mut().zip(&mut d.speeds);
        let states = first.zip(second).zip(&mut last.speeds);
        for ((of_speed, (((a, b), (c, d)), last)), input) in of_speeds.iter_mut().zip(states).zip(speeds) {
            *of_speed = take([a, b, c, d, last], *input);
        }
        (of_speeds, of_power)
    }
}

/// A filtered value and its derivative.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Filtered<T> {
    /// In the unit of the input.
    pub value: T,
    /// In the unit of the input per second.
    pub derivative: T,
}

/// Section qualities of a fifth-order Butterworth filter: 1 / (2 cos 36°) and 1 / (2 cos 72°).
const QUALITY: [f64; 2] = [0.618_033_988_749_895, 1.618_033_988_749_895];

impl<T: Real> LowPass<T> {
    /// For a cutoff (−3 dB) in Hz and a sample period in s.
    ///
    /// # Errors
    /// A cutoff outside 0 … 0.45 of the sample rate, or a period that is not positive.
    #[inline(never)]
    pub fn new(cutoff_hz: f64, period_s: f64) -> Result<Self, InvalidCutoff> {
        let below_hz = if period_s > 0.0 && period_s.is_finite() { 0.45 / period_s } else { 0.0 };
        if !(cutoff_hz > 0.0 && cutoff_hz < below_hz) {
            return Err(InvalidCutoff { cutoff_hz, below_hz });
        }
        let k = libm::tan(core::f64::consts::PI * cutoff_hz * period_s);
        let [q1, q2] = QUALITY;
        let a1 = T::from_f64((k - 1.0) / (k + 1.0));
        let last_gain = (1.0 + a1.to_f64()) / 2.0;
        let [(first, first_gain), (second, second_gain)] = [Section::<T>::new(k, q1), Section::new(k, q2)];
        let sections_gain = first_gain.to_f64() * second_gain.to_f64();
        let steps = Steps {
            sections: [first, second],
            a1,
            gain: T::from_f64(sections_gain * last_gain),
            // Tustin: D H = (2 k / T) (1 − H) for H = k (1 + z⁻¹) / ((k + 1) + (k − 1) z⁻¹) = g
            // (1 + z⁻¹) / (1 + a1 z⁻¹). With y the output of an input x / g, D y = (2 k / T) (x − g
            // y) / g, and with g = (1 + a1) / 2 that difference is half of (x − a1 y) − (y − x): of
            // the section's state after the sample and before it.
            rate: T::from_f64(k / period_s / last_gain),
        };
        Ok(Self {
            steps,
            section_gains: [first_gain, second_gain],
            last_gain: T::from_f64(last_gain),
            settling_samples: libm::ceil(2.0 / (cutoff_hz * period_s)) as u32,
        })
    }

    /// Samples after which the response to the past before the first sample has died away: two
    /// periods of the cutoff, where a step is within 2 % of its end for good.
    pub fn settling_samples(&self) -> u32 {
        self.settling_samples
    }

    /// Sets a channel as if `level` had been its input for ever.
    pub fn settle(&self, channel: &mut Channel<T>, level: T) {
        let mut x = self.steps.gain * level;
        let sections = self.steps.sections.iter().zip(&self.section_gains);
        for ((section, gain), state) in sections.zip(&mut channel.sections) {
            x = section.settle(*gain, state, x);
        }
        channel.last = x / self.last_gain - x;
    }

    /// Filters one sample.
    #[inline]
    pub fn step(&self, channel: &mut Channel<T>, input: T) -> Filtered<T> {
        self.steps.step(channel, input)
    }

    /// What every step of this filter takes.
    #[inline]
    pub(crate) fn steps(&self) -> &Steps<T> {
        &self.steps
    }
}

impl<T: Real> Steps<T> {
    /// Filters one sample.
    #[inline]
    pub(crate) fn step(&self, channel: &mut Channel<T>, input: T) -> Filtered<T> {
        let mut x = self.gain * input;
        for (section, state) in self.sections.iter().zip(&mut channel.sections) {
            x = section.step(state, x);
        }
        let before = channel.last;
        let value = x + before;
        channel.last = x - self.a1 * value;
        Filtered { value, derivative: self.rate * (channel.last - before) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, LowPass};

    #[test]
    fn rejects_cutoffs_beyond_the_sample_rate() {
        assert!(LowPass::<f64>::new(2.0, 0.005).is_ok());
        for (cutoff, period) in
            [(0.0, 0.01), (-1.0, 0.01), (45.0, 0.01), (f64::NAN, 0.01), (1.0, 0.0), (1.0, -1.0)]
        {
            assert!(LowPass::<f64>::new(cutoff, period).is_err(), "{cutoff} {period}");
        }
    }

    /// A constant stays itself: the gain is derived from the rounded denominator, so what is left
    /// in single precision is rounding of some ten operations on states up to 1 / k² ≈ 10³ times
    /// smaller than their sum.
    #[test]
    fn constant_passes_unchanged() {
        let filter = LowPass::<f32>::new(2.0, 0.005).unwrap();
        let mut channel = Channel::default();
        filter.settle(&mut channel, 3.7);
        for _ in 0..10_000 {
            let out = filter.step(&mut channel, 3.7);
            assert!((out.value - 3.7).abs() < 4e-3 * 3.7 * 1e-1, "{out:?}");
            assert!(out.derivative.abs() < 2e-2, "{out:?}");
        }
    }

    /// The derivative of a ramp is its slope, its value lags by the group delay 3.236 / (2π f_c).
    #[test]
    fn ramp_gives_its_slope() {
        let (cutoff, period) = (2.0, 0.005);
        let filter = LowPass::<f64>::new(cutoff, period).unwrap();
        let mut channel = Channel::default();
        let mut out = Default::default();
        let steps = 2000;
        for i in 0..=steps {
            out = filter.step(&mut channel, 0.3 * f64::from(i) * period);
        }
        assert!((out.derivative - 0.3).abs() < 1e-9);
        let k = (std::f64::consts::PI * cutoff * period).tan();
        let delay = (1.0 + 1.0 / 0.618_033_988_749_895 + 1.0 / 1.618_033_988_749_895) * period / (2.0 * k);
        let expected = 0.3 * (f64::from(steps) * period - delay);
        assert!((out.value - expected).abs() < 1e-9, "{} {expected}", out.value);
    }

    /// Half a power at the cutoff, a fifth-order roll-off beyond.
    #[test]
    fn butterworth_magnitude() {
        let (cutoff, period) = (5.0, 0.002);
        for (frequency, expected) in [(5.0, 0.5_f64.sqrt()), (1.0, 1.0), (20.0, 9.6e-4)] {
            let filter = LowPass::<f64>::new(cutoff, period).unwrap();
            let mut channel = Channel::default();
            let mut peak = 0.0_f64;
            for i in 0..20_000 {
                let phase = 2.0 * std::f64::consts::PI * frequency * f64::from(i) * period;
                let out = filter.step(&mut channel, phase.sin());
                if i > 15_000 {
                    peak = peak.max(out.value.abs());
                }
            }
            assert!((peak / expected - 1.0).abs() < 0.02, "{frequency}: {peak} {expected}");
        }
    }
}
