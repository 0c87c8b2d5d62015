//! The estimator that belongs to a model.

use model_core::adapt::{Adaptive, Ground};
use model_core::board::{self, BoardEstimator};
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Live, Outside};
use model_core::estimator::{Estimate, Estimator, Sample, Timing, Unfit};
use model_core::model::Model;
use model_core::payload::roots::RootMean;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;

use crate::parameters::{BUCKET_S, MOST_BUCKETS, SAMPLE_RATE_HZ, WINDOW_S};
use crate::wheels::WHEELS;

const PERIOD_S: f64 = 1.0 / SAMPLE_RATE_HZ as f64;

/// As `gmr estimate` replays by default.
const TIMING: Timing = Timing {
    period_s: PERIOD_S,
    bucket_s: BUCKET_S as f64,
    schedule: Schedule::Moving { window: WINDOW_S / BUCKET_S },
    detect_changes: true,
};

/// One of them.
#[derive(Debug, Clone, Copy)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap, and room for the larger one has to be anyway"
)]
pub(super) enum Pipeline {
    /// The default: least squares over the window.
    Window(BoardEstimator),
    /// The default with effects.
    Extended(BoardEstimator, Live<f32, WHEELS>),
    /// Rolling resistance and scrub adapt beside the mass, where the coefficients say so.
    Adapting(Adaptive<f32, WHEELS>),
    /// The paper's: the weighted mean of Eq. 24's roots.
    Roots(Estimator<f32, RootMean<f32>, WHEELS, MOST_BUCKETS>),
}

impl Pipeline {
    /// # Errors
    /// A filter cutoff or effects that the sample rate cannot have.
    pub(super) fn new(coefficients: &Coefficients<f32, WHEELS>) -> Result<Self, Unfit> {
        let range = coefficients.robot.range;
        let window = coefficients.window(PERIOD_S as f32);
        match coefficients.model {
            Model::Signed { .. } if coefficients.ground_adapts => adapting(coefficients),
            Model::Signed { .. } if coefficients.columns.is_empty() => {
                Estimator::new(coefficients, window, &TIMING).map(Self::Window)
            }
            Model::Signed { .. } => extended(coefficients, window),
            Model::Eq18 { .. } => Estimator::new(coefficients, RootMean { range }, &TIMING).map(Self::Roots),
        }
    }

    /// Takes a sample. `elapsed` (s) have passed since the one before by the buckets' count, and
    /// `uncounted` (s) more by the clock.
    pub(super) fn push(
        &mut self,
        sample: &Sample<f32, WHEELS>,
        (elapsed, uncounted): (f32, f32),
    ) -> Estimate<f32, WHEELS> {
        match self {
            Self::Window(estimator) => board::push(estimator, sample, elapsed),
            Self::Adapting(adaptive) => {
                adaptive.pass(uncounted);
                adaptive.push(sample, elapsed)
            }
            Self::Extended(estimator, live) => {
                live.pass(uncounted);
                estimator.push_with(live, sample, &Outside::UNKNOWN, elapsed)
            }
            // One way for all robots, for the flash: the straight one would be there beside it.
            Self::Roots(estimator) => estimator.push_with(&mut (), sample, &Outside::UNKNOWN, elapsed),
        }
    }

    /// Actuation energy measured, and predicted while the mass was known, J.
    pub(super) fn energy(&self) -> (f32, f32) {
        match self {
            Self::Window(estimator) => estimator.energy(),
            Self::Adapting(adaptive) => adaptive.energy(),
            Self::Extended(estimator, _) => estimator.energy(),
            Self::Roots(estimator) => estimator.energy(),
        }
    }
}

// Each by itself: in one function the compiler would move every field of each kind one by one, 70
// KB of the image.

#[inline(never)]
fn adapting(coefficients: &Coefficients<f32, WHEELS>) -> Result<Pipeline, Unfit> {
    let ground = Ground { window: WINDOW_S as f32, ..Ground::usual() };
    Adaptive::new(coefficients, &ground, PERIOD_S, TIMING.bucket_s).map(Pipeline::Adapting)
}

#[inline(never)]
fn extended(coefficients: &Coefficients<f32, WHEELS>, window: Window<f32>) -> Result<Pipeline, Unfit> {
    let live = Live::new(coefficients, PERIOD_S)?;
    Estimator::new(coefficients, window, &TIMING).map(|estimator| Pipeline::Extended(estimator, live))
}
