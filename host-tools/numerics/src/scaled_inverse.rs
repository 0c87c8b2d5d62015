//! The inverse of a normal matrix within what it determines.

use nalgebra::{DMatrix, DVector};

/// Eigenvalues of the scaled matrix below this share of the greatest are rounding: sums of some 10⁵
/// products in double precision are good to 10⁻¹¹ of their size.
pub const DETERMINED: f64 = 1e-9;

/// The inverse of a matrix N whose parameters are scaled to a diagonal of ones, so that no unit
/// decides what is determined.
#[derive(Debug, Clone)]
pub struct ScaledInverse {
    /// By what each parameter was multiplied, 1 / √N_ii; 0 for parameters that no row depends on.
    pub unit: DVector<f64>,
    /// The scaled matrix.
    pub scaled: DMatrix<f64>,
    /// Its pseudo-inverse.
    pub inverse: DMatrix<f64>,
    /// Directions (unit vectors of scaled parameters) that it does not determine.
    pub undetermined: Vec<DVector<f64>>,
    /// Ratio of the extreme eigenvalues; infinite where directions are undetermined.
    pub condition: f64,
}

impl ScaledInverse {
    /// Of a normal matrix, symmetric and positive semidefinite.
    pub fn of(normal: &DMatrix<f64>) -> Self {
        let size = normal.nrows();
        let scale = DVector::from_fn(size, |i, _| normal[(i, i)].max(0.0).sqrt());
        let unit = scale.map(|scale| if scale > 0.0 { 1.0 / scale } else { 0.0 });
        let scaled = DMatrix::from_fn(size, size, |i, j| normal[(i, j)] * unit[i] * unit[j]);
        let eigen = scaled.clone().symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let mut inverse = DMatrix::<f64>::zeros(size, size);
        let mut undetermined = Vec::new();
        let mut least = f64::INFINITY;
        for (index, value) in eigen.eigenvalues.iter().enumerate() {
            let direction = eigen.eigenvectors.column(index).into_owned();
            if *value > DETERMINED * most {
                inverse.ger(1.0 / value, &direction, &direction, 1.0);
                least = least.min(*value);
            } else {
                undetermined.push(direction);
            }
        }
        let condition = if undetermined.is_empty() { most / least } else { f64::INFINITY };
        Self { unit, scaled, inverse, undetermined, condition }
    }

    /// A matrix of scaled parameters in those of N.
    pub fn unscaled(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let size = matrix.nrows();
        DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * self.unit[i] * self.unit[j])
    }
}
