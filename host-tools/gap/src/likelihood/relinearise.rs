//! The best few about their own sizes: linear rankings mislead where an effect bends.

use model::effects::Regressor;
use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::delay::later;
use super::evidence::{Marginal, Totals, reduce};
use super::normal::log_mean;
use super::priors::{BENT_SETTLED, BENT_STEPS, DELAY_STEPS, RUN_SCALES};
use super::products::Posed;
use super::scored::Scales;
use super::ways::Way;
use residuals::predictor::State;

/// A hypothesis about its own size.
#[derive(Debug, Clone, PartialEq)]
pub struct Bent {
    /// ln evidence over none.
    pub evidence: f64,
    /// Likeliest coefficients.
    pub coefficients: Vec<f64>,
    /// By how much likelier than none each field run is when the others tell of the cause, nats.
    pub by_run: Vec<f64>,
}

/// Gauss and Newton on the coefficients, base and discrepancy moving along; then the evidence
/// there. The way's own columns are the only ones.
pub fn about(posed: &Posed<'_>, scales: &Scales, way: &Way, start: &[f64]) -> Option<Bent> {
    let way = &Way { first: 0, ..way.clone() };
    let mut coefficients = DVector::from_column_slice(start);
    let middle = scales.cases[scales.likeliest()];
    let (mut share, mut last) = (1.0, DVector::zeros(start.len()));
    for step in 0.. {
        let products = products(posed, way, coefficients.as_slice());
        let runs = marginals(posed, scales, &products, middle.scale)?;
        let reduced = reduce(&totals(posed, &runs), posed.shape, &scales.variances, middle.form)?;
        let (next, covariance) = way.likeliest(&reduced, &scales.sizes)?;
        let change = DVector::from_vec(next) - &coefficients;
        // Steps go to and fro where a wheel begins to brake; shorter ones end between.
        if change.dot(&last) < 0.0 {
            share *= 0.5;
        }
        last = share * &change;
        let moves = last.iter().enumerate().map(|(k, by)| by.abs() / covariance[(k, k)].sqrt());
        if moves.fold(0.0, f64::max) > BENT_SETTLED && step < BENT_STEPS {
            coefficients += &last;
            continue;
        }
        // The gain that the linear model promises beyond this size is taken off: no row shows it.
        let unseen = 0.5 * change.dot(&Cholesky::new(covariance.clone())?.solve(&change));
        let size = size(way, coefficients.as_slice());
        let count = posed.shape.functions as f64;
        let totals: Vec<Option<Totals>> = (0..RUN_SCALES.len())
            .map(|scale| Some(totals(posed, &marginals(posed, scales, &products, scale)?)))
            .collect();
        let value = |totals: &Totals, case: usize, share: f64| {
            let form = scales.cases[case].form + (share * size).powi(2) / count;
            let reduced = reduce(totals, posed.shape, &scales.variances, form)?;
            Some(way.gain(&reduced, &scales.sizes) - 0.5 * reduced.minus_two_log)
        };
        let shares = way.form_errors();
        let of_case = |case: usize| -> Vec<f64> {
            let totals = totals[scales.cases[case].scale].as_ref();
            let of = |&share| totals.and_then(|sums| value(sums, case, share)).unwrap_or(f64::NEG_INFINITY);
            shares.iter().map(of).collect()
        };
        let values: Vec<Vec<f64>> = (0..scales.cases.len()).map(of_case).collect();
        let evidence = scales.over_none(|case| log_mean(values[case].iter().copied())) - unseen;
        let all = (0..values.len()).flat_map(|case| (0..shares.len()).map(move |place| (case, place)));
        let prior = |(case, place): (usize, usize)| scales.cases[case].weight + values[case][place];
        let (case, place) = all.max_by(|a, b| prior(*a).total_cmp(&prior(*b)))?;
        let runs = marginals(posed, scales, &products, scales.cases[case].scale)?;
        let by_run = scales.by_run(posed, &runs, |totals| value(totals, case, shares[place]))?;
        return Some(Bent { evidence, coefficients: coefficients.as_slice().to_vec(), by_run });
    }
    None
}

