//! Sensors that lie: spikes. Values that stand still: [`logs::standing`].

use numerics::robust::MEDIAN_TO_STD;
use serde::Serialize;

use super::sketch::{Sketch, median};

/// Rows around a row whose median it is compared with.
const AROUND: usize = 7;

/// Robust standard deviations beyond which a value is an outlier: a Gaussian passes it once in 10⁹.
const OUTLIER_Z: f64 = 6.0;

/// Deviations below this share of the usual greatest value are no outliers, however quiet the rest
/// is: steps of quantisation, say.
const OUTLIER_SHARE: f64 = 0.05;

/// Spikes of one quantity.
#[derive(Debug, Clone, Serialize)]
pub struct Outliers {
    /// Column, or `acceleration` of the wheel.
    pub quantity: String,
    /// Values more than six robust standard deviations, and 5 % of the usual greatest value, from
    /// the median of the seven rows around them.
    pub count: u64,
    /// That limit, in the unit of the quantity.
    pub limit: f64,
    /// The greatest deviation, and its line.
    pub greatest: f64,
    /// Line of the greatest deviation.
    pub greatest_line: u64,
}

/// Deviations from the median of neighbours: steps and ramps pass, spikes do not.
pub(super) struct Spikes {
    quantity: String,
    recent: Vec<(u64, f64)>,
    deviations: Sketch,
    values: Sketch,
    greatest: (f64, u64),
}

impl Spikes {
    pub(super) fn new(quantity: String) -> Self {
        Self {
            quantity,
            recent: Vec::with_capacity(AROUND),
            deviations: Sketch::new(),
            values: Sketch::new(),
            greatest: (0.0, 0),
        }
    }

    pub(super) fn add(&mut self, line: u64, value: f64) {
        if self.recent.len() == AROUND {
            self.recent.remove(0);
        }
        self.recent.push((line, value));
        if self.recent.len() == AROUND {
            let mut values: [f64; AROUND] = std::array::from_fn(|k| self.recent[k].1);
            let (line, value) = self.recent[AROUND / 2];
            let deviation = (value - median(&mut values)).abs();
            self.deviations.add(deviation);
            self.values.add(value);
            if deviation > self.greatest.0 {
                self.greatest = (deviation, line);
            }
        }
    }

    /// Behind a gap or in a new run the rows before are no neighbours.
    pub(super) fn restart(&mut self) {
        self.recent.clear();
    }

    /// Deviations up to `floor` are no outliers.
    pub(super) fn finish(self, floor: f64) -> Outliers {
        // Where most values repeat, the median deviation is 0 and says nothing about the noise of
        // those that do not.
        let scale = [(&0.5, MEDIAN_TO_STD), (&0.9, 1.0 / 1.645), (&0.99, 1.0 / 2.576)];
        // Where values come in coarse steps, fewer than half of the deviations are none, and those
        // that are not make the noise.
        let [middle, most, nearly_all] =
            scale.map(|(&share, factor)| self.deviations.quantile(share) * factor);
        let sigma = Some(middle.max(most)).filter(|sigma| *sigma > 0.0).or(Some(nearly_all));
        let least = floor.max(OUTLIER_SHARE * self.values.quantile(0.99));
        let limit = least.max(OUTLIER_Z * sigma.unwrap_or(0.0));
        Outliers {
            quantity: self.quantity,
            count: if limit > 0.0 { self.deviations.above(limit) } else { 0 },
            limit,
            greatest: self.greatest.0,
            greatest_line: self.greatest.1,
        }
    }
}
