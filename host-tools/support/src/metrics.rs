//! How well a prediction fits: R² and MAPE (Eq. 27), RMSE.

use serde::Serialize;

/// Running sums of measured and predicted power.
#[derive(Debug, Clone, Copy, Default)]
pub struct Metrics {
    floor_w: f64,
    rows: u64,
    measured: f64,
    measured_squares: f64,
    error_squares: f64,
    relative: f64,
    above_floor: u64,
}

/// The figures, with the share of samples that MAPE could use.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quality {
    /// 1 − Σ(P − P̂)² / Σ(P − P̄)²; null where the power never changes.
    pub r2: Option<f64>,
    /// Mean |P − P̂| / |P| over samples with |P| at or above the floor, %; null without such
    /// samples.
    pub mape_percent: Option<f64>,
    /// The floor, W.
    pub mape_floor_w: f64,
    /// Share of samples at or above the floor.
    pub mape_share: f64,
    /// Root mean square of P − P̂, W.
    pub rmse_w: f64,
    /// Samples compared.
    pub samples: u64,
}

impl Metrics {
    /// With the power below which relative errors mean nothing, W.
    pub fn new(floor_w: f64) -> Self {
        Self { floor_w, ..Self::default() }
    }

    /// One sample, W.
    pub fn add(&mut self, measured: f64, predicted: f64) {
        let error = measured - predicted;
        self.rows += 1;
        // Welford would be safer for years of data about a large mean; powers of robots are not
        // that far from 0.
        self.measured += measured;
        self.measured_squares += measured * measured;
        self.error_squares += error * error;
        if measured.abs() >= self.floor_w {
            self.relative += (error / measured).abs();
            self.above_floor += 1;
        }
    }

    /// The figures so far; `None` without samples.
    pub fn quality(&self) -> Option<Quality> {
        if self.rows == 0 {
            return None;
        }
        let rows = self.rows as f64;
        let spread = self.measured_squares - self.measured * self.measured / rows;
        Some(Quality {
            r2: (spread > 1e-12 * self.measured_squares).then(|| 1.0 - self.error_squares / spread),
            mape_percent: (self.above_floor > 0).then(|| 100.0 * self.relative / self.above_floor as f64),
            mape_floor_w: self.floor_w,
            mape_share: self.above_floor as f64 / rows,
            rmse_w: (self.error_squares / rows).sqrt(),
            samples: self.rows,
        })
    }
}
