//! Ground that changes along the way: rolling resistance and scrub adapt slowly, beside an unknown
//! mass.
//!
//! On another floor the torque per kilogram that rolling and scrub take is another, and a mass that
//! is told by them is wrong. Inertia (and grade, where an effect has it) tell the mass whatever the
//! floor. [`Adaptive`] believes all three at once ([`belief::Belief`]): ground as what the fit
//! found plus a drift with a memory of about a minute, the mass as anything within the robot's
//! range, of which old evidence fades over the window. Where a drive cannot tell them apart, the
//! covariance says so, and with it the interval of the mass.

pub mod belief;

use crate::coefficients::Coefficients;
use crate::energy::Energy;
use crate::estimator::{Conditioned, Conditioner, Estimate, GAP_PERIODS, Sample, Unfit};
use crate::model::{MassRange, Model};
use crate::motion::Motion;
use crate::payload::spread::Spread;
use crate::payload::{Mass, MassEstimate, Noise, Unknown, huber, interval};
use crate::real::Real;
use crate::torque::{Drive, TorqueModel, WheelPower};
use belief::{Belief, Evidence, STATES};

/// How ground may differ from the fit's, and for how long what was seen counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground<T> {
    /// Standard deviation of rolling resistance and of scrub, as a share of what the fit found.
    pub share: T,
    /// How long the ground stays much the same, s.
    pub memory: T,
    /// How long the payload does, s: the window.
    pub window: T,
}

impl<T: Real> Ground<T> {
    /// Half as much again or half, within a minute; a window of 25 s.
    pub fn usual() -> Self {
        Self { share: T::HALF, memory: T::from_f64(60.0), window: T::from_f64(25.0) }
    }
}

/// What is known after a bucket.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adapted<T> {
    /// Total mass.
    pub mass: MassEstimate<T>,
    /// a1 as it seems to be now, with its standard deviation, N·m/kg.
    pub rolling: [T; 2],
    /// b as it seems to be now, with its standard deviation, N·m/kg.
    pub scrub: [T; 2],
}

/// Residuals beyond so many standard deviations of the fit's noise count linearly. Chosen: more
/// than in a window of the mass. Another floor moves all residuals, and has to be followed.
const HUBER: f64 = 2.5;

/// Filter and belief of one robot.
#[derive(Debug, Clone, Copy)]
pub struct Adaptive<T, const N: usize> {
    conditioner: Conditioner<T, N>,
    fitted: TorqueModel<T>,
    /// The fitted one on the ground in hand.
    torque: TorqueModel<T>,
    drive: Drive,
    range: MassRange<T>,
    noise: Noise<T>,
    /// Residuals beyond this count linearly, W.
    linear_beyond: T,
    period: T,
    /// What the states are in units of: kg, N·m/kg, N·m/kg.
    units: [T; STATES],
    belief: Belief<T>,
    evidence: Evidence<T>,
    /// Σ w g of the bucket in hand, g being the power's slope by the mass.
    slope: T,
    lasting: Lasting<T>,
    /// The mass if it was given, kg: the ground alone adapts.
    told: Option<T>,
    /// Whether the coefficients distinguish masses.
    identifies_mass: bool,
    spread: Spread<T>,
    ground: Ground<T>,
    /// Shares of the information that remain after a bucket: of the mass and of the ground.
    fading: [T; 2],
    bucket_length: T,
    /// Time into the open bucket, and half a period, s.
    phase: T,
    /// Since the last sample that was a number, s.
    silent: T,
    /// Of that, the time that no step of a sample covers, s.
    passed: T,
    adapted: Adapted<T>,
    measured: Energy<T>,
    predicted: Energy<T>,
    /// The least power that counts for both, W.
    floor: T,
}

