//! Gram matrices: all that a linear fit needs to know of its data. `P` is the number of regressors.

use nalgebra::{SMatrix, SVector};

/// XᵀX of `P` products.
pub type Matrix<const P: usize> = SMatrix<f64, P, P>;
/// Xᵀp, or coefficients.
pub type Vector<const P: usize> = SVector<f64, P>;

/// Sums over rows: XᵀX, Xᵀp, pᵀp, Σp and their number. They add up, so runs can be read one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram<const P: usize> {
    /// XᵀX, the lower triangle; zeros above.
    xx: [[f64; P]; P],
    xp: [f64; P],
    pp: f64,
    p: f64,
    rows: u64,
}

impl<const P: usize> Default for Gram<P> {
    fn default() -> Self {
        Self { xx: [[0.0; P]; P], xp: [0.0; P], pp: 0.0, p: 0.0, rows: 0 }
    }
}

impl<const P: usize> Gram<P> {
    /// Adds one row: regressors and measured power (W).
    #[inline]
    pub fn add(&mut self, x: &[f64; P], power: f64) {
        for (i, (row, xi)) in self.xx.iter_mut().zip(x).enumerate() {
            for (sum, xj) in row.iter_mut().zip(x).take(i + 1) {
                *sum += xi * xj;
            }
        }
        for (sum, xi) in self.xp.iter_mut().zip(x) {
            *sum += xi * power;
        }
        self.pp += power * power;
        self.p += power;
        self.rows += 1;
    }

    /// Adds another's sums.
    pub fn merge(&mut self, other: &Self) {
        for (sum, value) in self.xx.iter_mut().flatten().zip(other.xx.iter().flatten()) {
            *sum += value;
        }
        for (sum, value) in self.xp.iter_mut().zip(&other.xp) {
            *sum += value;
        }
        self.pp += other.pp;
        self.p += other.p;
        self.rows += other.rows;
    }

    /// Rows summed.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// XᵀX.
    pub fn xx(&self) -> Matrix<P> {
        Matrix::from_fn(|i, j| self.xx[i.max(j)][i.min(j)])
    }

    /// Xᵀp.
    pub fn xp(&self) -> Vector<P> {
        Vector::from_column_slice(&self.xp)
    }

    /// Mean squared error of the coefficients, W² (the cost of Eq. 20).
    pub fn cost(&self, beta: &Vector<P>) -> f64 {
        let squares = self.pp - 2.0 * beta.dot(&self.xp()) + beta.dot(&(self.xx() * beta));
        squares.max(0.0) / self.rows.max(1) as f64
    }

    /// The same problem with every column and the power scaled to a root mean square of 1.
    pub fn scaled(&self) -> Scaled<P> {
        let rows = self.rows.max(1) as f64;
        let xx = self.xx();
        let unit = |square: f64| if square > 0.0 { (square / rows).sqrt() } else { 1.0 };
        let column = Vector::from_fn(|i, _| unit(xx[(i, i)]));
        let power = unit(self.pp);
        Scaled {
            xx: Matrix::from_fn(|i, j| xx[(i, j)] / (rows * column[i] * column[j])),
            xp: Vector::from_fn(|i, _| self.xp[i] / (rows * column[i] * power)),
            column,
            power,
        }
    }
}

/// A Gram matrix with unit diagonal: what a solver sees.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaled<const P: usize> {
    /// Scaled XᵀX / rows; 1 on the diagonal, 0 for a column that is zero throughout.
    pub xx: Matrix<P>,
    /// Scaled Xᵀp / rows.
    pub xp: Vector<P>,
    column: Vector<P>,
    power: f64,
}

impl<const P: usize> Scaled<P> {
    /// ½ of the scaled mean squared error, without the constant ½ pᵀp.
    pub fn cost(&self, scaled_beta: &Vector<P>) -> f64 {
        scaled_beta.dot(&(self.xx * scaled_beta)) / 2.0 - scaled_beta.dot(&self.xp)
    }

    /// Its gradient.
    pub fn gradient(&self, scaled_beta: &Vector<P>) -> Vector<P> {
        self.xx * scaled_beta - self.xp
    }

    /// Coefficients in physical units.
    pub fn unscale(&self, scaled_beta: &Vector<P>) -> Vector<P> {
        Vector::from_fn(|i, _| scaled_beta[i] * self.power / self.column[i])
    }

    /// Coefficients as the solver sees them.
    pub fn scale(&self, beta: &Vector<P>) -> Vector<P> {
        Vector::from_fn(|i, _| beta[i] * self.column[i] / self.power)
    }

    /// Ratio of the largest to the smallest eigenvalue among columns that are not zero; infinite where columns depend on
    /// each other to rounding.
    pub fn condition(&self) -> f64 {
        let used: Vec<usize> = (0..P).filter(|&i| self.xx[(i, i)] > 0.0).collect();
        if used.is_empty() {
            return f64::INFINITY;
        }
        let matrix = nalgebra::DMatrix::from_fn(used.len(), used.len(), |i, j| self.xx[(used[i], used[j])]);
        let eigenvalues = matrix.symmetric_eigenvalues();
        let (least, most) = (eigenvalues.min(), eigenvalues.max());
        if least > most * 1e-15 { most / least } else { f64::INFINITY }
    }
}
