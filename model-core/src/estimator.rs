//! The one pipeline that board and host run: sample → filter → motion → model → payload → estimate.

use crate::coefficients::{Coefficients, Robot};
use crate::energy::Energy;
use crate::filter::{Channel, InvalidCutoff, LowPass};
use crate::kinematics::MassMatrix;
use crate::model::{MassRange, Model};
use crate::motion::Motion;
use crate::payload::change::{Cusum, Threshold};
use crate::payload::ring::Ring;
use crate::payload::schedule::{Schedule, Timeline};
use crate::payload::{Bucket, Method, Payload, Unknown};
use crate::real::Real;

/// One measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample<T, const N: usize> {
    /// rad/s
    pub wheel_speed: [T; N],
    /// rad/s², where it is measured; otherwise the derivative of the filtered speed is taken.
    pub wheel_acceleration: Option<[T; N]>,
    /// Actuation power, W: static power already taken off.
    pub power: T,
}

impl<T: Real, const N: usize> Sample<T, N> {
    fn is_finite(&self) -> bool {
        self.power.is_finite()
            && self.wheel_speed.iter().all(|w| w.is_finite())
            && self.wheel_acceleration.iter().flatten().all(|a| a.is_finite())
    }
}

/// A sample after the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioned<T, const N: usize> {
    /// The wheels.
    pub motion: Motion<T, N>,
    /// Filtered actuation power, W.
    pub power: T,
    /// The filter has forgotten what was before the first sample or the last gap.
    pub settled: bool,
}

/// Filters speed and power alike (Section 7.1) and forms the wheels' motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioner<T, const N: usize> {
    filter: LowPass<T>,
    mass_matrix: MassMatrix<T, N>,
    dead_band: T,
    /// Longer steps between samples are gaps, s.
    longest_step: T,
    speeds: [Channel<T>; N],
    accelerations: [Channel<T>; N],
    power: Channel<T>,
    /// Samples since the start or the last gap.
    age: u32,
}

/// Steps beyond this many sample periods are gaps: the filter starts anew behind them.
const GAP_PERIODS: f64 = 5.0;

impl<T: Real, const N: usize> Conditioner<T, N> {
    /// For samples `period_s` apart of this robot.
    ///
    /// # Errors
    /// A filter cutoff that this sample rate cannot have.
    pub fn new(robot: &Robot<T, N>, period_s: f64) -> Result<Self, InvalidCutoff> {
        Ok(Self {
            filter: LowPass::new(robot.cutoff_hz.to_f64(), period_s)?,
            mass_matrix: robot.mass_matrix,
            dead_band: robot.dead_band,
            longest_step: T::from_f64(GAP_PERIODS * period_s),
            speeds: [Channel::default(); N],
            accelerations: [Channel::default(); N],
            power: Channel::default(),
            age: 0,
        })
    }

    /// Takes one sample, `elapsed` (s) after the one before. `None` where it holds a value that is not finite: the
    /// filter then stays as it was.
    #[inline]
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Option<Conditioned<T, N>> {
        if !sample.is_finite() {
            return None;
        }
        if self.age == 0 || elapsed > self.longest_step {
            self.settle(sample);
        }
        self.age = self.age.saturating_add(1);
        let power = self.filter.step(&mut self.power, sample.power).value;
        let mut speed = [T::ZERO; N];
        let mut acceleration = [T::ZERO; N];
        let outputs = speed.iter_mut().zip(&mut acceleration);
        for ((channel, input), (value, derivative)) in
            self.speeds.iter_mut().zip(&sample.wheel_speed).zip(outputs)
        {
            let filtered = self.filter.step(channel, *input);
            *value = filtered.value;
            *derivative = filtered.derivative;
        }
        if let Some(measured) = &sample.wheel_acceleration {
            for ((channel, input), value) in
                self.accelerations.iter_mut().zip(measured).zip(&mut acceleration)
            {
                *value = self.filter.step(channel, *input).value;
            }
        }
        Some(Conditioned {
            motion: Motion::new(&speed, &acceleration, &self.mass_matrix, self.dead_band),
            power,
            settled: self.age > self.filter.settling_samples(),
        })
    }

    fn settle(&mut self, sample: &Sample<T, N>) {
        self.age = 0;
        self.filter.settle(&mut self.power, sample.power);
        for (channel, level) in self.speeds.iter_mut().zip(&sample.wheel_speed) {
            self.filter.settle(channel, *level);
        }
        if let Some(measured) = &sample.wheel_acceleration {
            for (channel, level) in self.accelerations.iter_mut().zip(measured) {
                self.filter.settle(channel, *level);
            }
        }
    }
}

/// What is known after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate<T, const N: usize> {
    /// The sample behind the filter; `None` where it was not finite.
    pub conditioned: Option<Conditioned<T, N>>,
    /// The payload as of the last closed bucket.
    pub payload: Payload<T>,
    /// P̂_act in W, step three of the paper; `None` while the mass is unknown or the filter unsettled.
    pub power: Option<T>,
    /// This sample closed a bucket, and with it a new estimate.
    pub closed: bool,
    /// The payload is another since this many buckets: noticed now.
    pub changed: Option<usize>,
}

