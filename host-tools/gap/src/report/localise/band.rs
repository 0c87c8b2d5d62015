//! Mean of the runs' means in a cell, and its band.

use numerics::intervals::mean_interval;

use residuals::noise::whiten::Signal;
use residuals::thresholds::localise::{LEAST_ROWS, LEAST_RUNS};

/// Mean of runs' means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spread {
    pub(super) mean: f64,
    pub(super) band: f64,
    pub(super) runs: usize,
}

/// The residual where `inside` holds of the axis; `None` for fewer runs than a band needs.
pub(super) fn spread(values: &Signal, residual: &Signal, inside: &dyn Fn(f64) -> bool) -> Option<Spread> {
    let mean = |(values, residual): (&Vec<f64>, &Vec<f64>)| {
        let rows = values.iter().zip(residual).filter(|(value, _)| inside(**value));
        let (count, sum) = rows.fold((0, 0.0), |(count, sum), (_, x)| (count + 1, sum + x));
        (count >= LEAST_ROWS).then(|| sum / count as f64)
    };
    band(&values.iter().zip(residual).filter_map(mean).collect::<Vec<f64>>())
}

/// `None` for fewer runs than a band needs.
pub(super) fn band(means: &[f64]) -> Option<Spread> {
    if means.len() < LEAST_RUNS {
        return None;
    }
    let interval = mean_interval(means);
    Some(Spread { mean: interval.mean, band: interval.half_width?, runs: interval.count })
}
