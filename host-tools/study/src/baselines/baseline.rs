//! What every baseline can do.

use support::error::Result;

use super::point::Point;

/// A model that learns power from points.
pub trait Baseline: Send {
    /// Learns from training points.
    ///
    /// # Errors
    /// What makes these points unfit for it.
    fn fit(&mut self, training: &[Point]) -> Result<()>;

    /// Predicted power of every point, W, in their order; NaN where a point is not finite.
    ///
    /// A method that learns while it drives (recursive least squares) may learn from the power of
    /// the points before each, within one run; the others leave [`Point::power`] alone.
    ///
    /// # Errors
    /// It has not been fitted.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>>;

    /// The mass that a model itself estimates at every point from the powers before, kg; `None` of
    /// other models.
    ///
    /// # Errors
    /// It has not been fitted.
    fn masses(&self, points: &[Point]) -> Result<Option<Vec<f64>>> {
        let _ = points;
        Ok(None)
    }

    /// What it has learned, where that has names; empty before a fit.
    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }
}

/// One learned number.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Parameter {
    /// Its symbol in the source.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// Symbol and unit of a coefficient.
pub type Symbol = (&'static str, &'static str);

/// The values with their symbols.
pub(super) fn named(symbols: impl IntoIterator<Item = Symbol>, values: &[f64]) -> Vec<Parameter> {
    let parameter = |((name, unit), value): (Symbol, &f64)| Parameter { name, value: *value, unit };
    symbols.into_iter().zip(values).map(parameter).collect()
}