impl<T: Real, const N: usize> Adaptive<T, N> {
    /// For samples `period_s` apart, believing anew every `bucket_s`.
    ///
    /// # Errors
    /// Another model than the signed one, or effects; a filter cutoff or a delay that this rate
    /// cannot have.
    pub fn new(
        coefficients: &Coefficients<T, N>,
        ground: &Ground<T>,
        period_s: f64,
        bucket_s: f64,
    ) -> Result<Self, Unfit> {
        let Coefficients { robot, model, noise, columns, identifies_mass, .. } = coefficients;
        let Model::Signed { torque, drive } = *model else { return Err(Unfit::Model) };
        if !columns.is_empty() {
            return Err(Unfit::Model);
        }
        let fade = |time: T| (-(T::from_f64(bucket_s) / time)).exp();
        // Only the mass distinguishes Coulomb's torque from rolling resistance: a floor changes the
        // sum of both.
        let rolling = torque.rolling + torque.coulomb / robot.range.middle();
        let units = [robot.range.reach(), ground.share * rolling, ground.share * torque.scrub];
        let unknown = MassEstimate::Unknown(if *identifies_mass {
            Unknown::NoSamples
        } else {
            Unknown::NotIdentifiable
        });
        let [_, rolling_unit, scrub_unit] = units;
        Ok(Self {
            conditioner: Conditioner::new(robot, period_s)?,
            fitted: torque,
            torque,
            drive,
            range: robot.range,
            noise: *noise,
            linear_beyond: T::from_f64(HUBER) * noise.filtered_std(robot.cutoff_hz),
            period: T::from_f64(period_s),
            units,
            belief: Belief::default(),
            evidence: Evidence::default(),
            slope: T::ZERO,
            lasting: Lasting::default(),
            told: None,
            identifies_mass: *identifies_mass,
            spread: Spread::default(),
            ground: *ground,
            fading: [fade(ground.window), fade(ground.memory)],
            bucket_length: T::from_f64(bucket_s),
            phase: T::from_f64(period_s) * T::HALF,
            silent: T::ZERO,
            passed: T::ZERO,
            adapted: Adapted {
                mass: unknown,
                rolling: [torque.rolling, rolling_unit],
                scrub: [torque.scrub, scrub_unit],
            },
            measured: Energy::default(),
            predicted: Energy::default(),
            floor: coefficients.energy_floor(),
        })
    }

    /// The same for a robot whose total mass is known, kg: what the power lacks or has beyond the
    /// fit's is the ground's.
    #[must_use]
    pub fn with_mass(mut self, mass: T) -> Self {
        let [unit, ..] = self.units;
        self.told = Some(mass);
        self.belief.tell_mass((mass - self.range.middle()) / unit);
        self.adapted.mass = MassEstimate::Known(Mass { mass, low: mass, high: mass });
        self
    }

    /// What is known as of the last closed bucket.
    pub fn adapted(&self) -> &Adapted<T> {
        &self.adapted
    }

    /// Actuation energy measured, and predicted while the mass was known, since the start, J, as
    /// the plain estimator counts it. A gap counts as [`GAP_PERIODS`] periods: nobody measured more
    /// of it.
    pub fn energy(&self) -> (T, T) {
        (self.measured.joules(), self.predicted.joules())
    }

    /// Takes one sample, `elapsed` (s) after the one before. The power is that at mass and ground
    /// in hand; a change of the payload is never noticed here: it looks like another ground at
    /// first. Behind a gap that is longer than the window nothing is known of the payload.
    pub fn push(&mut self, sample: &Sample<T, N>, elapsed: T) -> Estimate<T, N> {
        let conditioned = self.conditioner.push(sample, elapsed);
        // In this order NaN counts as none.
        let elapsed = T::ZERO.at_least(elapsed);
        let held = elapsed.at_most(T::from_f64(GAP_PERIODS) * self.period);
        self.silent += elapsed;
        let mut power = None;
        if let Some(now) = &conditioned {
            self.measured.add(self.floor.at_least(now.power), held);
        }
        if let Some(now) = &conditioned
            && now.settled
        {
            let expected = self.see(now);
            if self.adapted.mass.known().is_some() && expected.is_finite() {
                self.predicted.add(self.floor.at_least(expected), held);
                power = Some(expected);
            }
        }
        self.phase += elapsed;
        let closed = self.phase >= self.bucket_length;
        if closed {
            self.close();
        }
        if conditioned.is_some() {
            self.silent = T::ZERO;
        }
        Estimate { conditioned, mass: self.adapted.mass, power, closed, changed: None }
    }

