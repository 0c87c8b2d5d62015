//! Power that comes late, set earlier.
//!
//! What the base gets wrong is as late as the rest of the measured power. Told of clean runs it is
//! in time, and moves a delay of the runs in question by a tenth of a row or more. So where a delay
//! was found, the question is asked again of runs that are in time.

use logs::runs::{Row, Runs};
use model::effects::Regressor;

use super::noise::whiten::Signal;
use super::twin::delayed;

/// A delay in whole rows of `period_s` seconds, s: parts of one are left to the model, for setting
/// measured power earlier by them would smooth its noise.
pub fn in_whole_rows(delay: f64, period_s: f64) -> f64 {
    (delay / period_s).round() * period_s
}

/// The delay as an effect that is known, if there is any.
pub fn known(early: f64) -> Vec<(Regressor, f64)> {
    if early == 0.0 { Vec::new() } else { vec![(Regressor::Delay, early)] }
}

/// A value a row of some runs, set earlier by `early` s.
pub fn earlier(runs: &Runs, signal: &Signal, early: f64) -> Signal {
    runs.runs.iter().zip(signal).map(|(run, values)| delayed(run, values, -early)).collect()
}

/// The runs with their power set earlier by `early` s.
pub fn in_time(runs: &Runs, early: f64) -> Runs {
    let power = runs.runs.iter().map(|run| run.rows.iter().map(|row| row.power).collect()).collect();
    let power = earlier(runs, &power, early);
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
        let early = in_whole_rows(1.8 * runs.period_s, runs.period_s);
        assert!((early - 2.0 * runs.period_s).abs() < 1e-12);
        let moved = in_time(&runs, early);
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
