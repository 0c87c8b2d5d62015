//! Gram matrices: all that a linear fit needs to know of its data.

use model_core::eq18::REGRESSORS;
use nalgebra::{SMatrix, SVector};

/// XᵀX of the 15 products.
pub type Matrix = SMatrix<f64, REGRESSORS, REGRESSORS>;
/// Xᵀp, or coefficients.
pub type Vector = SVector<f64, REGRESSORS>;

/// Sums over rows: XᵀX, Xᵀp, pᵀp, Σp and their number. They add up, so runs can be read one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram {
    /// Lower triangle of XᵀX, row by row.
    xx: [f64; REGRESSORS * (REGRESSORS + 1) / 2],
    xp: [f64; REGRESSORS],
    pp: f64,
    p: f64,
    rows: u64,
}

impl Default for Gram {
    fn default() -> Self {
        Self { xx: [0.0; REGRESSORS * (REGRESSORS + 1) / 2], xp: [0.0; REGRESSORS], pp: 0.0, p: 0.0, rows: 0 }
    }
}

impl Gram {
    /// Adds one row: regressors and measured power (W).
    #[inline]
    pub fn add(&mut self, x: &[f64; REGRESSORS], power: f64) {
        let mut rest = &mut self.xx[..];
        for (i, xi) in x.iter().enumerate() {
            let (row, tail) = rest.split_at_mut(i + 1);
            for (sum, xj) in row.iter_mut().zip(x) {
                *sum += xi * xj;
            }
            rest = tail;
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
        for (sum, value) in self.xx.iter_mut().zip(&other.xx) {
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
    pub fn xx(&self) -> Matrix {
        Matrix::from_fn(|i, j| {
            let (i, j) = (i.max(j), i.min(j));
            self.xx[i * (i + 1) / 2 + j]
        })
    }

    /// Xᵀp.
    pub fn xp(&self) -> Vector {
        Vector::from_column_slice(&self.xp)
    }

    /// Mean squared error of the coefficients, W² (the cost of Eq. 20).
    pub fn cost(&self, beta: &Vector) -> f64 {
        let squares = self.pp - 2.0 * beta.dot(&self.xp()) + beta.dot(&(self.xx() * beta));
        squares.max(0.0) / self.rows.max(1) as f64
    }

    /// The same problem with every column and the power scaled to a root mean square of 1.
    pub fn scaled(&self) -> Scaled {
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
pub struct Scaled {
    /// Scaled XᵀX / rows; 1 on the diagonal, 0 for a column that is zero throughout.
    pub xx: Matrix,
    /// Scaled Xᵀp / rows.
    pub xp: Vector,
    column: Vector,
    power: f64,
}

impl Scaled {
    /// ½ of the scaled mean squared error, without the constant ½ pᵀp.
    pub fn cost(&self, scaled_beta: &Vector) -> f64 {
        scaled_beta.dot(&(self.xx * scaled_beta)) / 2.0 - scaled_beta.dot(&self.xp)
    }

    /// Its gradient.
    pub fn gradient(&self, scaled_beta: &Vector) -> Vector {
        self.xx * scaled_beta - self.xp
    }

    /// Coefficients in physical units.
    pub fn unscale(&self, scaled_beta: &Vector) -> Vector {
        Vector::from_fn(|i, _| scaled_beta[i] * self.power / self.column[i])
    }

    /// Coefficients as the solver sees them.
    pub fn scale(&self, beta: &Vector) -> Vector {
        Vector::from_fn(|i, _| beta[i] * self.column[i] / self.power)
    }

    /// Ratio of the largest to the smallest eigenvalue among columns that are not zero; infinite where columns depend on
    /// each other to rounding.
    pub fn condition(&self) -> f64 {
        let used: Vec<usize> = (0..REGRESSORS).filter(|&i| self.xx[(i, i)] > 0.0).collect();
        if used.is_empty() {
            return f64::INFINITY;
        }
        let matrix = nalgebra::DMatrix::from_fn(used.len(), used.len(), |i, j| self.xx[(used[i], used[j])]);
        let eigenvalues = matrix.symmetric_eigenvalues();
        let (least, most) = (eigenvalues.min(), eigenvalues.max());
        if least > most * 1e-15 { most / least } else { f64::INFINITY }
    }
}
