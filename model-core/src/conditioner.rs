//! From samples to motion: the delay is taken out, speed and power pass one filter, slip builds up.

use crate::coefficients::Robot;
use crate::delay::DelayLine;
use crate::effects::Columns;
use crate::filter::{Channel, Channels, InvalidCutoff, LowPass};
use crate::kinematics::MassMatrix;
use crate::motion::Motion;
use crate::real::Real;
use crate::sample::Sample;
use crate::slip::{Slip, SlipMemory, TrueTurn};

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

/// Why coefficients cannot run at a sample rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unfit {
    /// The filter's cutoff is none at this sample rate.
    Cutoff(InvalidCutoff),
    /// Effects act on the torques of the signed model: this one has none.
    Model,
    /// A delay that the samples kept do not reach.
    Delay,
    /// True slip of a robot that has no two sides.
    Sides,
}

/// Filters speed and power alike (Section 7.1) and forms the wheels' motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditioner<T, const N: usize> {
    filter: LowPass<T>,
    mass_matrix: MassMatrix<T, N>,
    dead_band: T,
    /// Longer steps between samples are gaps, s.
    longest_step: T,
    channels: Channels<T, N>,
    accelerations: [Channel<T>; N],
    memory: SlipMemory<T>,
    /// A difference of the sides within this is hardly a turn, rad/s.
    rest: T,
    slip: Slip<T>,
    /// Nothing is late and no wheel scrubs, as of most robots: chosen at set-up, not at every
    /// sample.
    is_straight: bool,
    /// Samples until the filter has settled.
    unsettled: u32,
    /// Since the last finite sample, s; for ever where there was none.
    waited: T,
    /// Steps up to this one follow the sample before, s: the longest step; none do while `waited`
    /// has to be asked.
    follows_within: T,
    /// Last: what every sample asks for stands together.
    line: DelayLine<T, N>,
}

/// Steps longer than this many sample periods are gaps: the filter starts anew after them.
pub const GAP_PERIODS: f64 = 5.0;

impl<T: Real, const N: usize> Conditioner<T, N> {
    /// For samples `period_s` apart of this robot.
    ///
    /// # Errors
    /// A filter cutoff that this sample rate cannot have, or a delay that is too long for it.
    pub fn new(robot: &Robot<T, N>, period_s: f64) -> Result<Self, Unfit> {
        Self::with_columns(robot, &Columns::NONE, period_s)
    }

    /// The same with what effects change of the delay and of the slip memory.
    // Set up once: inlined into every estimator of a board it takes six kilobytes of its flash.
    #[inline(never)]
    pub(crate) fn with_columns(
        robot: &Robot<T, N>,
        columns: &Columns<T>,
        period_s: f64,
    ) -> Result<Self, Unfit> {
        let delay = robot.conditioning.delay + columns.delay();
        let longest_step = T::from_f64(GAP_PERIODS * period_s);
        let line = DelayLine::new(delay, period_s, longest_step).ok_or(Unfit::Delay)?;
        let memory = columns.softened(&robot.conditioning.slip);
        let has_memory = robot.mass_matrix.sides().is_some() && !memory.is_off();
        Ok(Self {
            is_straight: line.is_off() && !has_memory && !robot.mass_matrix.scrubs(),
            line,
            filter: LowPass::new(robot.cutoff_hz.to_f64(), period_s).map_err(Unfit::Cutoff)?,
            mass_matrix: robot.mass_matrix,
            dead_band: robot.dead_band,
            longest_step,
            channels: Channels::NOTHING,
            accelerations: [Channel::NOTHING; N],
            rest: memory.rest_of(robot.dead_band),
            memory,
            slip: Slip::default(),
            unsettled: 0,
            waited: T::INFINITY,
            follows_within: -T::ONE,
        })
    }

    /// Takes one sample, `elapsed` (s) after the one before. `None` where it holds a value that is
    /// not finite: the filter then stays as it was. Time that runs backwards or is no number is a
    /// gap.
    #[inline]
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Option<Conditioned<T, N>> {
        self.condition::<false>(sample, elapsed, None).map(|(conditioned, _)| conditioned)
    }

    /// Whether nothing is late and no wheel scrubs.
    #[inline]
    pub(crate) fn is_straight(&self) -> bool {
        self.is_straight
    }

