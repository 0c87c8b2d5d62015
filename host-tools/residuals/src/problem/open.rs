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
use crate::thresholds::problem::{RIDGE, UNKNOWN};
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
    let start = State { torque: base.torque, effects: known.to_vec() };
    let slopes = slopes(&predictor, &start, parameters, list);
    open_with(predictor, slopes, base, parameters, list, options)
}

/// As [`open_problem`], of slopes that are there already.
pub(crate) fn open_with<'a>(
    predictor: Predictor<'a>,
    slopes: Vec<Slopes>,
    base: &Base,
    parameters: usize,
    list: &[Candidate],
    options: &Options,
) -> Problem<'a> {
    let runs = predictor.runs;
    let smooth = smooth::functions(runs);
    let has_clean = runs.runs.iter().any(|run| run.clean);
    let field: Vec<Signal> = smooth.iter().map(|signal| only_field(runs, signal)).collect();
    let shared = if has_clean { shared(runs, &slopes, list, &smooth) } else { Shared::default() };
    let memory = match &options.whitener {
        Some(whitener) => Memory::Known(whitener),
        None if base.of_simulator => Memory::OfAll,
        None => Memory::OfClean,
    };
    // Of a shared column the clean runs' part is enough: the field has its own column for it.
    let columns = slopes.into_iter().enumerate().map(|(place, Slopes { base, effects, residual })| {
        let clean = runs.runs[place].clean;
        let if_clean = |signal: &Signal| or_none(clean, &signal[place]);
        base.into_iter()
            .chain(effects.iter().map(|slope| or_none(!clean, slope)))
            .chain(shared.smooth.iter().chain(&shared.effects).map(if_clean))
            .chain(field.iter().map(|signal| signal[place].clone()))
            .chain([residual])
            .collect()
    });
    let noise = Noise::estimate(runs, &columns.collect::<Vec<_>>(), memory);
    let shared = [shared.smooth, shared.base, shared.effects].concat();
    let whiten = |signals: &[Signal]| -> Vec<Signal> {
        let run = |(place, values): (usize, &Vec<f64>)| noise.whiten(runs, place, values);
        signals.iter().map(|signal| signal.iter().enumerate().map(run).collect()).collect()
    };
    let lengths: Vec<usize> = runs.runs.iter().map(|run| run.rows.len()).collect();
    let discrepancy = Fixed::new(&unit(whiten(&shared)), &lengths);
    let factor = factor(&discrepancy);
    let smooth = whiten(&field);
    // With clean runs the discrepancy holds the base's columns: it moves instead, and the base
    // stays where it was.
    let parameters = if has_clean { 0 } else { parameters };
    let precision = precision(base, parameters, options.slack);
    let mut problem = Problem {
        predictor,
        centre: base.torque,
        base: parameters,
        precision,
        noise,
        discrepancy,
        factor,
        still: Vec::new(),
        smooth,
        misfit: options.misfit,
    };
    let start = problem.start();
    let of_clean = |run: usize| runs.runs[run].clean.then(|| problem.run_loss(&start, run));
    problem.still = (0..runs.runs.len()).map(of_clean).collect();
    problem
}

/// A signal in the runs in question only.
fn only_field(runs: &Runs, signal: &Signal) -> Signal {
    runs.runs.iter().zip(signal).map(|(run, values)| or_none(!run.clean, values)).collect()
}

/// The values, or 0 for each.
fn or_none(shown: bool, values: &[f64]) -> Vec<f64> {
    if shown { values.to_vec() } else { vec![0.0; values.len()] }
}

/// What a run would show if it came from the field, clean or not.
#[derive(Clone)]
pub(crate) struct Slopes {
    /// ∂P/∂ the base's parameters.
    base: Vec<Vec<f64>>,
    /// ∂P/∂ the effects' coefficients.
    effects: Vec<Vec<f64>>,
    residual: Vec<f64>,
}

/// Of each run, about a state.
pub(crate) fn slopes(
    predictor: &Predictor<'_>,
    start: &State,
    parameters: usize,
    list: &[Candidate],
) -> Vec<Slopes> {
    let regressors: Vec<Regressor> = regressors(list).cloned().collect();
    let mut field = predictor.runs.clone();
    field.runs.iter_mut().for_each(|run| run.clean = false);
    let as_field = Predictor { runs: &field, ..*predictor };
    let of = |place: usize| {
        let mut base = as_field.columns(place, start, parameters, &regressors);
        let residual = base.pop().unwrap_or_default();
        let effects = base.split_off(parameters);
        Slopes { base, effects, residual }
    };
    (0..field.runs.len()).map(of).collect()
}

fn regressors(list: &[Candidate]) -> impl Iterator<Item = &Regressor> {
    list.iter().flat_map(|candidate| &candidate.regressors)
}

/// What the base may get wrong on any run.
#[derive(Default)]
struct Shared {
    /// Along smooth functions.
    smooth: Vec<Signal>,
    /// Along its own parameters.
    base: Vec<Signal>,
    /// Along effects, as they would show in it.
    effects: Vec<Signal>,
}

fn shared(runs: &Runs, slopes: &[Slopes], list: &[Candidate], smooth: &[Signal]) -> Shared {
    let (of_motion, further) = smooth.split_at(smooth::count_of_motion(runs, smooth));
    let smooth = [of_motion.to_vec(), smooth::shown_by_clean(runs, further.to_vec())].concat();
    let parameters = slopes.first().map_or(0, |run| run.base.len());
    let base =
        (0..parameters).map(|parameter| slopes.iter().map(|run| run.base[parameter].clone()).collect());
    let mut effects = Vec::new();
    for (place, regressor) in regressors(list).enumerate() {
        let signal = slopes.iter().map(|run| run.effects[place].clone()).collect();
        match regressor {
            Regressor::Column(_) | Regressor::Temperature(..) => {}
            // By a further column, too.
            Regressor::Term(Term::GradeByPitch) => effects.extend(smooth::shown_by_clean(runs, vec![signal])),
            _ => effects.push(signal),
        }
    }
    Shared { smooth, base: base.collect(), effects }
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

pub(super) fn factor(discrepancy: &Fixed) -> Option<Factored> {
    if discrepancy.is_empty() {
        return None;
    }
    let size = discrepancy.len();
    let total = discrepancy.products.iter().fold(DMatrix::zeros(size, size), |total, run| total + run);
    NormalEquations::from_sums(total, DVector::zeros(size), 0.0).factor(RIDGE).ok()
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
