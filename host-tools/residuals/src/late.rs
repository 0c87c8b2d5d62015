//! Delayed power, set earlier.
//!
//! The base's errors are delayed like the rest of the measured power, but clean runs show them in
//! time: that moves a fitted delay of the field runs by a tenth of a row or more. So after a delay
//! is detected, the analysis is repeated on runs with the delay taken out.

use logs::runs::{Row, Runs};
use model::effects::Regressor;

use super::noise::whiten::Signal;
use super::predictor::delayed;

/// A delay in whole rows of `period_s` s, s. Fractions of a row are left to the model: setting
/// measured power earlier by a fraction would smooth its noise.
pub fn in_whole_rows(delay: f64, period_s: f64) -> f64 {
    (delay / period_s).round() * period_s
}

/// A known delay as an effect; none for 0.
pub fn known(delay: f64) -> Vec<(Regressor, f64)> {
    if delay == 0.0 { Vec::new() } else { vec![(Regressor::Delay, delay)] }
}

/// A signal, set earlier by `delay` s.
pub fn earlier(runs: &Runs, signal: &Signal, delay: f64) -> Signal {
    runs.runs.iter().zip(signal).map(|(run, values)| delayed(run, values, -delay)).collect()
}

/// The runs with their power set earlier by `delay` s.
pub fn in_time(runs: &Runs, delay: f64) -> Runs {
    let power = runs.runs.iter().map(|run| run.rows.iter().map(|row| row.power).collect()).collect();
    with_power(runs, earlier(runs, &power, delay))
}

/// The runs with another measured power.
pub fn with_power(runs: &Runs, power: Signal) -> Runs {
    let mut runs = runs.clone();
    for (run, power) in runs.runs.iter_mut().zip(power) {
        run.rows = run.rows.iter().zip(power).map(|(row, power)| Row { power, ..*row }).collect();
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::example;

    /// Two rows later is two rows later, to rounding, and nothing else is moved.
    #[test]
    fn power_is_set_earlier_by_whole_rows() {
        let runs = example::runs([0.8, 0.3]);
        let delay = in_whole_rows(1.8 * runs.period_s, runs.period_s);
        assert!((delay - 2.0 * runs.period_s).abs() < 1e-12);
        let moved = in_time(&runs, delay);
        for (run, moved) in runs.runs.iter().zip(&moved.runs) {
            for (row, later) in moved.rows.iter().zip(&run.rows[2..]) {
                assert!((row.power - later.power).abs() < 1e-9, "{} {}", row.power, later.power);
            }
            assert!(run.rows.iter().zip(&*moved.rows).all(|(a, b)| a.wheels == b.wheels && a.time == b.time));
        }
        assert_eq!(in_whole_rows(0.4 * runs.period_s, runs.period_s), 0.0);
        assert!(known(0.0).is_empty());
    }
}