    /// So much time (s), in whole buckets, has passed in addition to the next sample's step.
    pub fn pass(&mut self, time: T) {
        self.silent += time;
        self.passed += time;
    }

    /// The payload changes now.
    pub fn payload_changed(&mut self) {
        self.evidence = Evidence::default();
        (self.slope, self.lasting) = (T::ZERO, Lasting::default());
        self.spread.forget_last();
        if self.told.is_some() {
            return;
        }
        self.belief.forget_mass();
        self.adapted.mass = self.identified(MassEstimate::Unknown(Unknown::NoSamples));
    }

    /// An estimate by coefficients that distinguish masses.
    fn identified(&self, mass: MassEstimate<T>) -> MassEstimate<T> {
        if self.identifies_mass { mass } else { MassEstimate::Unknown(Unknown::NotIdentifiable) }
    }

    /// P̂ at mass and ground in hand; what the sample says beyond that is added to the evidence.
    fn see(&mut self, now: &Conditioned<T, N>) -> T {
        let (expected, slopes) = self.slopes(&now.motion);
        if let Some(slopes) = slopes {
            let residual = now.power - expected;
            let is_known = self.adapted.mass.known().is_some();
            let counts = if is_known { huber(residual, self.linear_beyond) } else { T::ONE };
            let weight = counts * self.period / self.noise.density;
            // Zero times what is not finite is no number.
            if (residual + weight) * T::ZERO == T::ZERO {
                self.evidence.add(&slopes, residual, weight);
                let [by_mass, ..] = slopes;
                self.slope += weight * by_mass;
            }
        }
        expected
    }

    /// The power in W, and its slopes by the states in their units; none where a wheel may be
    /// clamped.
    fn slopes(&self, motion: &Motion<T, N>) -> (T, Option<[T; STATES]>) {
        let [mass_unit, rolling_unit, scrub_unit] = self.units;
        let [d, ..] = self.belief.state();
        let mass = self.range.middle() + d * mass_unit;
        let (mut power, mut slopes, mut least) = (T::ZERO, [T::ZERO; STATES], T::INFINITY);
        let draw = self.torque.draw();
        for wheel in &motion.wheels {
            let [fixed, per_kg] = self.torque.parts(wheel, mass);
            let torque = fixed + mass * per_kg;
            let wheel_power = draw.power(wheel.speed, torque);
            power += match self.drive {
                Drive::Dissipative => wheel_power.at_least(T::ZERO),
                Drive::Regenerative => wheel_power,
            };
            let by_torque = draw.slope(wheel.speed, torque);
            let [by_mass, by_rolling, by_scrub] = &mut slopes;
            *by_mass += by_torque * per_kg * mass_unit;
            // What a friction adds passes the gear.
            let by_load = by_torque * mass * (T::ONE + self.torque.gear_slope(wheel, mass));
            *by_rolling += by_load * wheel.direction * rolling_unit;
            *by_scrub += by_load * wheel.scrub * scrub_unit;
            let middle = fixed + self.range.middle() * per_kg;
            let at_most = WheelPower::new(wheel, middle, per_kg, &draw, self.range.reach());
            least = least.at_most(at_most.least);
        }
        let may_clamp = least < T::ZERO && matches!(self.drive, Drive::Dissipative);
        (power, (!may_clamp && motion.is_moving()).then_some(slopes))
    }

