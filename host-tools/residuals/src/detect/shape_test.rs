//! Whether the residual after adding an effect follows the effect's column times another measure.
//!
//! An effect outside the dictionary often resembles one inside: w³ is w² times the speed. The
//! residual is then small and spread over many smooth functions, but all of it lies along the
//! winner's column times the speed.
//!
//! The clamp of a drive before the filter is exact to first order only: the residual of regenerated
//! braking power may follow speed or mass. But regeneration is the same in turns as straight ahead.

use logs::runs::Row;
use model::effects::Regressor;
use model_core::effects::Term;

use crate::noise::whiten::Signal;
use crate::predictor::State;
use crate::problem::Problem;

/// Columns of the state's effects times speed, time, mass, turn rate and acceleration, whitened; of
/// braking power that returns times the turn rate only. 0 in clean runs.
pub(super) fn deformations(problem: &Problem<'_>, state: &State) -> Vec<Signal> {
    let runs = problem.predictor.runs;
    let along: [fn(&Row) -> f64; 5] = [
        |row| row.turn_rate.abs(),
        |row| row.wheels.iter().map(|wheel| wheel.speed.abs()).sum(),
        |row| row.time,
        |row| row.mass,
        |row| row.wheels.iter().map(|wheel| wheel.acceleration * wheel.direction).sum(),
    ];
    let mut signals = Vec::new();
    // A delay is exact to first order only.
    let has_shape =
        |regressor: &Regressor| regressor.run().is_none() && !matches!(regressor, Regressor::Delay);
    for (regressor, _) in state.effects.iter().filter(|(regressor, _)| has_shape(regressor)) {
        let column: Signal = (0..runs.runs.len())
            .map(|place| {
                problem.predictor.effect_slope(
                    place,
                    state,
                    regressor,
                    &problem.predictor.predict(place, state),
                )
            })
            .collect();
        let count = if matches!(regressor, Regressor::Term(Term::Return)) { 1 } else { along.len() };
        for value in &along[..count] {
            let (mut weight, mut sum) = (0.0, 0.0);
            for (run, column) in runs.runs.iter().zip(&column) {
                for (row, x) in run.rows.iter().zip(column) {
                    weight += x * x;
                    sum += x * x * value(row);
                }
            }
            let middle = if weight > 0.0 { sum / weight } else { 0.0 };
            let deformed = |(place, column): (usize, &Vec<f64>)| {
                let rows = &runs.runs[place].rows;
                let raw: Vec<f64> =
                    rows.iter().zip(column).map(|(row, x)| x * (value(row) - middle)).collect();
                problem.noise.whiten(runs, place, &raw)
            };
            signals.push(column.iter().enumerate().map(deformed).collect());
        }
    }
    signals
}
