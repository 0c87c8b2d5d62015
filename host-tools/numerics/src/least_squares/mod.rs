//! Linear least squares with a Gaussian prior, by normal equations:
//!
//! ```text
//! minimise  |W^½ (r − X δ)|² + (θ + δ − μ)ᵀ P (θ + δ − μ)
//! (XᵀWX + P) δ = XᵀWr − P (θ − μ)
//! ```
//!
//! r is the residual at θ, X its slopes, W the inverse variances of the rows, μ the prior's mean
//! and P its precision (inverse covariance). Columns are brought to unit length before they are
//! factored, so that neither their units nor the damping see each other. The factor is kept:
//! solution, covariance and the score of any further column come from it.

mod factored;
mod score;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector, DVectorView};
use support::job;

pub use self::factored::Factored;
pub use self::score::{FurtherColumn, Score};

/// What earlier data say about the first parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// P, inverse of their covariance.
    pub precision: DMatrix<f64>,
    /// θ − μ: how far the point of linearisation is from the prior's mean.
    pub offset: DVector<f64>,
}

/// The normal matrix cannot be factored: columns that depend on each other without ridge or prior,
/// or values that are not finite.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LeastSquaresError {
    /// Columns depend on each other.
    #[error("the normal matrix is not positive definite: columns depend on each other")]
    NotPositiveDefinite,
    /// A sum is not finite.
    #[error("the normal matrix is not finite")]
    NotFinite,
}

/// Sums of a linear problem: XᵀWX + P, XᵀWr − P (θ − μ), rᵀWr + (θ − μ)ᵀP(θ − μ).
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
}

impl NormalEquations {
    /// Of this number of parameters, without rows.
    pub fn zeros(parameters: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(parameters, parameters),
            right: DVector::zeros(parameters),
            square: 0.0,
        }
    }

    /// From sums: XᵀWX, XᵀWr, rᵀWr.
    pub fn from_sums(matrix: DMatrix<f64>, right: DVector<f64>, square: f64) -> Self {
        Self { matrix, right, square }
    }

    /// From the products of all columns of a panel with each other, the last column being the
    /// residual; the parameters are those of the columns in `places`, in that order.
    pub fn from_products(products: &DMatrix<f64>, places: &[usize]) -> Self {
        let (size, residual) = (places.len(), products.ncols() - 1);
        Self {
            matrix: DMatrix::from_fn(size, size, |i, j| products[(places[i], places[j])]),
            right: DVector::from_fn(size, |i, _| products[(places[i], residual)]),
            square: products[(residual, residual)],
        }
    }

    /// One row: its slopes, residual and weight (inverse variance).
    pub fn add_row(&mut self, slopes: &[f64], residual: f64, weight: f64) {
        let x = DVectorView::from_slice(slopes, self.right.len());
        self.matrix.ger(weight, &x, &x, 1.0);
        self.right.axpy(weight * residual, &x, 1.0);
        self.square += weight * residual * residual;
    }

    /// A prior on the first parameters, as many as it has.
    pub fn add_prior(&mut self, prior: &Prior) {
        let pull = &prior.precision * &prior.offset;
        let known = prior.offset.len();
        let mut matrix = self.matrix.view_mut((0, 0), (known, known));
        matrix += &prior.precision;
        let mut right = self.right.rows_mut(0, known);
        right -= &pull;
        self.square += prior.offset.dot(&pull);
    }

    /// A prior on one parameter alone: its change is 0 give or take `std_dev`.
    pub fn hold(&mut self, parameter: usize, std_dev: f64) {
        self.matrix[(parameter, parameter)] += std_dev.powi(-2);
    }

    /// How many parameters.
    pub fn len(&self) -> usize {
        self.right.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.right.is_empty()
    }

    /// XᵀWX + P.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Factors the problem. `ridge` is added to the diagonal after columns have been brought to
    /// unit length: 0 for none, or some 1e-10 where columns may repeat each other and it does not
    /// matter which takes the credit.
    ///
    /// # Errors
    /// Not positive definite, or not finite.
    pub fn factor(self, ridge: f64) -> Result<Factored, LeastSquaresError> {
        job::point();
        let Self { matrix, right, square } = self;
        if !(square.is_finite() && matrix.iter().chain(&right).all(|sum| sum.is_finite())) {
            return Err(LeastSquaresError::NotFinite);
        }
        let scale = matrix.diagonal().map(|entry| if entry > 0.0 { 1.0 / entry.sqrt() } else { 1.0 });
        let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            matrix[(i, j)] * scale[i] * scale[j] + if i == j { ridge } else { 0.0 }
        });
        let cholesky = scaled.cholesky().ok_or(LeastSquaresError::NotPositiveDefinite)?;
        Ok(Factored::new(cholesky, scale, right, square))
    }
}