    /// The bucket in hand is full, and with it those of a gap, if there was one.
    #[inline(never)]
    fn close(&mut self) {
        self.phase -= self.bucket_length;
        let [mass_share, ground_share] = self.fading;
        self.belief.pass(mass_share, ground_share);
        let Evidence { information: [[information, ..], ..], score: [score, ..] } = self.evidence;
        if information > T::ZERO {
            self.spread.push(score / information.sqrt());
        }
        self.belief.take(&self.evidence.scaled(T::ONE / self.spread.excess()));
        self.lasting.pass(mass_share, self.slope, information);
        self.slope = T::ZERO;
        self.evidence = Evidence::default();
        if self.silent > self.ground.window {
            self.outlast();
            return;
        }
        while self.phase >= self.bucket_length {
            self.phase -= self.bucket_length;
            self.belief.pass(mass_share, ground_share);
            self.lasting.pass(mass_share, T::ZERO, T::ZERO);
        }
        self.publish_ground();
        let ([[mass_variance, ..], ..], [d, ..]) = (self.belief.covariance(), self.belief.state());
        let [mass_unit, ..] = self.units;
        // What lasts shifts the mass for as long as the robot drives alike; never by more than
        // nothing is known at all.
        let lasting = self.noise.model_std * self.lasting.shift();
        let variance = (mass_variance + lasting * lasting).at_most(T::ONE.at_least(mass_variance));
        let half_width = T::from_f64(TWO_SIGMA) * variance.sqrt() * mass_unit;
        if self.told.is_none() {
            self.adapted.mass = self.identified(interval::within(&self.range, d * mass_unit, half_width));
        }
    }

    /// After a gap that is longer than the window: the payload may have changed, and the ground is
    /// known as far as its memory reaches. The next buckets end when they would have.
    fn outlast(&mut self) {
        self.payload_changed();
        self.belief.pass(T::ONE, (-((self.phase + self.passed) / self.ground.memory)).exp());
        self.passed = T::ZERO;
        self.phase = remainder(self.phase, self.bucket_length).unwrap_or(self.period * T::HALF);
        self.publish_ground();
    }

    /// The torques on the ground as it is believed to be now.
    fn publish_ground(&mut self) {
        let [_, [_, rolling_variance, _], [_, _, scrub_variance]] = self.belief.covariance();
        let [_, rolling, scrub] = self.belief.state();
        let [_, rolling_unit, scrub_unit] = self.units;
        // Nothing takes less than no torque.
        let not_negative = |fitted: T, by: T| T::ZERO.at_least(fitted + by);
        self.torque = TorqueModel {
            rolling: self.fitted.rolling + rolling * rolling_unit,
            scrub: not_negative(self.fitted.scrub, scrub * scrub_unit),
            ..self.fitted
        };
        self.adapted.rolling = [self.torque.rolling, rolling_variance.sqrt() * rolling_unit];
        self.adapted.scrub = [self.torque.scrub, scrub_variance.sqrt() * scrub_unit];
    }
}

/// The remainder of a time (s) after whole `length`s; `None` of an infinite one.
fn remainder<T: Real>(time: T, length: T) -> Option<T> {
    if !time.is_finite() {
        return None;
    }
    let (mut remaining, mut step) = (time, length);
    while step + step <= remaining {
        step += step;
    }
    while step >= length {
        if remaining >= step {
            remaining -= step;
        }
        step = step * T::HALF;
    }
    Some(remaining)
}

/// What a constant error of the power does to the mass: sums over the window, faded as the evidence
/// is.
#[derive(Debug, Clone, Copy, Default)]
struct Lasting<T> {
    /// Σ w g, 1/W.
    slope: T,
    /// Σ w g².
    information: T,
}

impl<T: Real> Lasting<T> {
    fn pass(&mut self, share: T, slope: T, information: T) {
        self.slope = share * self.slope + slope;
        self.information = share * self.information + information;
    }

    /// By how much 1 W shifts the mass, in its unit; 0 where nothing was seen of it.
    fn shift(&self) -> T {
        if self.information > T::ZERO { self.slope / self.information } else { T::ZERO }
    }
}

/// Two-sided 95 % quantile of Student's t with a window's 25 buckets.
const TWO_SIGMA: f64 = 2.06;
