//! Ordinary least squares over a few terms of a point: what most regressions of the literature are.

mod least_squares;
pub mod term;
#[cfg(test)]
mod tests;
mod wheels;

use logs::robot::Robot;
use support::error::{Error, Result};

pub use self::least_squares::{Observation, least_squares, rows, unfitted, weigh};
pub use self::term::{Body, Listed, Term};
use self::wheels::WheelSpeeds;
use super::baseline::{Baseline, Parameter, named};
use super::point::Point;

/// A regression of the power on terms of a point.
pub struct Regression {
    /// In refusals.
    name: &'static str,
    terms: Terms,
    coefficients: Option<Vec<f64>>,
}

/// The values that coefficients multiply: the same number for every point.
enum Terms {
    Listed(&'static [Listed], Body),
    Wheels(WheelSpeeds),
}

impl Regression {
    /// Not fitted, with a coefficient for each of these terms.
    pub fn new(name: &'static str, terms: &'static [Listed], robot: &Robot) -> Self {
        Self { name, terms: Terms::Listed(terms, Body::of(robot)), coefficients: None }
    }

    /// Not fitted, on the commanded and measured speeds of this robot's wheels, and on their
    /// products.
    pub fn of_wheels(name: &'static str, products: bool, robot: &Robot) -> Self {
        Self { name, terms: Terms::Wheels(WheelSpeeds::of(robot, products)), coefficients: None }
    }

    /// The coefficients, once fitted.
    pub fn coefficients(&self) -> Option<&[f64]> {
        self.coefficients.as_deref()
    }

    fn terms(&self, point: &Point) -> Vec<f64> {
        match &self.terms {
            Terms::Listed(terms, body) => terms.iter().map(|(.., term)| term.of(point, body)).collect(),
            Terms::Wheels(wheels) => wheels.terms(point),
        }
    }
}

impl Baseline for Regression {
    /// Terms that repeat others (the mass, where there is only one) get the smallest share.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.coefficients = None;
        let rows = rows(self.name, training, |point| self.terms(point))?;
        let failed = || Error::failed(format!("{}: the regression has no finite solution", self.name));
        self.coefficients = Some(least_squares(&rows).ok_or_else(failed)?);
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let coefficients = self.coefficients.as_ref().ok_or_else(|| unfitted(self.name))?;
        Ok(points.iter().map(|point| weigh(&self.terms(point), coefficients)).collect())
    }

    fn parameters(&self) -> Vec<Parameter> {
        let values = self.coefficients.as_deref().unwrap_or_default();
        match &self.terms {
            Terms::Listed(terms, _) => named(terms.iter().map(|(name, unit, _)| (*name, *unit)), values),
            Terms::Wheels(wheels) => named(wheels.symbols(), values),
        }
    }
}
