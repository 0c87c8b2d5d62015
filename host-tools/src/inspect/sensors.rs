//! Sensors that lie: spikes and values that stand still.

use serde::Serialize;

use super::sketch::{Sketch, median};
use crate::numerics::robust::MEDIAN_TO_STD;

/// Rows around a row whose median it is compared with.
const AROUND: usize = 7;

/// Robust standard deviations beyond which a value is an outlier: a Gaussian passes it once in 10⁹.
const OUTLIER_Z: f64 = 6.0;

/// Deviations below this share of the usual greatest value are no outliers, however quiet the rest is: steps of
/// quantisation, say.
const OUTLIER_SHARE: f64 = 0.05;

/// Spikes of one quantity.
#[derive(Debug, Clone, Serialize)]
pub struct Outliers {
    /// Column, or `acceleration` of the wheel.
    pub quantity: String,
    /// Values more than six robust standard deviations, and 5 % of the usual greatest value, from the median of the
    /// seven rows around them.
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
        // Where most values repeat, the median deviation is 0 and says nothing about the noise of those that do not.
        let scale = [(&0.5, MEDIAN_TO_STD), (&0.9, 1.0 / 1.645), (&0.99, 1.0 / 2.576)];
        // Where values come in coarse steps, fewer than half of the deviations are none, and those that are not make the noise.
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

/// A column that kept its value while others changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stuck {
    /// Name of the column.
    pub column: String,
    /// The value it kept.
    pub value: f64,
    /// First line of the longest such stretch.
    pub line: u64,
    /// Time of it, s.
    pub from_s: f64,
    /// End of it, s.
    pub to_s: f64,
    /// Time of all such stretches, s.
    pub total_s: f64,
}

/// A value must stand still for this long, s, and this many rows: wheels held at a speed do for a while.
const STUCK_S: f64 = 5.0;
const STUCK_ROWS: u64 = 8;

/// The others must change this often meanwhile, and in this share of the rows: sensors that are read seldom keep their values for some rows.
const OTHERS_CHANGE: u64 = 8;
const OTHERS_CHANGE_SHARE: u64 = 20;

/// Watches one column for standing still.
pub(super) struct Standing {
    column: String,
    value: f64,
    line: u64,
    from_s: f64,
    to_s: f64,
    rows: u64,
    others_changed: u64,
    found: Option<Stuck>,
}

impl Standing {
    pub(super) fn new(column: String) -> Self {
        Self {
            column,
            value: f64::NAN,
            line: 0,
            from_s: 0.0,
            to_s: 0.0,
            rows: 0,
            others_changed: 0,
            found: None,
        }
    }

    pub(super) fn add(&mut self, line: u64, time_s: f64, value: f64, others_change: bool) {
        if value == self.value {
            self.rows += 1;
            self.others_changed += u64::from(others_change);
            self.to_s = time_s;
            return;
        }
        self.close();
        (self.value, self.line, self.from_s, self.to_s) = (value, line, time_s, time_s);
        (self.rows, self.others_changed) = (1, 0);
    }

    pub(super) fn restart(&mut self) {
        self.close();
        self.value = f64::NAN;
    }

    fn close(&mut self) {
        let seconds = self.to_s - self.from_s;
        let others =
            self.others_changed >= OTHERS_CHANGE && OTHERS_CHANGE_SHARE * self.others_changed >= self.rows;
        let stuck = seconds >= STUCK_S && self.rows >= STUCK_ROWS && others;
        self.rows = 0;
        if !stuck {
            return;
        }
        let total_s = seconds + self.found.as_ref().map_or(0.0, |found| found.total_s);
        match &mut self.found {
            Some(found) if found.to_s - found.from_s >= seconds => found.total_s = total_s,
            found => {
                *found = Some(Stuck {
                    column: self.column.clone(),
                    value: self.value,
                    line: self.line,
                    from_s: self.from_s,
                    to_s: self.to_s,
                    total_s,
                });
            }
        }
    }

    pub(super) fn finish(mut self) -> Option<Stuck> {
        self.close();
        self.found
    }
}
