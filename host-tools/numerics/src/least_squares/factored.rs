//! A problem whose Cholesky factor is known: solution, covariance, what is left.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

/// A problem whose Cholesky factor is known.
#[derive(Debug, Clone)]
pub struct Factored {
    cholesky: Cholesky<f64, Dyn>,
    /// Inverse lengths of the columns.
    scale: DVector<f64>,
    right: DVector<f64>,
    square: f64,
}

impl Factored {
    /// With the factor of the matrix between columns of unit length, `scale` being their inverse
    /// lengths.
    pub(super) fn new(
        cholesky: Cholesky<f64, Dyn>,
        scale: DVector<f64>,
        right: DVector<f64>,
        square: f64,
    ) -> Self {
        Self { cholesky, scale, right, square }
    }

    /// (XᵀWX + P)⁻¹ b.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut solution = right.component_mul(&self.scale);
        self.cholesky.solve_mut(&mut solution);
        solution.component_mul_assign(&self.scale);
        solution
    }

    /// δ.
    pub fn solution(&self) -> DVector<f64> {
        self.solve(&self.right)
    }

    /// Covariance of δ, where weights and prior are right: (XᵀWX + P)⁻¹.
    pub fn covariance(&self) -> DMatrix<f64> {
        let inverse = self.cholesky.inverse();
        DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, j| {
            inverse[(i, j)] * self.scale[i] * self.scale[j]
        })
    }

    /// What is left of the sum of squares at δ, the prior's charge included.
    pub fn loss(&self) -> f64 {
        self.square - self.right.dot(&self.solution())
    }

    /// XᵀWr − P (θ − μ).
    pub fn right(&self) -> &DVector<f64> {
        &self.right
    }

    /// Effective number of parameters that data with the normal matrix `data` (without prior and
    /// ridge) determine: tr(H⁻¹ XᵀWX).
    pub fn determined(&self, data: &DMatrix<f64>) -> f64 {
        // The trace of a product, both factors symmetric.
        self.covariance().dot(data)
    }
}
