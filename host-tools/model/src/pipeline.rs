//! What a log is replayed through: the estimator on the ground of the fit, as boards run it, or one
//! whose ground adapts.

use logs::compiled_here;
use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Additions, Live, Outside};
use model_core::estimator::{Estimate, Estimator, Sample, Timing, Unfit};
use model_core::gyro::{Gyro, WithGyro};
use model_core::model::Model;
use model_core::payload::roots::RootMean;
use model_core::payload::{MassEstimate, Method, Unknown};
use serde::{Deserialize, Serialize};
use support::error::{Error, Result as Done};

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

/// The longest bucket that divides the window, s.
///
/// # Errors
/// No bucket does, or the window would have more of them than there is room for.
pub fn bucket_length(window_s: f64) -> Done<f64> {
    let divides = |bucket: f64| ((window_s / bucket).round() - window_s / bucket).abs() < 1e-9;
    let fits = |bucket: &f64| divides(*bucket) && window_s / bucket >= FEWEST_BUCKETS - 1e-9;
    let found = BUCKET_LENGTHS_S.into_iter().find(fits).filter(|bucket| window_s / bucket <= BUCKETS as f64);
    found.ok_or_else(|| {
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

/// Samples in, mass and power out.
pub trait Pipeline<const N: usize> {
    /// Takes a sample, `elapsed` s after the one before, and what is measured beside.
    fn push(&mut self, sample: &Sample<f64, N>, outside: &Outside<f64, N>, elapsed: f64) -> Estimate<f64, N>;
    /// The robot's turn rate (counter-clockwise, rad/s) at the next sample; no number where no gyro
    /// tells it.
    fn turn(&mut self, _: f64) {}
    /// Another run begins: nothing is known of its payload, nor of what effects remember.
    fn restart(&mut self);
    /// The payload is another from now on.
    fn payload_changed(&mut self);
    /// The mass over the latest `count` buckets; `None` while there are fewer.
    fn over_latest(&self, count: usize) -> Option<MassEstimate<f64>>;
    /// Actuation energy measured, and predicted while the mass was known, J.
    fn energy(&self) -> (f64, f64);
    /// The coefficients' effects, where they hold any.
    fn live(&self) -> Option<&Live<f64, N>>;
    /// Whether the power predicted is that at a mass that was given.
    fn is_told(&self) -> bool {
        false
    }
    /// The ground in hand, where it adapts: the record at a time, s.
    fn ground(&self, time_s: f64) -> Option<GroundAt>;
}

/// What [`fitted`] gives.
type Made<const N: usize> = Result<Box<dyn Pipeline<N>>, Unfit>;

compiled_here! {
    /// The estimator on the ground of the fit.
    ///
    /// # Errors
    /// What these coefficients cannot have at this rate.
    pub fn fitted<N>(coefficients: &Coefficients<f64, N>, payloads: Payloads, timing: &Timing) -> Made<N> = fitted_here;
}

fn fitted_here<const N: usize>(
    coefficients: &Coefficients<f64, N>,
    payloads: Payloads,
    timing: &Timing,
) -> Made<N> {
    Ok(match payloads {
        Payloads::Window => {
            Box::new(Fitted::new(coefficients, coefficients.window(timing.period_s), timing)?)
        }
        Payloads::Roots => {
            Box::new(Fitted::new(coefficients, RootMean { range: coefficients.robot.range }, timing)?)
        }
    })
}

/// As boards do it: with effects only where the coefficients hold any.
struct Fitted<M: Method<f64>, const N: usize> {
    estimator: Estimator<f64, M, N, BUCKETS>,
    live: Option<Live<f64, N>>,
    gyro: Option<Gyro<f64>>,
    /// rad/s
    turn_rate: f64,
}

impl<M: Method<f64>, const N: usize> Fitted<M, N> {
    /// # Errors
    /// What these coefficients cannot have at this rate.
    fn new(coefficients: &Coefficients<f64, N>, method: M, timing: &Timing) -> Result<Self, Unfit> {
        let estimator = Estimator::new(coefficients, method, timing)?;
        let live = (!coefficients.columns.is_empty()).then(|| Live::new(coefficients, timing.period_s));
        let robot = &coefficients.robot;
        let delay = robot.conditioning.delay + coefficients.columns.delay();
        let gyro = Gyro::new(robot, delay, timing.period_s)?;
        Ok(Self { estimator, live: live.transpose()?, gyro, turn_rate: f64::NAN })
    }
}

impl<M: Method<f64>, const N: usize> Pipeline<N> for Fitted<M, N> {
    fn push(&mut self, sample: &Sample<f64, N>, outside: &Outside<f64, N>, elapsed: f64) -> Estimate<f64, N> {
        let (mut nothing, mut turning);
        let effects: &mut dyn Additions<f64, N> = match &mut self.live {
            Some(live) => live,
            None if self.gyro.is_none() => return self.estimator.push(sample, elapsed),
            None => {
                nothing = ();
                &mut nothing
            }
        };
        // Asked by reference, all of them share what is compiled.
        let additions: &mut dyn Additions<f64, N> = match &mut self.gyro {
            Some(gyro) => {
                turning = WithGyro::new(effects, gyro, self.turn_rate);
                &mut turning
            }
            None => effects,
        };
        self.estimator.push_with(additions, sample, outside, elapsed)
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

    fn live(&self) -> Option<&Live<f64, N>> {
        self.live.as_ref()
    }

    fn ground(&self, _: f64) -> Option<GroundAt> {
        None
    }
}

/// Rolling resistance and scrub adapt beside the mass.
pub struct Adapting<const N: usize> {
    adaptive: Adaptive<f64, N>,
    /// Buckets since the payload was another.
    buckets: usize,
    is_told: bool,
}

impl<const N: usize> Adapting<N> {
    /// # Errors
    /// Another model than the signed one, or effects; what these coefficients cannot have at this
    /// rate.
    pub fn new(
        coefficients: &Coefficients<f64, N>,
        ground: &Ground<f64>,
        timing: &Timing,
        mass_kg: Option<f64>,
    ) -> Result<Self, Unfit> {
        let adaptive = Adaptive::new(coefficients, ground, timing.period_s, timing.bucket_s)?;
        let is_told = mass_kg.is_some();
        let adaptive = mass_kg.map_or(adaptive, |mass| adaptive.with_mass(mass));
        Ok(Self { adaptive, buckets: 0, is_told })
    }
}

impl<const N: usize> Pipeline<N> for Adapting<N> {
    fn push(&mut self, sample: &Sample<f64, N>, _: &Outside<f64, N>, elapsed: f64) -> Estimate<f64, N> {
        let found = self.adaptive.push(sample, elapsed);
        self.buckets += usize::from(found.closed);
        found
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

    fn live(&self) -> Option<&Live<f64, N>> {
        None
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
