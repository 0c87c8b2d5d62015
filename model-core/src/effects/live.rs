//! Effects in real time: the list of the coefficients along with the estimator, on the board and in
//! the host's replay alike.
//!
//! A sample is first [corrected](Additions::correct) for what its sensors get wrong, but for their
//! delay, which the estimator's conditioner takes care of; after the filter the run is
//! [followed](Additions::follow); then the model [answers](Additions::respond) with what the wheels
//! draw as a polynomial of the mass, the power with all effects at the mass in hand, and what the
//! wheels draw by the measured power.

use super::columns::{Cause, Columns, Terms};
use super::course::{Course, Heat};
use super::extended::Extended;
use super::layout::Layout;
use super::term::Scene;
use crate::coefficients::{Coefficients, Robot};
use crate::conditioner::{Conditioned, Unfit};
use crate::filter::{Channel, LowPass};
use crate::model::{MassRange, Model, Response};
use crate::motion::Motion;
use crate::real::Real;
use crate::sample::Sample;
use crate::slip::TrueTurn;
use crate::torque::{Drive, TorqueModel};

/// What is measured besides speeds and power. What is not finite is unknown: the last known value
/// holds, 0 before there is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outside<T, const N: usize> {
    /// Nose up, rad.
    pub pitch: T,
    /// Of each motor, °C.
    pub temperature: [T; N],
    /// What [`crate::effects::Term::Driver`] multiplies.
    pub driver: T,
}

impl<T: Real, const N: usize> Outside<T, N> {
    /// Nothing is measured.
    pub const UNKNOWN: Self = Self { pitch: T::NAN, temperature: [T::NAN; N], driver: T::NAN };
}

/// What the model says of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<T> {
    /// What the wheels draw as a function of the mass.
    pub response: Response<T>,
    /// P̂ at the mass in hand with all effects, W.
    pub power: T,
    /// What the wheels draw by the measured power, W.
    pub drawn: T,
}

/// What stands between samples and model.
pub trait Additions<T: Real, const N: usize> {
    /// Takes a sample, `elapsed` (s) after the one before, before it passes the filter.
    fn correct(&mut self, sample: &Sample<T, N>, outside: &Outside<T, N>, elapsed: T);

    /// That sample as it would be if its sensors were right.
    fn corrected<'a>(&'a self, sample: &'a Sample<T, N>) -> &'a Sample<T, N>;

    /// What a gyro says of that sample; `None` without one, at no cost.
    #[inline(always)]
    fn true_turn(&self) -> Option<&TrueTurn<T>> {
        None
    }

    /// A sample has passed the filter, settled or not; the mass in hand is `d` kg beyond the middle
    /// of `range`, no number while it is unknown.
    fn follow(&mut self, motion: &Motion<T, N>, range: &MassRange<T>, d: T);

    /// The model's answer to a sample after the filter.
    fn respond(&self, model: &Model<T>, now: &Conditioned<T, N>, range: &MassRange<T>, d: T) -> Answer<T>;
}

/// No effects: nothing is added, at no cost.
impl<T: Real, const N: usize> Additions<T, N> for () {
    #[inline(always)]
    fn correct(&mut self, _: &Sample<T, N>, _: &Outside<T, N>, _: T) {}

    #[inline(always)]
    fn corrected<'a>(&'a self, sample: &'a Sample<T, N>) -> &'a Sample<T, N> {
        sample
    }

    #[inline(always)]
    fn follow(&mut self, _: &Motion<T, N>, _: &MassRange<T>, _: T) {}

    #[inline(always)]
    fn respond(&self, model: &Model<T>, now: &Conditioned<T, N>, range: &MassRange<T>, d: T) -> Answer<T> {
        let (response, power) = model.response_and_power(&now.motion, range, d);
        Answer { response, power, drawn: now.power }
    }
}

/// A column of the log after the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Track<T> {
    channel: Channel<T>,
    /// No number while nothing was measured.
    level: T,
}

impl<T: Real> Track<T> {
    const UNKNOWN: Self = Self { channel: Channel::NOTHING, level: T::NAN };

    #[inline(never)]
    fn take(&mut self, filter: &LowPass<T>, value: T) {
        if !value.is_finite() {
            return;
        }
        if !self.level.is_finite() {
            filter.settle(&mut self.channel, value);
        }
        self.level = filter.step(&mut self.channel, value).value;
    }

