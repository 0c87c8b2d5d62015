//! Ordinary least squares over a few terms of a point: what most regressions of the literature are.

use nalgebra::{DMatrix, DVector};

use super::{Baseline, Parameter, Point};
use crate::error::{Error, Result};

/// A regression of the power on so many terms.
pub struct Regression<const TERMS: usize> {
    /// In refusals.
    name: &'static str,
    /// Symbol and unit of every coefficient.
    symbols: [(&'static str, &'static str); TERMS],
    /// What each coefficient multiplies.
    terms: fn(&Point) -> [f64; TERMS],
    coefficients: Option<[f64; TERMS]>,
}

impl<const TERMS: usize> Regression<TERMS> {
    /// Not fitted.
    pub fn new(
        name: &'static str,
        symbols: [(&'static str, &'static str); TERMS],
        terms: fn(&Point) -> [f64; TERMS],
    ) -> Self {
        Self { name, symbols, terms, coefficients: None }
    }

    /// The coefficients, once fitted.
    pub fn coefficients(&self) -> Option<&[f64; TERMS]> {
        self.coefficients.as_ref()
    }
}

impl<const TERMS: usize> Baseline for Regression<TERMS> {
    /// Terms that repeat others (the mass, where there is only one) get the smallest share.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.coefficients = None;
        let rows = training.iter().map(|point| ((self.terms)(point), point.power));
        let failed = |why: &str| Error::failed(format!("{}: the regression has no {why}solution", self.name));
        let found = least_squares(rows).ok_or_else(|| failed(""))?;
        if found.iter().any(|value| !value.is_finite()) {
            return Err(failed("finite "));
        }
        self.coefficients = Some(found);
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let unfitted = || Error::failed(format!("{}: not fitted", self.name));
        let coefficients = self.coefficients.ok_or_else(unfitted)?;
        let predict = |point: &Point| (self.terms)(point).iter().zip(&coefficients).map(|(x, c)| x * c).sum();
        Ok(points.iter().map(predict).collect())
    }

    fn parameters(&self) -> Vec<Parameter> {
        let values = self.coefficients.iter().flatten();
        let named = |((name, unit), value): (&(&'static str, &'static str), &f64)| Parameter {
            name,
            value: *value,
            unit,
        };
        self.symbols.iter().zip(values).map(named).collect()
    }
}

/// The coefficients that lower the sum of squared residuals most, the smallest where several do. `None` if a sum is
/// not finite.
pub fn least_squares<const TERMS: usize>(
    rows: impl Iterator<Item = ([f64; TERMS], f64)>,
) -> Option<[f64; TERMS]> {
    let mut normal = DMatrix::<f64>::zeros(TERMS, TERMS);
    let mut right = DVector::<f64>::zeros(TERMS);
    for (terms, value) in rows {
        let x = DVector::from_row_slice(&terms);
        normal.ger(1.0, &x, &x, 1.0);
        right.axpy(value, &x, 1.0);
    }
    if normal.iter().chain(&right).any(|sum| !sum.is_finite()) {
        return None;
    }
    let scale = normal.diagonal().map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(TERMS, TERMS, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let solution = scaled.pseudo_inverse(1e-10).ok()? * right.component_mul(&scale);
    Some(std::array::from_fn(|i| solution[i] * scale[i]))
}
