//! Regression of the residual on columns, all runs together.

use nalgebra::{DMatrix, DVector};
use numerics::least_squares::{Factored, NormalEquations};

use super::whiten::Signal;
use crate::thresholds::noise::RIDGE;

/// The columns of one run that are not 0 throughout, and the residual behind them.
pub(super) struct Columns {
    /// How many there are over all runs, the residual not counted.
    all: usize,
    /// Place of each among them.
    places: Vec<usize>,
    values: DMatrix<f64>,
}

impl Columns {
    /// Of all columns of a run, the residual last.
    pub(super) fn new(columns: &[Vec<f64>]) -> Self {
        let all = columns.len().saturating_sub(1);
        let places: Vec<usize> =
            (0..all).filter(|&place| columns[place].iter().any(|value| *value != 0.0)).collect();
        let kept: Vec<&[f64]> = places.iter().chain([&all]).map(|&place| &columns[place][..]).collect();
        let values = DMatrix::from_vec(columns[all].len(), kept.len(), kept.concat());
        Self { all, places, values }
    }

    /// Each column changed.
    pub(super) fn map(&self, change: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let (rows, columns) = self.values.shape();
        let mut changed = Vec::with_capacity(rows * columns);
        self.values.as_slice().chunks(rows.max(1)).for_each(|column| changed.extend(change(column)));
        Self { all: self.all, places: self.places.clone(), values: DMatrix::from_vec(rows, columns, changed) }
    }

    /// The residual less so much of each column.
    pub(super) fn left_by(&self, values: &DVector<f64>) -> Vec<f64> {
        let own = DVector::from_fn(self.places.len() + 1, |k, _| {
            self.places.get(k).map_or(1.0, |&place| -values[place])
        });
        (&self.values * own).as_slice().to_vec()
    }
}

/// The least squares of the residual on the columns of all runs.
pub(super) struct Regression {
    /// What is left of each run's residual.
    pub(super) left: Signal,
    /// A coefficient a column.
    pub(super) values: DVector<f64>,
    equations: Option<Factored>,
}

impl Regression {
    /// Without directions that the rows do not determine.
    pub(super) fn of(runs: &[Columns]) -> Self {
        // A ridge far below any noise: collinear columns share what they explain.
        let equations = equations(runs).factor(RIDGE).ok();
        let columns = runs.first().map_or(0, |run| run.all);
        let values = equations.as_ref().map_or(DVector::zeros(columns), Factored::solution);
        Self { left: runs.iter().map(|run| run.left_by(&values)).collect(), values, equations }
    }

    /// By how much the errors of the coefficients lower the sum of squares of what these columns
    /// leave of their noise: tr(H⁻¹ XᵀX). H is that of this regression, whose rows have white noise
    /// of a standard deviation of 1; X are the columns before they were whitened.
    pub(super) fn absorbed(&self, unwhitened: &[Columns]) -> f64 {
        let whole = equations(unwhitened);
        self.equations.as_ref().map_or(0.0, |equations| equations.determined(whole.matrix()))
    }
}

fn equations(runs: &[Columns]) -> NormalEquations {
    let columns = runs.first().map_or(0, |run| run.all);
    let mut gram = DMatrix::<f64>::zeros(columns + 1, columns + 1);
    for run in runs {
        let products = run.values.transpose() * &run.values;
        let place = |k: usize| run.places.get(k).copied().unwrap_or(columns);
        for i in 0..products.nrows() {
            for j in 0..products.ncols() {
                gram[(place(i), place(j))] += products[(i, j)];
            }
        }
    }
    let places: Vec<usize> = (0..columns).collect();
    NormalEquations::from_products(&gram, &places)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two runs with 2 a + 3 b, where the second has no b.
    #[test]
    fn a_column_that_one_run_lacks_has_its_place() {
        let a = [[1.0, 2.0, -1.0, 0.5], [0.3, -2.0, 1.0, 4.0]].map(Vec::from);
        let b = [[0.5, -1.0, 2.0, 1.0], [0.0; 4]].map(Vec::from);
        let runs: Vec<Columns> = a
            .iter()
            .zip(&b)
            .map(|(a, b)| {
                let residual = a.iter().zip(b).map(|(a, b)| 2.0 * a + 3.0 * b).collect();
                Columns::new(&[b.clone(), a.clone(), residual])
            })
            .collect();
        assert_eq!(runs[1].values.ncols(), 2);
        let regression = Regression::of(&runs);
        assert!((regression.values[0] - 3.0).abs() < 1e-4, "{}", regression.values);
        assert!((regression.values[1] - 2.0).abs() < 1e-4, "{}", regression.values);
        assert!((regression.absorbed(&runs) - 2.0).abs() < 1e-4, "{}", regression.absorbed(&runs));
        let most = regression.left.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        assert!(most < 1e-4, "{most}");
    }
}