    fn or(&self, unknown: T) -> T {
        if self.level.is_finite() { self.level } else { unknown }
    }
}

/// The effects of some coefficients, and what of the run they have to remember.
#[derive(Debug, Clone, Copy)]
pub struct Live<T, const N: usize> {
    columns: Columns<T>,
    terms: Terms<T>,
    torque: TorqueModel<T>,
    drive: Drive,
    layout: Layout<T, N>,
    turn_row: [T; N],
    dead_band: T,
    /// Time constant of the windings' heat, s; no number where nobody asks for it.
    heat_time: T,
    heat: [Heat<T>; N],
    course: Course<T>,
    /// What readings of the wheels' speeds are multiplied by.
    scales: [T; N],
    filter: LowPass<T>,
    pitch: Track<T>,
    temperature: [Track<T>; N],
    driver: Track<T>,
    corrected: Sample<T, N>,
    /// Since the last sample that passed the filter, s.
    passed: T,
}

impl<T: Real, const N: usize> Live<T, N> {
    /// Of coefficients, for samples `period_s` apart.
    ///
    /// # Errors
    /// They have another model than the signed one, or a filter cutoff that this sample rate cannot
    /// have.
    pub fn new(coefficients: &Coefficients<T, N>, period_s: f64) -> Result<Self, Unfit> {
        let Coefficients { robot, model, columns, .. } = coefficients;
        let Model::Signed { torque, drive } = model else { return Err(Unfit::Model) };
        let layout = Layout::new(&robot.kinematics);
        let mut scales = [T::ONE; N];
        for column in columns.iter() {
            if let Cause::Scale(side) = column.cause {
                layout.scale(&mut scales, side, column.coefficient);
            }
        }
        let heat_time = columns.iter().find_map(|column| match column.cause {
            Cause::Heat(time) => Some(time),
            _ => None,
        });
        let [_, _, turn_row] = *robot.kinematics.rows();
        Ok(Self {
            columns: *columns,
            terms: columns.terms(),
            torque: *torque,
            drive: *drive,
            layout,
            turn_row,
            dead_band: robot.dead_band,
            heat_time: heat_time.unwrap_or(T::NAN),
            heat: [Heat::default(); N],
            course: Course::default(),
            scales,
            filter: LowPass::new(robot.cutoff_hz.to_f64(), period_s).map_err(Unfit::Cutoff)?,
            pitch: Track::UNKNOWN,
            temperature: [Track::UNKNOWN; N],
            driver: Track::UNKNOWN,
            corrected: Sample { wheel_speed: [T::ZERO; N], wheel_acceleration: None, power: T::ZERO },
            passed: T::ZERO,
        })
    }

    /// So much time (s) has passed beyond what the samples' steps say: effects of time count it.
    pub fn pass(&mut self, time: T) {
        self.course.pass(time);
        if time > T::ZERO && time.is_finite() {
            self.passed += time;
        }
    }

    /// Another run begins: its time, heading and warmth start anew with the next sample.
    pub fn restart(&mut self) {
        self.course = Course::default();
        self.heat = [Heat::default(); N];
        self.passed = T::ZERO;
    }

    fn extended(&self) -> Extended<'_, T, N> {
        let Self { torque, drive, layout, dead_band, .. } = *self;
        Extended { torque, drive, layout, dead_band, effects: self.terms.as_slice() }
    }

    #[inline(never)]
    fn scene(&self, mass: T) -> Scene<T, N> {
        let time = self.course.time();
        let mut warmth = [T::ZERO; N];
        for ((warmth, heat), temperature) in warmth.iter_mut().zip(&self.heat).zip(&self.temperature) {
            // As cold as in the fit, while nobody knows.
            let known = temperature.level.is_finite() || !self.columns.needs().temperatures;
            let of_wheel = || self.columns.warmth(time, heat.level(), temperature.or(T::ZERO));
            *warmth = if known { of_wheel() } else { T::ZERO };
        }
        Scene {
            mass,
            time,
            pitch: self.pitch.or(T::ZERO),
            heading: self.course.heading(),
            warmth,
            still: self.course.still(),
            driver: self.driver.or(T::ZERO),
        }
    }
}

