//! Poses a problem: the noise, what the base gets wrong on any run, and how far it may be off.
use logs::runs::Runs;
use model::effects::{Candidate, Regressor};
use numerics::least_squares::{Factored, NormalEquations};

use super::panel::Fixed;
use crate::noise::whiten::Signal;
use crate::noise::{Memory, Noise};
use crate::predictor::{Predictor, State};
use crate::problem::Problem;
use crate::smooth;
use crate::thresholds::problem::{DISCREPANCY_RIDGE, UNKNOWN};
use crate::types::{Base, Options};
use model_core::effects::Term;
use nalgebra::{DMatrix, DVector};

/// Effects that are `known` take part in the estimate of noise and discrepancy; the search starts
/// without them.
pub fn open_problem<'a>(
    predictor: Predictor<'a>,
    known: &[(Regressor, f64)],
    base: &Base,
    parameters: usize,
    list: &[Candidate],
    options: &Options,
) -> Problem<'a> {
    let smooth = smooth::functions(predictor.runs);
    let start = State { torque: base.torque, effects: known.to_vec() };
    let regressors: Vec<_> = list.iter().flat_map(|candidate| candidate.regressors.iter().cloned()).collect();
    let has_clean = predictor.runs.runs.iter().any(|run| run.clean);
    let field: Vec<Signal> = smooth.iter().map(|signal| only_field(predictor.runs, signal)).collect();
    let shared =
        if has_clean { shared(&predictor, &start, parameters, &regressors, &smooth) } else { Vec::new() };
    let signals: Vec<Signal> = shared.iter().chain(&field).cloned().collect();
    let memory = match &options.whitener {
        Some(whitener) => Memory::Known(whitener),
        None if base.of_simulator => Memory::OfAll,
        None => Memory::OfClean,
    };
    let noise = Noise::estimate(&predictor, &start, parameters, &regressors, &signals, memory);
    let whiten = |signals: &[Signal]| -> Vec<Signal> {
        let run = |(place, values): (usize, &Vec<f64>)| noise.whiten(predictor.runs, place, values);
        signals.iter().map(|signal| signal.iter().enumerate().map(run).collect()).collect()
    };
    let lengths: Vec<usize> = predictor.runs.runs.iter().map(|run| run.rows.len()).collect();
    let discrepancy = Fixed::new(&unit(whiten(&shared)), &lengths);
    let factor = factor(&discrepancy);
    let smooth = whiten(&field);
    // With clean runs the discrepancy holds the base's columns: it moves instead, and the base
    // stays where it was.
    let parameters = if has_clean { 0 } else { parameters };
    let precision = precision(base, parameters, options.slack);
    Problem {
        predictor,
        centre: base.torque,
        base: parameters,
        precision,
        noise,
        discrepancy,
        factor,
        smooth,
        misfit: options.misfit,
        search_factor: options.search_factor,
    }
}

/// A signal in the runs in question only.
fn only_field(runs: &Runs, signal: &Signal) -> Signal {
    let runs = runs.runs.iter().zip(signal);
    runs.map(|(run, values)| if run.clean { vec![0.0; values.len()] } else { values.clone() }).collect()
}

/// What the base may get wrong on any run: along the smooth functions, and along the effects as
/// they would show in it.
fn shared(
    predictor: &Predictor<'_>,
    start: &State,
    parameters: usize,
    regressors: &[Regressor],
    smooth: &[Signal],
) -> Vec<Signal> {
    let (of_motion, further) = smooth.split_at(smooth::count_of_motion(predictor.runs, smooth));
    let mut shared = [of_motion.to_vec(), smooth::shown_by_clean(predictor.runs, further.to_vec())].concat();
    let all = predictor.runs;
    let mut field = all.clone();
    for run in &mut field.runs {
        run.clean = false;
    }
    let predictor = Predictor { runs: &field, ..*predictor };
    let usable =
        |regressor: &&Regressor| !matches!(regressor, Regressor::Column(_) | Regressor::Temperature(..));
    let runs: Vec<Vec<f64>> = (0..field.runs.len()).map(|place| predictor.predict(place, start)).collect();
    let slopes: Vec<Vec<Vec<f64>>> = runs
        .iter()
        .enumerate()
        .map(|(place, at)| predictor.base_slopes(place, start, at, parameters))
        .collect();
    for parameter in 0..parameters {
        shared.push(slopes.iter().map(|slopes| slopes[parameter].clone()).collect());
    }
    for regressor in regressors.iter().filter(usable) {
        let signal =
            runs.iter().enumerate().map(|(place, at)| predictor.effect_slope(place, start, regressor, at));
        let signal: Signal = signal.collect();
        match regressor {
            // By a further column, too.
            Regressor::Term(Term::GradeByPitch) => shared.extend(smooth::shown_by_clean(all, vec![signal])),
            _ => shared.push(signal),
        }
    }
    shared
}

/// Signals scaled to unit length.
fn unit(signals: Vec<Signal>) -> Vec<Signal> {
    let scaled = |mut signal: Signal| {
        let length = signal.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            signal.iter_mut().flatten().for_each(|x| *x /= length);
        }
        signal
    };
    signals.into_iter().map(scaled).collect()
}

fn factor(discrepancy: &Fixed) -> Option<Factored> {
    if discrepancy.is_empty() {
        return None;
    }
    let size = discrepancy.len();
    let total = discrepancy.products.iter().fold(DMatrix::zeros(size, size), |total, run| total + run);
    NormalEquations::from_sums(total, DVector::zeros(size), 0.0).factor(DISCREPANCY_RIDGE).ok()
}

/// Λ of the base's covariance, widened by a relative slack; next to nothing without a covariance.
pub fn precision(base: &Base, parameters: usize, slack: f64) -> DMatrix<f64> {
    let values = base.torque.to_array();
    // Typical sizes, for parameters of zero.
    let typical = [1e-2, 1e-2, 1e-3, 1e-3, 1.0, 1.0, 1e-2];
    let size = |i: usize| values[i].abs().max(1e-2 * typical[i]);
    let Some(covariance) = &base.covariance else { return loose(base, parameters) };
    if parameters == 0 {
        return DMatrix::zeros(0, 0);
    }
    let mut wide = covariance.clone();
    for i in 0..parameters {
        wide[(i, i)] += (slack * size(i)).powi(2);
        // A parameter of which its fit knew nothing has no variance in the file.
        if covariance[(i, i)] <= 0.0 {
            wide[(i, i)] += (UNKNOWN * size(i)).powi(2);
        }
    }
    let scale = DVector::from_fn(parameters, |i, _| 1.0 / wide[(i, i)].sqrt());
    let scaled = DMatrix::from_fn(parameters, parameters, |i, j| wide[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.pseudo_inverse(1e-9).unwrap_or_else(|_| DMatrix::identity(parameters, parameters));
    DMatrix::from_fn(parameters, parameters, |i, j| inverse[(i, j)] * scale[i] * scale[j])
}

/// A very weak prior: the runs decide.
fn loose(base: &Base, parameters: usize) -> DMatrix<f64> {
    let values = base.torque.to_array();
    let precision = DVector::from_fn(parameters, |i, _| 1e-6 / values[i].abs().max(1e-4).powi(2));
    DMatrix::from_diagonal(&precision)
}
