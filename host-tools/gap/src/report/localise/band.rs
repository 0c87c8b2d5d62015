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
        let own = values.iter().zip(residual).filter(|(value, _)| inside(**value));
        let (rows, sum) = own.fold((0, 0.0), |(rows, sum), (_, x)| (rows + 1, sum + x));
        (rows >= LEAST_ROWS).then(|| sum / rows as f64)
    };
    band(&values.iter().zip(residual).filter_map(mean).collect::<Vec<f64>>())
}

/// `None` for fewer runs than a band needs.
pub(super) fn band(means: &[f64]) -> Option<Spread> {
    if means.len() < LEAST_RUNS {
        return None;
    }
    let found = mean_interval(means);
    Some(Spread { mean: found.mean, band: found.half_width?, runs: found.count })
}
