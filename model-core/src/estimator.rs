//! The one pipeline that board and host run: sample → filter → motion → model → payload → estimate.

use crate::clamp::ClampMemory;
use crate::coefficients::Coefficients;
pub use crate::conditioner::{Conditioned, Conditioner, GAP_PERIODS, Unfit};
use crate::effects::live::{Additions, Answer, Outside};
use crate::energy::Energy;
use crate::model::{MassRange, Model};
use crate::payload::change::{Cusum, Threshold};
use crate::payload::ring::Ring;
use crate::payload::schedule::{Schedule, Timeline};
use crate::payload::spread::Spread;
use crate::payload::{Bucket, MassEstimate, Method, Unknown, total};
use crate::real::Real;
pub use crate::sample::Sample;

/// How often the first buckets are dropped: those summed without a mass, and those weighed by the
/// mass that squares gave. Chosen: with one, a first mass that is 25 % off still leaves 0.35 % of
/// error after four seconds, with two 0.002 %.
const DROPS: u8 = 2;

/// What is known after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate<T, const N: usize> {
    /// The sample after the filter; `None` where it was not finite.
    pub conditioned: Option<Conditioned<T, N>>,
    /// The total mass as of the last closed bucket.
    pub mass: MassEstimate<T>,
    /// P̂_act in W, step three of the paper; `None` while the mass is unknown or the filter
    /// unsettled.
    pub power: Option<T>,
    /// This sample closed a bucket, and with it a new estimate.
    pub closed: bool,
    /// The payload changed this many buckets ago: detected now.
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

/// Model, payload and energy of one robot, from its samples. `B` is the most buckets that a window
/// can have.
#[derive(Debug, Clone, Copy)]
pub struct Estimator<T, M, const N: usize, const B: usize>
where
    T: Real,
    M: Method<T>,
{
    conditioner: Conditioner<T, N>,
    model: Model<T>,
    clamp: ClampMemory<T>,
    range: MassRange<T>,
    /// Whether the coefficients distinguish masses.
    identifies_mass: bool,
    method: M,
    timeline: Timeline,
    detector: Option<Cusum<T>>,
    spread: Spread<T>,
    bucket: M::Sums,
    /// The sums of the closed buckets that the next estimate will take in, added up while there is
    /// time for it.
    ahead: Option<M::Sums>,
    /// A bucket is full this long after it was opened, half a period before its time, s.
    full_at: T,
    bucket_length: T,
    /// Time into the open bucket, s.
    phase: T,
    /// Buckets summed since the mass by which samples are weighed is known.
    since_known: usize,
    /// How often buckets from before it are still to be dropped.
    drops_left: u8,
    mass: MassEstimate<T>,
    /// The mass beyond the middle of the range, kg; no number while it is unknown.
    d: T,
    measured: Energy<T>,
    predicted: Energy<T>,
    /// The least power that counts for both, W.
    floor: T,
    /// What the samples of the bucket in hand add to both, J. So few can be summed without
    /// compensation: single precision loses some 10⁻⁶ of 200.
    bucket_measured: T,
    bucket_predicted: T,
    /// Last: what every sample asks for stands together, within reach of one register.
    buckets: Ring<M::Sums, B>,
}

impl<T: Real, M: Method<T>, const N: usize, const B: usize> Estimator<T, M, N, B> {
    /// Of coefficients; their effects are to be given with every sample ([`Self::push_with`]).
    ///
    /// # Errors
    /// A filter cutoff that this sample rate cannot have, or a delay that is too long for it.
    pub fn new(coefficients: &Coefficients<T, N>, method: M, timing: &Timing) -> Result<Self, Unfit> {
        let Coefficients { robot, columns, .. } = coefficients;
        let drops_left = if method.weighs_by_mass() { DROPS } else { 0 };
        Ok(Self {
            conditioner: Conditioner::with_columns(robot, columns, timing.period_s)?,
            model: coefficients.model,
            clamp: ClampMemory::new(robot.cutoff_hz),
            range: coefficients.robot.range,
            identifies_mass: coefficients.identifies_mass,
            method,
            timeline: Timeline::new(timing.schedule),
            detector: timing.detect_changes.then(|| Cusum::new(Threshold::default())),
            spread: Spread::default(),
            bucket: M::Sums::default(),
            buckets: Ring::default(),
            ahead: None,
            bucket_length: T::from_f64(timing.bucket_s),
            full_at: T::from_f64(timing.bucket_s - timing.period_s / 2.0),
            phase: T::ZERO,
            since_known: 0,
            drops_left,
            mass: MassEstimate::Unknown(if coefficients.identifies_mass {
                Unknown::NoSamples
            } else {
                Unknown::NotIdentifiable
            }),
            measured: Energy::default(),
            predicted: Energy::default(),
            floor: coefficients.energy_floor(),
            d: T::NAN,
            bucket_measured: T::ZERO,
            bucket_predicted: T::ZERO,
        })
    }

