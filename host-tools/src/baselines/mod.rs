//! Power models of the literature (the paper's Table 1), to compare with: each fitted and evaluated through one trait.

pub mod card;
pub mod leng;
pub mod network;
mod point;
pub mod regression;
#[cfg(test)]
pub(crate) mod testing;

pub use card::{Card, Layout, Need};
pub use point::{MOST_WHEELS, Point, Readings, Wheels};

use crate::error::Result;

/// Every baseline, in the order of lists and tables.
pub const ALL: &[&Card] = &[
    &leng::WITH_MASS,
    &network::PERCEPTRON,
    &network::LIU,
    &network::GORA,
    &network::SAKAYORI,
    &network::CHIKUSHI,
];

/// A model that learns power from points.
pub trait Baseline {
    /// Learns from training points.
    ///
    /// # Errors
    /// What makes these points unfit for it.
    fn fit(&mut self, training: &[Point]) -> Result<()>;

    /// Predicted power of every point, W, in their order; NaN where a point is not finite.
    ///
    /// A method that learns while it drives (recursive least squares) may learn from the power of the points before
    /// each, within one run; the others leave [`Point::power`] alone.
    ///
    /// # Errors
    /// It has not been fitted.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>>;

    /// What it has learned, where that has names; nothing before it is fitted.
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
