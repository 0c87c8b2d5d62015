//! What a log is replayed through: the estimator on the ground of the fit, as boards run it, or one
//! whose ground adapts.

use logs::{RawSample, with_core};
use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::{Coefficients, MOST_WHEELS};
use model_core::effects::live::{Additions, Live, Outside};
use model_core::estimator::{Conditioned, Estimate, Estimator, Timing, Unfit};
use model_core::gyro::{Gyro, WithGyro};
use model_core::model::{Model, Response};
use model_core::payload::roots::{self, RootMean};
use model_core::payload::window::{self, Window};
use model_core::payload::{Bucket, MassEstimate, Method, Unknown};
use serde::{Deserialize, Serialize};
use support::error::{Error, Result as Done};

use crate::coefficients::FittedModel;

/// Most buckets in a window.
const BUCKETS: usize = 512;

/// How the mass is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Payloads {
    /// Least squares over all samples of the window
    Window,
    /// The paper's weighted mean of Eq. 24's roots
    Roots,
}

impl Payloads {
    /// The paper's estimator for the paper's model, least squares for the default one.
    pub fn default_for(model: &Model<f64>) -> Self {
        match model {
            Model::Signed { .. } => Self::Window,
            Model::Eq18 { .. } => Self::Roots,
        }
    }
}

/// Buckets are at most this long, s, and divide a second.
const BUCKET_LENGTHS_S: [f64; 5] = [1.0, 0.5, 0.25, 0.2, 0.1];

/// Fewest buckets in a window: fewer leave no scatter to judge the error by.
const FEWEST_BUCKETS: f64 = 8.0;

/// The length bucket that divides the window, s.
///
/// # Errors
/// No bucket does, or the window would have more of them than there is room for.
pub fn bucket_length(window_s: f64) -> Done<f64> {
    let divides = |bucket: f64| ((window_s / bucket).round() - window_s / bucket).abs() < 1e-9;
    let fits = |bucket: &f64| divides(*bucket) && window_s / bucket >= FEWEST_BUCKETS - 1e-9;
    let length = BUCKET_LENGTHS_S.into_iter().find(fits).filter(|bucket| window_s / bucket <= BUCKETS as f64);
    length.ok_or_else(|| {
        Error::usage(format!(
            "--window {window_s}: expected 0.8 s to {} s, a multiple of 0.1 s (of 1 s above {} s)",
            BUCKETS,
            BUCKETS / 2
        ))
    })
}

/// Why a mass is unknown, for people.
pub fn reason_text(reason: Unknown) -> &'static str {
    match reason {
        Unknown::NoSamples => "no samples yet",
        Unknown::NoMotion => "the robot stood still or its drives were clamped",
        Unknown::TooWide => "these samples say too little about the mass",
        Unknown::NotFinite => "a sum is not finite",
        Unknown::NotIdentifiable => "the coefficients come from one payload or one speed only",
    }
}

/// The floor as it seems to be, after a second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GroundAt {
    /// Time in the log, s.
    pub time_s: f64,
    /// Rolling resistance, N·m/kg at a wheel, and its standard deviation.
    pub rolling_nm_kg: f64,
    /// N·m/kg
    pub rolling_std_nm_kg: f64,
    /// Scrub, N·m/kg at the outermost wheels, and its standard deviation.
    pub scrub_nm_kg: f64,
    /// N·m/kg
    pub scrub_std_nm_kg: f64,
}

/// What is measured beside speeds and power, with room for all wheels that a robot can have.
pub type Beside = Outside<f64, MOST_WHEELS>;

/// What is known after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Actuation power after the filter, W; `None` until the filter has settled.
    pub measured: Option<f64>,
    /// The total mass as of the last closed bucket.
    pub mass: MassEstimate<f64>,
    /// P̂_act, W; `None` while the mass is unknown, and until the filter has settled.
    pub power: Option<f64>,
    /// This sample closed a bucket.
    pub closed: bool,
    /// This sample shows that the payload changed; it did so this many buckets ago.
    pub changed: Option<usize>,
}

/// Samples in, mass and power out.
pub trait Pipeline {
    /// Takes a sample, `elapsed` s after the one before, and what is measured beside.
    fn push(&mut self, sample: &RawSample, beside: &Beside, elapsed: f64) -> Estimated;
    /// The robot's turn rate (counter-clockwise, rad/s) at the next sample; no number where no gyro
    /// tells it.
    fn turn(&mut self, _: f64) {}
    /// Another run begins: nothing is known of its payload, nor of what effects remember.
    fn restart(&mut self);
    /// The payload changes now.
    fn payload_changed(&mut self);
    /// The mass over the latest `count` buckets; `None` while there are fewer.
    fn over_latest(&self, count: usize) -> Option<MassEstimate<f64>>;
    /// Actuation energy measured, and predicted while the mass was known, J.
    fn energy(&self) -> (f64, f64);
    /// Power of the latest sample at a mass, kg, on the ground of the fit, W; `None` where the
    /// filter has not settled.
    fn power_at(&self, mass_kg: f64) -> Option<f64>;
    /// Whether the power predicted is that at a mass that was given.
    fn is_told(&self) -> bool {
        false
    }
    /// The ground in hand, where it adapts: the record at a time, s.
    fn ground(&self, _: f64) -> Option<GroundAt> {
        None
    }
}