    /// Takes one sample, `elapsed` (s) after the one before. Time that runs backwards or is no
    /// number is a gap of unknown length: the buckets take it as none.
    #[inline(always)]
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Estimate<T, N> {
        if self.conditioner.is_straight() && sample.wheel_acceleration.is_none() {
            self.take::<_, true>(&mut (), sample, &Outside::UNKNOWN, elapsed)
        } else {
            self.push_around(sample, elapsed)
        }
    }

    #[inline(never)]
    fn push_around(&mut self, sample: &Sample<T, N>, elapsed: T) -> Estimate<T, N> {
        self.take::<_, false>(&mut (), sample, &Outside::UNKNOWN, elapsed)
    }

    /// [`Self::push`] with the coefficients' effects, [`crate::effects::live::Live`], and what is
    /// measured besides speeds and power for those that need it.
    #[inline(always)]
    pub fn push_with<E: Additions<T, N> + ?Sized>(
        &mut self,
        additions: &mut E,
        sample: &Sample<T, N>,
        outside: &Outside<T, N>,
        elapsed: T,
    ) -> Estimate<T, N> {
        self.take::<E, false>(additions, sample, outside, elapsed)
    }

    /// [`Self::push_with`]; `STRAIGHT` as [`Conditioner::condition`] has it.
    #[inline(always)]
    fn take<E: Additions<T, N> + ?Sized, const STRAIGHT: bool>(
        &mut self,
        additions: &mut E,
        sample: &Sample<T, N>,
        outside: &Outside<T, N>,
        elapsed: T,
    ) -> Estimate<T, N> {
        additions.correct(sample, outside, elapsed);
        let sample = additions.corrected(sample);
        let conditioned = self.conditioner.condition::<STRAIGHT>(sample, elapsed, additions.true_turn());
        // In this order NaN counts as none.
        let elapsed = T::ZERO.at_least(elapsed);
        let mut power = None;
        if let Some((now, held)) = &conditioned {
            self.bucket_measured += self.floor.most(now.power) * *held;
            additions.follow(&now.motion, &self.range, self.d);
        }
        if let Some((now, held)) = &conditioned
            && now.settled
        {
            let Answer { response, power: expected, drawn } =
                additions.respond(&self.model, now, &self.range, self.d);
            if response.may_clamp {
                self.clamp.clamped();
            } else if !self.clamp.remembers(elapsed) {
                self.method.add(&mut self.bucket, drawn, &response, now.motion.summed_speed(), self.d);
            }
            // Zero times what is not finite is no number; neither is what an unknown mass makes
            // expect.
            if expected * T::ZERO == T::ZERO {
                self.bucket_predicted += self.floor.most(expected) * *held;
                power = Some(expected);
            }
        }
        let conditioned = conditioned.map(|(conditioned, _)| conditioned);
        self.phase += elapsed;
        if self.is_bucket_full() {
            let changed = self.close_buckets();
            return Estimate { conditioned, mass: self.mass, power, closed: true, changed };
        }
        if self.ahead.is_none() {
            self.look_ahead();
        }
        Estimate { conditioned, mass: self.mass, power, closed: false, changed: None }
    }

    /// The payload is another from now on (Algorithm 2 with the change time known).
    pub fn payload_changed(&mut self) {
        self.restart(0);
        // Its samples so far are of the payload before.
        self.bucket = M::Sums::default();
        self.weigh_anew();
        self.learn(MassEstimate::Unknown(Unknown::NoSamples));
    }

    fn learn(&mut self, mass: MassEstimate<T>) {
        self.mass = self.identified(mass);
        self.d = self.mass.best().map_or(T::NAN, |best| best - self.range.middle());
    }

    /// The mass over exactly the latest `count` buckets, whatever the schedule; `None` while there
    /// are fewer.
    pub fn over_latest(&self, count: usize) -> Option<MassEstimate<T>> {
        (self.buckets.len() >= count && count > 0).then(|| {
            let parts = self.buckets.latest_parts(count);
            self.identified(self.method.estimate_of(&total(parts), parts, self.spread.excess()))
        })
    }

    /// An estimate by coefficients that distinguish masses.
    fn identified(&self, mass: MassEstimate<T>) -> MassEstimate<T> {
        if self.identifies_mass { mass } else { MassEstimate::Unknown(Unknown::NotIdentifiable) }
    }

    /// Actuation energy measured, and predicted while the mass was known, since the start, J: by
    /// Eq. 9, or what the battery gave less what it took where drives return power
    /// ([`Coefficients::energy_floor`]). A gap counts as one longest step: nobody measured it.
    pub fn energy(&self) -> (T, T) {
        (self.measured.joules() + self.bucket_measured, self.predicted.joules() + self.bucket_predicted)
    }

    fn is_bucket_full(&self) -> bool {
        self.phase >= self.full_at
    }

    fn restart(&mut self, ago: usize) {
        self.ahead = None;
        self.timeline.restart(ago);
        self.forget_surprises();
    }

    fn forget_surprises(&mut self) {
        self.spread.forget_last();
        if let Some(detector) = &mut self.detector {
            detector.reset();
        }
    }

