//! Terms and powers of points, and the coefficients between them.

use nalgebra::{DMatrix, DVector, DVectorView};
use support::error::{Error, Result};

use crate::baselines::point::Point;

/// Terms of a point, and its power.
pub type Observation<T> = (T, f64);

/// The terms and the power of every training point.
///
/// # Errors
/// Fewer points than terms, or a point whose terms or power are not finite.
pub fn rows<T: AsRef<[f64]>>(
    name: &str,
    training: &[Point],
    terms: impl Fn(&Point) -> T,
) -> Result<Vec<Observation<T>>> {
    let rows: Vec<_> = training.iter().map(|point| (terms(point), point.power)).collect();
    let expected = rows.first().map_or(1, |(terms, _)| terms.as_ref().len());
    if rows.len() < expected {
        return Err(Error::failed(format!(
            "{name}: {} training points; expected at least {expected}, one for each coefficient",
            rows.len()
        )));
    }
    let broken = |(terms, power): &Observation<T>| {
        !(power.is_finite() && terms.as_ref().iter().all(|term| term.is_finite()))
    };
    if let Some(index) = rows.iter().position(broken) {
        let (terms, power) = &rows[index];
        return Err(Error::failed(format!(
            "{name}: training point {index} has the terms {:?} and a power of {power} W; expected finite numbers",
            terms.as_ref()
        )));
    }
    Ok(rows)
}

/// The coefficients that lower the sum of squared residuals most, the smallest where several do.
/// `None` without rows, and if a sum is not finite.
pub fn least_squares<T: AsRef<[f64]>>(rows: &[Observation<T>]) -> Option<Vec<f64>> {
    let count = rows.first()?.0.as_ref().len();
    let mut normal = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    for (terms, value) in rows {
        let x = DVectorView::from_slice(terms.as_ref(), count);
        normal.ger(1.0, &x, &x, 1.0);
        right.axpy(*value, &x, 1.0);
    }
    solution(&normal, &right)
}

fn solution(normal: &DMatrix<f64>, right: &DVector<f64>) -> Option<Vec<f64>> {
    if normal.iter().chain(right).any(|sum| !sum.is_finite()) {
        return None;
    }
    let scale = normal.diagonal().map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(right.len(), right.len(), |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let solution = (scaled.pseudo_inverse(1e-10).ok()? * right.component_mul(&scale)).component_mul(&scale);
    solution.iter().all(|value| value.is_finite()).then(|| solution.as_slice().to_vec())
}

/// Σ c x, W; NaN if that is not finite.
pub fn weigh(terms: &[f64], coefficients: &[f64]) -> f64 {
    let sum: f64 = terms.iter().zip(coefficients).map(|(x, c)| x * c).sum();
    if sum.is_finite() { sum } else { f64::NAN }
}

/// Asked to predict before it has learned.
pub fn unfitted(name: &str) -> Error {
    Error::failed(format!("{name}: not fitted"))
}