/// A pipeline, or what the coefficients cannot have at this rate.
type Made = Result<Box<dyn Pipeline>, Unfit>;

/// The estimator on the ground of the fit, as boards run it.
///
/// # Errors
/// What these coefficients cannot have at this rate.
pub fn fitted(coefficients: &FittedModel, payloads: Payloads, timing: &Timing) -> Made {
    with_core!(&coefficients.robot, core => {
        let coefficients = coefficients.of(core);
        let method = match payloads {
            Payloads::Window => AnyMethod::Window(coefficients.window(timing.period_s)),
            Payloads::Roots => AnyMethod::Roots(RootMean { range: coefficients.robot.range }),
        };
        Ok(Box::new(Fitted::new(&coefficients, method, timing)?))
    })
}

/// Rolling resistance and scrub adapt beside the mass, or at the one that is given.
///
/// # Errors
/// Another model than the signed one, or effects; what these coefficients cannot have at this rate.
pub fn adapting(
    coefficients: &FittedModel,
    ground: &Ground<f64>,
    timing: &Timing,
    mass_kg: Option<f64>,
) -> Made {
    with_core!(&coefficients.robot, core => {
        Ok(Box::new(Adapting::new(&coefficients.of(core), ground, timing, mass_kg)?))
    })
}

/// Either way to find the mass.
#[derive(Debug, Clone, Copy)]
enum AnyMethod {
    Window(Window<f64>),
    Roots(RootMean<f64>),
}

/// The sums of either; those of the other stay 0.
#[derive(Debug, Clone, Copy, Default)]
struct AnySums {
    window: window::Sums<f64>,
    roots: roots::Sums<f64>,
}

impl Bucket<f64> for AnySums {
    fn merge(&mut self, other: &Self) {
        self.window.merge(&other.window);
        self.roots.merge(&other.roots);
    }

    fn all_within(self) -> Self {
        Self { window: self.window.all_within(), roots: self.roots.all_within() }
    }
}

impl Method<f64> for AnyMethod {
    type Sums = AnySums;

    fn add(&self, sums: &mut AnySums, power: f64, response: &Response<f64>, speed: f64, d: f64) {
        match self {
            Self::Window(method) => method.add(&mut sums.window, power, response, speed, d),
            Self::Roots(method) => method.add(&mut sums.roots, power, response, speed, d),
        }
    }

    fn weighs_by_mass(&self) -> bool {
        match self {
            Self::Window(method) => method.weighs_by_mass(),
            Self::Roots(method) => method.weighs_by_mass(),
        }
    }

    fn estimate_of<'a, P>(
        &self,
        total: &AnySums,
        parts: impl IntoIterator<Item = P>,
        excess: f64,
    ) -> MassEstimate<f64>
    where
        P: IntoIterator<Item = &'a AnySums>,
    {
        let parts = parts.into_iter().map(IntoIterator::into_iter);
        match self {
            Self::Window(method) => {
                method.estimate_of(&total.window, parts.map(|sums| sums.map(|sums| &sums.window)), excess)
            }
            Self::Roots(method) => {
                method.estimate_of(&total.roots, parts.map(|sums| sums.map(|sums| &sums.roots)), excess)
            }
        }
    }

    fn surprise(&self, sums: &AnySums, mass: f64) -> Option<f64> {
        match self {
            Self::Window(method) => method.surprise(&sums.window, mass),
            Self::Roots(method) => method.surprise(&sums.roots, mass),
        }
    }
}

/// The latest sample after the filter, once the filter has settled.
struct Latest<const N: usize> {
    coefficients: Coefficients<f64, N>,
    now: Option<Conditioned<f64, N>>,
}

impl<const N: usize> Latest<N> {
    fn take(&mut self, estimate: &Estimate<f64, N>) -> Estimated {
        let Estimate { conditioned, mass, power, closed, changed } = *estimate;
        self.now = conditioned.filter(|now| now.settled);
        Estimated { measured: self.now.as_ref().map(|now| now.power), mass, power, closed, changed }
    }

    // Inlined, a copy without effects would stand beside this one.
    #[inline(never)]
    fn power_at(&self, live: Option<&Live<f64, N>>, mass_kg: f64) -> Option<f64> {
        let now = self.now.as_ref()?;
        let Coefficients { robot, model, .. } = &self.coefficients;
        let effects: &dyn Additions<f64, N> = live.map_or(&(), |live| live);
        Some(effects.respond(model, now, &robot.range, mass_kg - robot.range.middle()).power)
    }
}