/// The likeliest delay of a grid, what differs between runs left aside: steps lead from it to the
/// likeliest of all.
pub fn delay(posed: &Posed<'_>, scales: &Scales, (low, high): (f64, f64)) -> f64 {
    let step = (DELAY_STEPS * posed.predictor.runs.cutoffs.power).recip();
    let count = (high / step) as i32;
    let powers: Vec<Vec<f64>> =
        (0..posed.runs.len()).map(|run| posed.predicted.power(run, &posed.start)).collect();
    let misfit = |delay: f64| {
        let runs = (0..posed.runs.len()).map(|run| {
            let shift = if posed.is_field(run) { delay } else { 0.0 };
            let late = later(&powers[run], shift, posed.predictor.runs.period_s);
            let rows = posed.predictor.runs.runs[run].rows.iter().zip(&late);
            let residual = posed.kept.thin(run, &rows.map(|(row, at)| row.power - at).collect::<Vec<_>>());
            let columns = DMatrix::from_column_slice(residual.len(), 1, &residual);
            Marginal { products: posed.products_with(run, &columns), log_det: 0.0 }
        });
        let runs: Vec<Marginal> = runs.collect();
        let totals = Totals::of(posed.shape, runs.iter().map(|run| (true, run)));
        let reduced = reduce(&totals, posed.shape, &scales.variances, 0.0);
        reduced.map_or(f64::INFINITY, |reduced| reduced.minus_two_log)
    };
    let grid = (-count..=count).map(|k| step * f64::from(k)).filter(|delay| *delay >= low);
    let each: Vec<(f64, f64)> =
        grid.collect::<Vec<_>>().into_par_iter().map(|delay| (delay, misfit(delay))).collect();
    each.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |best| best.0)
}

/// Size of coefficients, standard deviations of the noise.
pub fn size(way: &Way, coefficients: &[f64]) -> f64 {
    let columns = coefficients.iter().zip(&way.units).zip(&way.candidate.regressors);
    let powers = columns.filter(|(_, regressor)| !matches!(regressor, Regressor::HalfSlip));
    powers.map(|((c, unit), _)| (c * unit).powi(2)).sum::<f64>().sqrt()
}

/// Of each field run with the model linear about some coefficients.
pub fn products(posed: &Posed<'_>, way: &Way, coefficients: &[f64]) -> Vec<Option<DMatrix<f64>>> {
    let of_run = |run: usize| {
        let measured: Vec<f64> = posed.predictor.runs.runs[run].rows.iter().map(|row| row.power).collect();
        let columns = || columns(posed, run, way, coefficients, &measured);
        posed.is_field(run).then(|| posed.products_with(run, &columns()))
    };
    (0..posed.runs.len()).into_par_iter().map(of_run).collect()
}

/// What the model, linear about some coefficients, leaves of a power at none; then a way's slopes.
fn columns(posed: &Posed<'_>, run: usize, way: &Way, coefficients: &[f64], power: &[f64]) -> DMatrix<f64> {
    let regressors = &way.candidate.regressors;
    let effects = regressors.iter().cloned().zip(coefficients.iter().copied());
    let (start, predicted) = (&posed.start, &posed.predicted);
    let state =
        State { torque: start.torque, effects: start.effects.iter().cloned().chain(effects).collect() };
    let at = predicted.power(run, &state);
    let residual: Vec<f64> = power.iter().zip(&at).map(|(power, at)| power - at).collect();
    let mut residual = posed.kept.thin(run, &residual);
    let mut columns = DMatrix::zeros(residual.len(), 1 + regressors.len());
    for (k, slope) in predicted.slopes(run, &state, regressors).iter().enumerate() {
        let slope = posed.kept.thin(run, slope);
        residual.iter_mut().zip(&slope).for_each(|(residual, slope)| *residual += slope * coefficients[k]);
        columns.column_mut(1 + k).copy_from_slice(&slope);
        columns.column_mut(1 + k).unscale_mut(way.units[k]);
    }
    columns.column_mut(0).copy_from_slice(&residual);
    columns
}

/// Of every run at a scale: field runs by these products.
pub fn marginals(
    posed: &Posed<'_>,
    scales: &Scales,
    products: &[Option<DMatrix<f64>>],
    scale: usize,
) -> Option<Vec<Marginal>> {
    let variances = scales.run_variances(scale);
    let of_run = |(run, products): (usize, &Option<DMatrix<f64>>)| match products {
        Some(products) => Marginal::of(products, posed.shape, &variances),
        None => Some(scales.marginals[scale][run].clone()),
    };
    products.iter().enumerate().map(of_run).collect()
}

/// Sums over the runs of a problem.
pub fn totals(posed: &Posed<'_>, runs: &[Marginal]) -> Totals {
    Totals::of(posed.shape, runs.iter().enumerate().map(|(run, marginal)| (posed.is_field(run), marginal)))
}
