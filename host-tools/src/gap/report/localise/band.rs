//! Mean of the runs' means in a cell, and its band.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::gap::noise::whiten::Signal;
use crate::gap::thresholds::localise::{LEAST_ROWS, LEAST_RUNS};

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
    band(values.iter().zip(residual).filter_map(mean).collect())
}

/// Student's t that a share of 2.5 % passes: few runs know their own scatter badly.
fn student(freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// `None` for fewer runs than a band needs.
pub(super) fn band(means: Vec<f64>) -> Option<Spread> {
    if means.len() < LEAST_RUNS {
        return None;
    }
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
    Some(Spread { mean, band: student(count - 1.0) * (variance / count).sqrt(), runs: means.len() })
}
