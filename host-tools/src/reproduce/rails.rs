//! Fig. 9: what the rails draw while the robot is loaded, and the Gaussian of the static power (Eq. 29).

use super::study::Rails;
use crate::error::Result;
use crate::plant::experiment;

/// Samples in a moving average, as in Fig. 9.
const AVERAGED: usize = 20;

/// The training drive's rails, as INA219s in each of them would read it.
pub(super) fn measure(seed: u64) -> Result<Rails> {
    let readings = experiment::rails(seed)?;
    let power =
        |value: fn(&experiment::RailReading) -> f64| -> Vec<f64> { readings.iter().map(value).collect() };
    let idle = power(|reading| reading.static_w);
    let count = idle.len() as f64;
    let mean = idle.iter().sum::<f64>() / count;
    let variance = idle.iter().map(|power| (power - mean).powi(2)).sum::<f64>() / count;
    Ok(Rails {
        time_s: power(|reading| reading.time_s),
        battery_w: moving_average(&power(|reading| reading.battery_w)),
        actuation_w: moving_average(&power(|reading| reading.actuation_w)),
        static_w: moving_average(&idle),
        static_samples_w: idle,
        gaussian_w: (mean, variance.sqrt()),
    })
}

/// Of the last so many values; of fewer at the start.
fn moving_average(values: &[f64]) -> Vec<f64> {
    let average = |end: usize| {
        let window = &values[(end + 1).saturating_sub(AVERAGED)..=end];
        window.iter().sum::<f64>() / window.len() as f64
    };
    (0..values.len()).map(average).collect()
}
