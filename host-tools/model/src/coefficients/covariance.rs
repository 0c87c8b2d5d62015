//! The covariance of the parameters, as matrices that can be one.

use nalgebra::DMatrix;

use super::error::InvalidCovariance;

/// Entries across the diagonal may differ by this share of √(c_ii c_jj), and variances lie below 0
/// by this share of the largest entry of their row: sums of some 10⁵ products in double precision,
/// through a matrix with a condition of up to 10⁶.
const ROUNDING: f64 = 1e-6;

/// Correlations lie above 1 by so much at most: rounding where one direction is all but
/// undetermined is larger than elsewhere.
const CORRELATION_ROUNDING: f64 = 1e-3;

/// A covariance as a fit computed it, without what rounding did to it.
///
/// # Errors
/// It is none, by more than rounding.
pub(super) fn rounded(matrix: &DMatrix<f64>) -> Result<DMatrix<f64>, InvalidCovariance> {
    let mut matrix = matrix.clone();
    if matrix.is_square() {
        for index in 0..matrix.nrows() {
            let largest = matrix.row(index).iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let variance = &mut matrix[(index, index)];
            if *variance < 0.0 && -*variance <= ROUNDING * largest {
                *variance = 0.0;
            }
        }
    }
    let size = matrix.nrows();
    check(&matrix, size)?;
    Ok((&matrix + matrix.transpose()) * 0.5)
}

/// The covariance of `size` parameters of a file's rows.
///
/// # Errors
/// They are none.
pub(super) fn of_rows(rows: &[Vec<f64>], size: usize) -> Result<DMatrix<f64>, InvalidCovariance> {
    if rows.len() != size || rows.iter().any(|row| row.len() != size) {
        return Err(InvalidCovariance::Entries { size });
    }
    let matrix = DMatrix::from_fn(size, size, |i, j| rows[i][j]);
    check(&matrix, size)?;
    Ok(matrix)
}

fn check(matrix: &DMatrix<f64>, size: usize) -> Result<(), InvalidCovariance> {
    if matrix.shape() != (size, size) || matrix.iter().any(|x| !x.is_finite()) {
        return Err(InvalidCovariance::Entries { size });
    }
    for (index, &value) in matrix.diagonal().iter().enumerate() {
        if value < 0.0 {
            return Err(InvalidCovariance::Variance { row: index + 1, value });
        }
    }
    for i in 0..size {
        for j in i + 1..size {
            let (above, below) = (matrix[(i, j)], matrix[(j, i)]);
            let scale = (matrix[(i, i)] * matrix[(j, j)]).sqrt().max(f64::MIN_POSITIVE);
            // Beside a variance of 0 only rounding is left, of a size that nothing here tells: both
            // are then taken for it.
            let tells = matrix[(i, i)] > 0.0 && matrix[(j, j)] > 0.0;
            if tells && (above - below).abs() > ROUNDING * scale {
                return Err(InvalidCovariance::Asymmetric { row: i + 1, column: j + 1, above, below });
            }
            let correlation = above / scale;
            if tells && correlation.abs() > 1.0 + CORRELATION_ROUNDING {
                return Err(InvalidCovariance::Correlation { row: i + 1, column: j + 1, correlation });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(entries: [[f64; 2]; 2]) -> Vec<Vec<f64>> {
        entries.iter().map(|row| row.to_vec()).collect()
    }

    #[test]
    fn what_is_no_covariance_is_refused_by_kind() {
        assert!(of_rows(&rows([[4.0, -1.0], [-1.0, 1.0]]), 2).is_ok());
        let refused = |entries, size| of_rows(&rows(entries), size).unwrap_err();
        let numbers = InvalidCovariance::Entries { size: 2 };
        assert_eq!(refused([[f64::NAN, 0.0], [0.0, 1.0]], 2), numbers);
        assert_eq!(refused([[1.0, f64::INFINITY], [0.0, 1.0]], 2), numbers);
        assert_eq!(refused([[1.0, 0.0], [0.0, 1.0]], 3), InvalidCovariance::Entries { size: 3 });
        let negative = InvalidCovariance::Variance { row: 2, value: -1.0 };
        assert_eq!(refused([[1.0, 0.0], [0.0, -1.0]], 2), negative);
        let skewed = InvalidCovariance::Asymmetric { row: 1, column: 2, above: 0.5, below: 0.25 };
        assert_eq!(refused([[1.0, 0.5], [0.25, 1.0]], 2), skewed);
        let refusal = InvalidCovariance::Correlation { row: 1, column: 2, correlation: -1.5 };
        assert_eq!(refused([[4.0, -3.0], [-3.0, 1.0]], 2), refusal);
    }

    /// Rounding is mended, and nothing beyond it.
    #[test]
    fn a_fit_s_covariance_is_symmetric_and_not_negative() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5 + 1e-12, -1e-12]);
        let mended = rounded(&matrix).unwrap();
        assert_eq!(mended[(1, 1)], 0.0);
        assert_eq!(mended[(0, 1)], mended[(1, 0)]);
        for wrong in [[1.0, 0.5, 0.5, -0.1], [1.0, 0.5, 0.6, 1.0], [f64::NAN, 0.0, 0.0, 1.0]] {
            assert!(rounded(&DMatrix::from_row_slice(2, 2, &wrong)).is_err(), "{wrong:?}");
        }
    }
}
