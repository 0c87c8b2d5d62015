//! Power models of the literature (the paper's Table 1), to compare with: each fitted and evaluated through one trait.

pub mod card;
pub mod effati;
pub mod jaiem;
pub mod leng;
pub mod liu;
pub mod longitudinal;
pub mod mei;
#[cfg(feature = "mlp")]
pub mod mlp;
pub mod online;
pub mod parasuraman;
pub mod pentzer;
mod point;
pub mod quann;
pub mod recursive;
pub mod regression;
#[cfg(test)]
mod robustness;
pub mod sadrpour;
pub mod skid;
#[cfg(test)]
pub(crate) mod testing;

pub use card::{Card, Layout, Need};
pub use point::{MOST_WHEELS, Point, Readings, Wheels};

use crate::error::Result;

/// Every baseline, in the order of lists and tables.
pub const ALL: &[&Card] = &[
    &sadrpour::RECURSIVE,
    &sadrpour::BAYESIAN,
    &quann::GAUSSIAN_PROCESS,
    &pentzer::RECURSIVE,
    &effati::KNOWN_CENTRES,
    &mei::FIRST_ORDER,
    &jaiem::SECOND_ORDER,
    &parasuraman::SPEED_AND_MASS,
    &leng::ROAD_GRADE,
    &leng::WITH_MASS,
    &liu::LINEAR,
    &liu::POLYNOMIAL,
    #[cfg(feature = "mlp")]
    &mlp::PERCEPTRON,
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
