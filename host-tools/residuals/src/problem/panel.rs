//! The model made linear about a state, whitened: columns of base, discrepancy, effects and tests,
//! and the residual.

use model::effects::Regressor;
use nalgebra::{DMatrix, DVector, DVectorView};

use super::Problem;
use crate::noise::whiten::Signal;
use crate::predictor::State;

/// Signals that are the same at every state, whitened, with their sums of products: the base's
/// errors on clean runs.
#[derive(Debug, Clone, Default)]
pub struct Fixed {
    /// A matrix a run, a column a signal.
    pub runs: Vec<DMatrix<f64>>,
    /// Their products.
    pub products: Vec<DMatrix<f64>>,
}

impl Fixed {
    /// Of signals that are whitened already.
    pub fn new(signals: &[Signal], lengths: &[usize]) -> Self {
        let runs: Vec<DMatrix<f64>> = lengths
            .iter()
            .enumerate()
            .map(|(run, &rows)| {
                DMatrix::from_iterator(
                    rows,
                    signals.len(),
                    signals.iter().flat_map(|signal| signal[run].iter().copied()),
                )
            })
            .collect();
        let products = runs.iter().map(|run| run.transpose() * run).collect();
        Self { runs, products }
    }

    /// How many signals there are.
    pub fn len(&self) -> usize {
        self.runs.first().map_or(0, DMatrix::ncols)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Sums of products of whitened signals; the last column is the residual. One a run, so that runs
/// can be left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Products {
    /// A matrix a run, per variance of the noise.
    pub runs: Vec<DMatrix<f64>>,
}

impl Products {
    /// Of the runs that are not left out.
    pub fn total(&self, left_out: Option<usize>) -> DMatrix<f64> {
        let size = self.runs.first().map_or(0, DMatrix::nrows);
        let mut total = DMatrix::zeros(size, size);
        for (_, run) in self.runs.iter().enumerate().filter(|(place, _)| Some(*place) != left_out) {
            total += run;
        }
        total
    }
}

/// Whitened columns in the order base, fixed, others, residual.
#[derive(Debug)]
pub struct Panel<'a> {
    fixed: &'a Fixed,
    /// Base, others and residual, per standard deviation of the noise; a matrix a run.
    moving: Vec<DMatrix<f64>>,
    base: usize,
}

impl<'a> Panel<'a> {
    /// About `state`: base, regressors, and signals that are whitened already.
    pub(super) fn new(
        problem: &'a Problem<'_>,
        state: &State,
        regressors: &[Regressor],
        signals: &[Signal],
    ) -> Self {
        let Problem { predictor, noise, base, discrepancy: fixed, still, .. } = problem;
        let moving = (0..predictor.runs.runs.len()).map(|place| {
            let (columns, residual) = match still.get(place) {
                Some(Some(still)) => {
                    (vec![vec![0.0; still.white.len()]; regressors.len()], still.white.as_slice().to_vec())
                }
                _ => {
                    let mut columns = predictor.columns(place, state, *base, regressors);
                    for column in &mut columns {
                        *column = noise.whiten(predictor.runs, place, column);
                    }
                    let residual = columns.pop().unwrap_or_default();
                    (columns, residual)
                }
            };
            let all = columns.iter().chain(signals.iter().map(|signal| &signal[place])).chain([&residual]);
            let all: Vec<&[f64]> = all.map(Vec::as_slice).collect();
            DMatrix::from_vec(residual.len(), all.len(), all.concat())
        });
        Self { fixed, moving: moving.collect(), base: *base }
    }

    /// Sums of products.
    pub fn products(&self) -> Products {
        let (base, fixed) = (self.base, self.fixed.len());
        let runs = self.moving.iter().enumerate().map(|(place, moving)| {
            let products = transposed_times(moving, moving);
            let size = moving.ncols() + fixed;
            let at = |column: usize| if column < base { column } else { column + fixed };
            let mut all = DMatrix::zeros(size, size);
            for i in 0..moving.ncols() {
                for j in 0..moving.ncols() {
                    all[(at(i), at(j))] = products[(i, j)];
                }
            }
            if fixed > 0 {
                let cross = transposed_times(moving, &self.fixed.runs[place]);
                all.view_mut((base, base), (fixed, fixed)).copy_from(&self.fixed.products[place]);
                for i in 0..fixed {
                    for j in 0..moving.ncols() {
                        all[(base + i, at(j))] = cross[(j, i)];
                        all[(at(j), base + i)] = cross[(j, i)];
                    }
                }
            }
            all
        });
        Products { runs: runs.collect() }
    }

    /// A column of one run.
    pub fn column(&self, run: usize, column: usize) -> DVectorView<'_, f64> {
        let fixed = self.fixed.len();
        if column < self.base {
            self.moving[run].column(column)
        } else if column < self.base + fixed {
            self.fixed.runs[run].column(column - self.base)
        } else {
            self.moving[run].column(column - fixed)
        }
    }

    /// The residual of one run.
    pub fn residual(&self, run: usize) -> DVectorView<'_, f64> {
        self.moving[run].column(self.moving[run].ncols() - 1)
    }

    /// The first `count` columns of one run, times a column.
    pub fn head_products(&self, run: usize, count: usize, column: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(count, |i, _| self.column(run, i).dot(column))
    }

    /// A column less its regression on others, run by run.
    pub fn projected(&self, column: usize, on: &[usize], by: &DVector<f64>) -> Signal {
        (0..self.moving.len())
            .map(|run| {
                let mut remainder = self.column(run, column).into_owned();
                for (&other, factor) in on.iter().zip(by.iter()) {
                    remainder.axpy(-factor, &self.column(run, other), 1.0);
                }
                remainder.as_slice().to_vec()
            })
            .collect()
    }
}

/// aᵀ b. nalgebra gives no product of up to five rows to its fast routine: those are dot products.
fn transposed_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    const FEW: usize = 5;
    if a.ncols() <= FEW { a.tr_mul(b) } else { a.transpose() * b }
}