/// How the estimator divides time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Time between samples, s.
    pub period_s: f64,
    /// Length of a bucket, s.
    pub bucket_s: f64,
    /// When to estimate.
    pub schedule: Schedule,
    /// Restart the schedule when the payload seems to have changed.
    pub detect_changes: bool,
}

/// Model, payload and energy of one robot, from its samples. `B` is the most buckets that a window can have.
#[derive(Debug, Clone, Copy)]
pub struct Estimator<T, M, const N: usize, const B: usize>
where
    T: Real,
    M: Method<T>,
{
    conditioner: Conditioner<T, N>,
    model: Model<T>,
    range: MassRange<T>,
    method: M,
    timeline: Timeline,
    detector: Option<Cusum<T>>,
    bucket: M::Sums,
    buckets: Ring<M::Sums, B>,
    bucket_length: T,
    half_period: T,
    /// Time into the open bucket, s.
    phase: T,
    payload: Payload<T>,
    measured: Energy<T>,
    predicted: Energy<T>,
}

impl<T: Real, M: Method<T>, const N: usize, const B: usize> Estimator<T, M, N, B> {
    /// # Errors
    /// A filter cutoff that this sample rate cannot have.
    pub fn new(coefficients: &Coefficients<T, N>, method: M, timing: &Timing) -> Result<Self, InvalidCutoff> {
        Ok(Self {
            conditioner: Conditioner::new(&coefficients.robot, timing.period_s)?,
            model: coefficients.model,
            range: coefficients.robot.range,
            method,
            timeline: Timeline::new(timing.schedule),
            detector: timing.detect_changes.then(|| Cusum::new(Threshold::default())),
            bucket: M::Sums::default(),
            buckets: Ring::default(),
            bucket_length: T::from_f64(timing.bucket_s),
            half_period: T::from_f64(timing.period_s / 2.0),
            phase: T::ZERO,
            payload: Payload::Unknown(Unknown::NoSamples),
            measured: Energy::default(),
            predicted: Energy::default(),
        })
    }

    /// Takes one sample, `elapsed` (s) after the one before.
    #[inline]
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Estimate<T, N> {
        let conditioned = self.conditioner.push(sample, elapsed);
        let mut power = None;
        if let Some(now) = &conditioned {
            self.measured.add(now.power, elapsed.at_most(self.conditioner.longest_step));
        }
        if let Some(now) = &conditioned
            && now.settled
        {
            let response = self.model.response(&now.motion, &self.range);
            self.method.add(&mut self.bucket, now.power, &response, now.motion.mean_speed());
            power = self.payload.mass().and_then(|known| self.model.power(&now.motion, known.mass));
            self.predicted.add(power.unwrap_or(T::ZERO), elapsed);
        }
        self.phase += elapsed;
        let mut closed = false;
        let mut changed = None;
        // A gap closes empty buckets, so that old samples leave the window; never more of them than the ring holds.
        for _ in 0..B {
            if self.phase + self.half_period < self.bucket_length {
                break;
            }
            self.phase -= self.bucket_length;
            changed = self.close_bucket().or(changed);
            closed = true;
        }
        if self.phase > self.bucket_length {
            // The gap outlasted the ring: nothing older is left to push out.
            self.phase = T::ZERO;
        }
        Estimate { conditioned, payload: self.payload, power, closed, changed }
    }

    /// The payload is another from now on (Algorithm 2 with the change time known).
    pub fn payload_changed(&mut self) {
        self.restart(0);
        self.payload = Payload::Unknown(Unknown::NoSamples);
    }

    /// The mass over exactly the latest `count` buckets, whatever the schedule; `None` while there are fewer.
    pub fn over_latest(&self, count: usize) -> Option<Payload<T>> {
        (self.buckets.len() >= count && count > 0).then(|| self.method.estimate(self.buckets.latest(count)))
    }

    /// Actuation energy measured, and predicted while the mass was known, since the start (Eq. 9), J. A gap counts as one
    /// longest step: nobody measured it.
    pub fn energy(&self) -> (T, T) {
        (self.measured.joules(), self.predicted.joules())
    }

    fn restart(&mut self, ago: usize) {
        self.timeline.restart(ago);
        if let Some(detector) = &mut self.detector {
            detector.reset();
        }
    }

    #[inline(never)]
    fn close_bucket(&mut self) -> Option<usize> {
        let changed = self.notice_change();
        if let Some(ago) = changed {
            // The bucket in hand is counted by `advance` below.
            self.restart(ago.saturating_sub(1));
        }
        if self.timeline.schedule() == Schedule::Cumulative && self.buckets.len() == B {
            self.buckets.halve(|mut earlier, later| {
                earlier.merge(&later);
                earlier
            });
            self.timeline.restart(self.buckets.len());
        }
        self.buckets.push(self.bucket);
        self.bucket = M::Sums::default();
        if let Some(count) = self.timeline.advance() {
            self.payload = self.method.estimate(self.buckets.latest(count));
        }
        changed
    }

    fn notice_change(&mut self) -> Option<usize> {
        let detector = self.detector.as_mut()?;
        let mass = self.payload.mass()?.mass;
        detector.push(self.method.surprise(&self.bucket, mass)?)
    }
}