    /// The bucket in hand is full.
    #[inline(always)]
    fn close_buckets(&mut self) -> Option<usize> {
        self.phase -= self.bucket_length;
        let changed = self.close_bucket();
        if self.is_bucket_full() { self.close_more().or(changed) } else { changed }
    }

    /// A gap closes empty buckets after the one in hand, so that old samples leave the window;
    /// never more of them than the ring holds.
    #[cold]
    #[inline(never)]
    fn close_more(&mut self) -> Option<usize> {
        let mut changed = None;
        for _ in 1..B {
            self.phase -= self.bucket_length;
            changed = self.close_bucket().or(changed);
            if !self.is_bucket_full() {
                return changed;
            }
        }
        // The gap outlasted the ring: nothing older is left to push out.
        self.phase = T::ZERO;
        changed
    }

    /// Work that closing a bucket leaves to the next sample, so that no sample takes much longer
    /// than the others: the sums of the energy, and of what stays in the window when the next
    /// bucket closes.
    #[inline(never)]
    fn look_ahead(&mut self) {
        self.measured.add(self.bucket_measured, T::ONE);
        self.predicted.add(self.bucket_predicted, T::ONE);
        (self.bucket_measured, self.bucket_predicted) = (T::ZERO, T::ZERO);
        let stay = self.timeline.next().map_or(0, |count| count.min(B).saturating_sub(1));
        self.ahead = Some(total(self.buckets.latest_parts(stay)));
    }

    #[inline(never)]
    fn close_bucket(&mut self) -> Option<usize> {
        let changed = self.notice_change();
        if let Some(ago) = changed {
            // The bucket in hand is counted by `advance` below.
            self.restart(ago.saturating_sub(1));
        }
        if self.timeline.schedule() == Schedule::Cumulative && self.buckets.len() == B {
            self.make_room();
        }
        if self.ahead.is_none() {
            self.look_ahead();
        }
        self.buckets.push(self.bucket);
        let again = if self.drops_left > 0 { self.weigh_again() } else { None };
        if let (Some(count), Some(total)) = (self.timeline.advance(), &mut self.ahead) {
            let mass = again.map(|(mass, _)| mass).unwrap_or_else(|| {
                total.merge(&self.bucket);
                let excess = self.spread.excess();
                self.method.estimate_of(total, self.buckets.latest_parts(count), excess)
            });
            self.learn(mass);
        }
        if let Some((_, d)) = again {
            self.d = d;
        }
        if changed.is_some() {
            // Samples since the change were weighed by their residuals at the mass before.
            self.weigh_anew();
        }
        self.ahead = None;
        self.bucket = M::Sums::default();
        changed
    }

    /// The mass by which samples are weighed is not the one of these buckets.
    fn weigh_anew(&mut self) {
        self.since_known = 0;
        self.drops_left = if self.method.weighs_by_mass() { DROPS } else { 0 };
    }

    /// Samples could not be weighed by their residuals while the mass was unknown. Such buckets are
    /// dropped once later ones determine the mass alone. The later ones were weighed by a mass of
    /// squares, and are dropped in turn.
    ///
    /// Returns what the later ones say, and the mass by which samples are weighed from now on, kg
    /// beyond the middle of the range. The two differ where the first mass was far off: then no
    /// sample lies within the noise, and the later ones give a better mass without an interval.
    #[cold]
    #[inline(never)]
    fn weigh_again(&mut self) -> Option<(MassEstimate<T>, T)> {
        if !self.d.is_finite() {
            self.since_known = 0;
            return None;
        }
        let later = self.since_known + 1;
        if later > self.timeline.next().map_or(0, |count| count.min(B).saturating_sub(1)) {
            // All in the window are later ones.
            self.drops_left = 0;
            return None;
        }
        self.since_known = later;
        let (parts, excess) = (self.buckets.latest_parts(later), self.spread.excess());
        let sums: M::Sums = total(parts);
        let MassEstimate::Known(better) = self.method.estimate_of(&sums.all_within(), parts, excess) else {
            return None;
        };
        let alone = self.method.estimate_of(&sums, parts, excess);
        self.buckets.blank_older(later);
        self.since_known = 0;
        self.drops_left = self.drops_left.saturating_sub(1);
        // Surprises so far were about the mass that goes with them.
        self.forget_surprises();
        Some((alone, better.mass - self.range.middle()))
    }

    /// For one more bucket in a full ring whose buckets all count: those before the last change go,
    /// and only where that frees none are neighbours merged.
    #[cold]
    #[inline(never)]
    fn make_room(&mut self) {
        self.ahead = None;
        self.buckets.keep_latest(self.timeline.age());
        if self.buckets.len() == B {
            self.buckets.halve(|mut earlier, later| {
                earlier.merge(&later);
                earlier
            });
            self.timeline.restart(self.buckets.len());
        }
    }

    fn notice_change(&mut self) -> Option<usize> {
        let surprise = self.method.surprise(&self.bucket, self.mass.best()?)?;
        self.spread.push(surprise);
        let detector = self.detector.as_mut().filter(|_| self.spread.is_known())?;
        detector.push(surprise / self.spread.excess().sqrt())
    }
}