/// The mass in hand, kg; the middle of the range while it is unknown.
#[inline]
fn in_hand<T: Real>(range: &MassRange<T>, d: T) -> T {
    if d.is_finite() { range.middle() + d } else { range.middle() }
}

// Once a sample, and nothing without effects: functions of their own, for the board's flash.
impl<T: Real, const N: usize> Additions<T, N> for Live<T, N> {
    #[inline(never)]
    fn correct(&mut self, sample: &Sample<T, N>, outside: &Outside<T, N>, elapsed: T) {
        self.pass(elapsed);
        self.pitch.take(&self.filter, outside.pitch);
        self.driver.take(&self.filter, outside.driver);
        for (track, value) in self.temperature.iter_mut().zip(&outside.temperature) {
            track.take(&self.filter, *value);
        }
        self.corrected = *sample;
        for (speed, scale) in self.corrected.wheel_speed.iter_mut().zip(&self.scales) {
            *speed = *speed * *scale;
        }
        for (acceleration, scale) in self.corrected.wheel_acceleration.iter_mut().flatten().zip(&self.scales)
        {
            *acceleration = *acceleration * *scale;
        }
    }

    fn corrected<'a>(&'a self, _: &'a Sample<T, N>) -> &'a Sample<T, N> {
        &self.corrected
    }

    #[inline(never)]
    fn follow(&mut self, motion: &Motion<T, N>, range: &MassRange<T>, d: T) {
        let mut turn_rate = T::ZERO;
        for (share, wheel) in self.turn_row.iter().zip(&motion.wheels) {
            turn_rate += *share * wheel.speed;
        }
        self.course.see(turn_rate, motion.is_moving());
        let passed = self.passed;
        self.passed = T::ZERO;
        if self.heat_time.is_finite() {
            let mass = in_hand(range, d);
            for (heat, wheel) in self.heat.iter_mut().zip(&motion.wheels) {
                let torque = self.torque.torque(wheel, mass);
                heat.take(self.torque.winding_loss * torque * torque, passed, self.heat_time);
            }
        }
    }

    #[inline(never)]
    fn respond(&self, _: &Model<T>, now: &Conditioned<T, N>, range: &MassRange<T>, d: T) -> Answer<T> {
        let (extended, scene) = (self.extended(), self.scene(in_hand(range, d)));
        let (response, power) = extended.response_and_power(&now.motion, &scene, range, d);
        Answer { response, power, drawn: extended.drawn_of(now.power, &scene) }
    }
}

impl<T: Real, const N: usize> Robot<T, N> {
    /// The powers that the coefficients' effects make of a motion at a mass, early and late, in a
    /// scene that is at the far end of what they may meet; for [`crate::plausibility`].
    #[inline(never)]
    pub(crate) fn powers_at_worst(
        &self,
        torque: TorqueModel<T>,
        drive: Drive,
        columns: &Columns<T>,
        motion: &Motion<T, N>,
        mass: T,
    ) -> [T; 2] {
        let terms = columns.terms();
        let extended = Extended {
            torque,
            drive,
            layout: Layout::new(&self.kinematics),
            dead_band: self.dead_band,
            effects: terms.as_slice(),
        };
        let mut scene = Scene::at_start(mass);
        scene.pitch = T::from_f64(STEEPEST);
        scene.heading = [T::from_f64(core::f64::consts::FRAC_1_SQRT_2); 2];
        scene.driver = T::from_f64(HARDEST);
        for (warmth, wheel) in scene.warmth.iter_mut().zip(&motion.wheels) {
            let alone = torque.torque(wheel, mass);
            let heat = torque.winding_loss * alone * alone;
            *warmth = columns.warmth(T::from_f64(LATEST), heat, T::from_f64(HOTTEST));
        }
        [T::ZERO, T::from_f64(LATEST)].map(|time| extended.power(motion, &Scene { time, ..scene }))
    }
}

/// A slope that wheels do not climb, rad.
const STEEPEST: f64 = 0.7;
/// A processor's load, percent.
const HARDEST: f64 = 100.0;
/// Windings burn here, °C.
const HOTTEST: f64 = 200.0;
/// A week, s: later than any step of a run.
const LATEST: f64 = 604_800.0;