    /// [`Self::push`], and how long the sample stands for, s: the time since the one before, but at
    /// most a longest step after a gap, which nobody measured. With a gyro's reading of the same
    /// instant, true slip adds to the scrub. `STRAIGHT` leaves out what is not needed where
    /// [`Self::is_straight`] holds and there is no gyro.
    #[inline(always)]
    pub(crate) fn condition<const STRAIGHT: bool>(
        &mut self,
        sample: &Sample<T, N>,
        elapsed: T,
        turn: Option<&TrueTurn<T>>,
    ) -> Option<(Conditioned<T, N>, T)> {
        let aligned;
        let sample = if STRAIGHT || self.line.is_off() {
            sample
        } else {
            aligned = self.line.push(sample, elapsed);
            &aligned
        };
        let zero = if STRAIGHT { sample.zero_if_readings_finite() } else { sample.zero_if_finite() };
        let mut since = elapsed;
        // One comparison for two questions: it also fails where a value is not finite.
        let follows = elapsed >= T::ZERO && elapsed + zero <= self.follows_within;
        if !follows {
            self.waited += elapsed;
            self.follows_within = -T::ONE;
            if zero != T::ZERO {
                return None;
            }
            let is_gap = !(elapsed >= T::ZERO && self.waited <= self.longest_step);
            if is_gap {
                self.settle(sample);
            }
            since = if is_gap { T::NAN } else { self.waited };
            self.waited = T::ZERO;
            self.follows_within = self.longest_step;
        }
        let settled = self.unsettled == 0;
        if !settled {
            self.unsettled -= 1;
        }
        let (steps, mut channels) = (T::read(self.filter.steps()), T::read(&self.channels));
        let (filtered, power) =
            channels.each(&sample.wheel_speed, sample.power, |channel, input| steps.step(channel, input));
        T::write(&mut self.channels, channels);
        let speed = filtered.map(|filtered| filtered.value);
        let mut acceleration = filtered.map(|filtered| filtered.derivative);
        if let Some(measured) = &sample.wheel_acceleration
            && !STRAIGHT
        {
            for ((channel, input), value) in
                self.accelerations.iter_mut().zip(measured).zip(&mut acceleration)
            {
                *value = self.filter.step(channel, *input).value;
            }
        }
        let mut motion = if STRAIGHT {
            Motion::with_scrub(&speed, &acceleration, &[T::ZERO; N], &self.mass_matrix, self.dead_band)
        } else {
            self.motion(&speed, &acceleration, since)
        };
        if let (Some(turn), Some(sides)) = (turn, self.mass_matrix.sides()) {
            motion.add_scrub(&sides.scrub(turn.share(sides.rims(&speed, self.dead_band).difference)));
        }
        let conditioned = Conditioned { motion, power: power.value, settled };
        // Of steps that follow, none is longer.
        Some((conditioned, T::ZERO.at_least(elapsed).least(self.longest_step)))
    }

    /// The wheels at speeds (rad/s) and accelerations (rad/s²) that have no noise, as a plan has
    /// them: past the filter, `since` s after those before.
    pub fn planned(&mut self, speed: &[T; N], acceleration: &[T; N], since: T) -> Motion<T, N> {
        self.motion(speed, acceleration, since)
    }

    /// The wheels at these filtered speeds, `since` s after the sample before; NaN after a gap.
    #[inline(always)]
    fn motion(&mut self, speed: &[T; N], acceleration: &[T; N], since: T) -> Motion<T, N> {
        match self.mass_matrix.sides() {
            Some(sides) if !self.memory.is_off() => {
                let rims = sides.rims(speed, self.rest);
                let slip = if since >= T::ZERO {
                    self.memory.step(&mut self.slip, &rims, since)
                } else {
                    self.memory.settle(&mut self.slip, &rims)
                };
                let scrub = sides.scrub(slip);
                Motion::with_scrub(speed, acceleration, &scrub, &self.mass_matrix, self.dead_band)
            }
            _ => Motion::new(speed, acceleration, &self.mass_matrix, self.dead_band),
        }
    }

    #[cold]
    fn settle(&mut self, sample: &Sample<T, N>) {
        self.unsettled = self.filter.settling_samples();
        self.channels.each(&sample.wheel_speed, sample.power, |channel, level| {
            self.filter.settle(channel, level);
        });
        if let Some(measured) = &sample.wheel_acceleration {
            for (channel, level) in self.accelerations.iter_mut().zip(measured) {
                self.filter.settle(channel, *level);
            }
        }
    }
}