/// As boards do it: with effects only where the coefficients hold any.
struct Fitted<const N: usize> {
    estimator: Estimator<f64, AnyMethod, N, BUCKETS>,
    live: Option<Live<f64, N>>,
    gyro: Option<Gyro<f64>>,
    /// rad/s
    turn_rate: f64,
    latest: Latest<N>,
}

impl<const N: usize> Fitted<N> {
    fn new(coefficients: &Coefficients<f64, N>, method: AnyMethod, timing: &Timing) -> Result<Self, Unfit> {
        let estimator = Estimator::new(coefficients, method, timing)?;
        let live = (!coefficients.columns.is_empty()).then(|| Live::new(coefficients, timing.period_s));
        let robot = &coefficients.robot;
        let delay = robot.conditioning.delay + coefficients.columns.delay();
        let gyro = Gyro::new(robot, delay, timing.period_s)?;
        let latest = Latest { coefficients: *coefficients, now: None };
        Ok(Self { estimator, live: live.transpose()?, gyro, turn_rate: f64::NAN, latest })
    }
}

impl<const N: usize> Pipeline for Fitted<N> {
    fn push(&mut self, sample: &RawSample, beside: &Beside, elapsed: f64) -> Estimated {
        let sample = &sample.core();
        let mut nothing = ();
        let effects: &mut dyn Additions<f64, N> = match &mut self.live {
            Some(live) => live,
            None if self.gyro.is_none() => return self.latest.take(&self.estimator.push(sample, elapsed)),
            None => &mut nothing,
        };
        // Asked by reference, all of them share what is compiled.
        let mut turning;
        let additions: &mut dyn Additions<f64, N> = match &mut self.gyro {
            Some(gyro) => {
                turning = WithGyro::new(effects, gyro, self.turn_rate);
                &mut turning
            }
            None => effects,
        };
        let temperature = std::array::from_fn(|wheel| beside.temperature[wheel]);
        let outside = Outside { pitch: beside.pitch, temperature, driver: beside.driver };
        self.latest.take(&self.estimator.push_with(additions, sample, &outside, elapsed))
    }

    fn turn(&mut self, rate: f64) {
        self.turn_rate = rate;
    }

    fn restart(&mut self) {
        self.estimator.payload_changed();
        if let Some(live) = &mut self.live {
            live.restart();
        }
    }

    fn payload_changed(&mut self) {
        self.estimator.payload_changed();
    }

    fn over_latest(&self, count: usize) -> Option<MassEstimate<f64>> {
        self.estimator.over_latest(count)
    }

    fn energy(&self) -> (f64, f64) {
        self.estimator.energy()
    }

    fn power_at(&self, mass_kg: f64) -> Option<f64> {
        self.latest.power_at(self.live.as_ref(), mass_kg)
    }
}

/// Rolling resistance and scrub adapt beside the mass.
struct Adapting<const N: usize> {
    adaptive: Adaptive<f64, N>,
    /// Buckets since the payload was another.
    buckets: usize,
    is_told: bool,
    latest: Latest<N>,
}

impl<const N: usize> Adapting<N> {
    fn new(
        coefficients: &Coefficients<f64, N>,
        ground: &Ground<f64>,
        timing: &Timing,
        mass_kg: Option<f64>,
    ) -> Result<Self, Unfit> {
        let adaptive = Adaptive::new(coefficients, ground, timing.period_s, timing.bucket_s)?;
        let is_told = mass_kg.is_some();
        let adaptive = mass_kg.map_or(adaptive, |mass| adaptive.with_mass(mass));
        let latest = Latest { coefficients: *coefficients, now: None };
        Ok(Self { adaptive, buckets: 0, is_told, latest })
    }
}

impl<const N: usize> Pipeline for Adapting<N> {
    fn push(&mut self, sample: &RawSample, _: &Beside, elapsed: f64) -> Estimated {
        let estimate = self.adaptive.push(&sample.core(), elapsed);
        self.buckets += usize::from(estimate.closed);
        self.latest.take(&estimate)
    }

    fn restart(&mut self) {
        self.payload_changed();
    }

    fn payload_changed(&mut self) {
        self.adaptive.payload_changed();
        self.buckets = 0;
    }

    fn over_latest(&self, count: usize) -> Option<MassEstimate<f64>> {
        // What was given is nothing that was found.
        (self.buckets >= count && !self.is_told).then_some(self.adaptive.adapted().mass)
    }

    fn energy(&self) -> (f64, f64) {
        self.adaptive.energy()
    }

    fn power_at(&self, mass_kg: f64) -> Option<f64> {
        self.latest.power_at(None, mass_kg)
    }

    fn is_told(&self) -> bool {
        self.is_told
    }

    fn ground(&self, time_s: f64) -> Option<GroundAt> {
        let ground = self.adaptive.adapted();
        let ([rolling_nm_kg, rolling_std_nm_kg], [scrub_nm_kg, scrub_std_nm_kg]) =
            (ground.rolling, ground.scrub);
        Some(GroundAt { time_s, rolling_nm_kg, rolling_std_nm_kg, scrub_nm_kg, scrub_std_nm_kg })
    }
}
