//! model-core's estimator, set up as `gmr estimate` and the board do: the same windows, the same
//! answers.

use logs::RawSample;
use model::coefficients::FittedModel;
use model::pipeline::{Beside, Estimated, Payloads, Pipeline as Estimating, bucket_length, fitted};
use model_core::estimator::{Timing, Unfit};
use model_core::payload::schedule::Schedule;
use support::error::{Error, Result};

/// Length of the window, s: as `gmr estimate`.
const WINDOW_S: f64 = 25.0;

/// Samples to estimates, at one rate.
pub struct Pipeline {
    estimating: Box<dyn Estimating>,
    period_s: f64,
    latest: Option<Estimated>,
    changes: u64,
}

impl Pipeline {
    /// Of coefficients, for samples that come every `period_s`.
    ///
    /// # Errors
    /// Coefficients that cannot run at this rate, or whose effects need what no wheel and no power
    /// sensor measures.
    pub fn new(coefficients: &FittedModel, period_s: f64) -> Result<Self> {
        if !coefficients.columns.needs().nothing() {
            return Err(Error::failed(
                "these coefficients have effects that need a slope, motor temperatures or another column; expected coefficients without \
                 such effects",
            ));
        }
        let bucket_s = bucket_length(WINDOW_S)?;
        let schedule = Schedule::Moving { window: (WINDOW_S / bucket_s).round() as usize };
        let timing = Timing { period_s, bucket_s, schedule, detect_changes: true };
        let payloads = Payloads::default_for(&coefficients.model);
        let estimating = fitted(coefficients, payloads, &timing).map_err(|why| unfit(why, period_s))?;
        Ok(Self { estimating, period_s, latest: None, changes: 0 })
    }

    /// Takes a sample, so long after the one before, s.
    pub fn push(&mut self, sample: &RawSample, elapsed: f64) {
        let estimate = self.estimating.push(sample, &Beside::UNKNOWN, elapsed);
        self.changes += u64::from(estimate.changed.is_some());
        self.latest = Some(estimate);
    }

    /// Nothing is known of the payload from now on.
    pub fn restart(&mut self) {
        self.estimating.restart();
    }

    /// What is known since the latest sample; none before the first.
    pub fn latest(&self) -> Option<&Estimated> {
        self.latest.as_ref()
    }

    /// Time between samples, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Payload changes noticed.
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// What the drives drew since the start, J.
    pub fn energy_j(&self) -> f64 {
        self.estimating.energy().0
    }
}

fn unfit(why: Unfit, period_s: f64) -> Error {
    let rate = 1.0 / period_s;
    Error::failed(match why {
        Unfit::Cutoff(cutoff) => format!(
            "the coefficients' cutoff of {} Hz at {rate:.1} speeds a second; expected below {:.3} Hz: more speeds a second, or a fit at this \
             rate",
            cutoff.cutoff_hz, cutoff.below_hz
        ),
        Unfit::Model => "effects beside model eq18; expected model signed".to_owned(),
        Unfit::Sides => "true slip of a robot that has no two sides".to_owned(),
        Unfit::Delay => {
            format!("a delay too long for {rate:.1} speeds a second; expected a fit at this rate")
        }
    })
}
