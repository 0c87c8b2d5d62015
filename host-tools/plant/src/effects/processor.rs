//! The computer on board: one load for some seconds, then the next.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::super::noise::{Stream, stream};

/// Mean time that a load lasts, s: planning, mapping and idling follow each other within seconds.
const DWELL_S: f64 = 6.0;

/// A load that steps at random times, each level uniform between idle and full.
#[derive(Debug, Clone)]
pub(super) struct Processor {
    rng: ChaCha8Rng,
    percent: f64,
    until_s: f64,
}

impl Processor {
    pub(super) fn new(seed: u64) -> Self {
        Self { rng: stream(seed, Stream::Processor), percent: 0.0, until_s: 0.0 }
    }

    /// Load at a time that never goes back, percent; in tenths, as it is logged.
    pub(super) fn percent_at(&mut self, time_s: f64) -> f64 {
        while time_s >= self.until_s {
            let uniform: f64 = self.rng.random_range(f64::MIN_POSITIVE..1.0);
            self.until_s -= DWELL_S * uniform.ln();
            self.percent = f64::from(self.rng.random_range(50..=950_u32)) / 10.0;
        }
        self.percent
    }
}
