//! Base and effects solved together on whitened residuals, the base held by what its own fit knew.

use nalgebra::{DMatrix, DVector};

use crate::gap::thresholds::problem::RIDGE;

/// What earlier runs say about the base: δᵀΛδ is the penalty of a shift δ from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// Λ, inverse of the covariance.
    pub precision: DMatrix<f64>,
}

/// Sums of products of whitened signals; the last column is the residual. One a run, so that runs can be left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Products {
    /// A matrix a run, per variance of the noise.
    pub runs: Vec<DMatrix<f64>>,
}

/// A solution of the joint problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Of the base, then of the further columns.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// Sum of squares left, the prior's penalty included.
    pub loss: f64,
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

/// Solves for the base and the columns in `active`. `offset` is how far the point of linearisation is from the prior's centre.
pub fn solve(
    total: &DMatrix<f64>,
    base: usize,
    prior: &Prior,
    offset: &DVector<f64>,
    active: &[usize],
) -> Option<Solved> {
    let places: Vec<usize> = (0..base).chain(active.iter().copied()).collect();
    let residual = total.ncols() - 1;
    let size = places.len();
    let mut matrix = DMatrix::from_fn(size, size, |i, j| total[(places[i], places[j])]);
    let mut right = DVector::from_fn(size, |i, _| total[(places[i], residual)]);
    let pull = &prior.precision * offset;
    for i in 0..base {
        right[i] -= pull[i];
        for j in 0..base {
            matrix[(i, j)] += prior.precision[(i, j)];
        }
    }
    let scale = DVector::from_fn(size, |i, _| {
        let own = matrix[(i, i)];
        if own > 0.0 { 1.0 / own.sqrt() } else { 1.0 }
    });
    let scaled = DMatrix::from_fn(size, size, |i, j| {
        let ridge = if i == j { RIDGE } else { 0.0 };
        matrix[(i, j)] * scale[i] * scale[j] + ridge
    });
    let inverse = scaled.cholesky()?.inverse();
    let covariance = DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
    let values = &covariance * &right;
    let loss = total[(residual, residual)] + offset.dot(&pull) - values.dot(&right);
    Some(Solved { values, covariance, loss })
}
