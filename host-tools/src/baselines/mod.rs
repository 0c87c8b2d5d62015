//! Power models of the literature (the paper's Table 1), to compare with: each fitted and evaluated through one trait.
//!
//! Kumar, Bensekrane and Merzouki (2022) are not among them. Their bond graph is a way to write equations down, not
//! another set of them: joined at its 0- and 1-junctions, its inertias, resistances and transformers give the dynamics of
//! a robot with friction and without motor losses, which is [`physics::cards::TOUZOUT`] for wheels that do not steer.
//! What is their own belongs to a car-like robot with four steered wheels that changes its structure: power of the
//! steering, and kinematics that depend on steering angles. No log here has steering angles, and R is one constant matrix,
//! so that part has neither input nor data to be fitted to; without it the baseline would be Touzout's under another name.

pub mod card;
pub mod dynamics;
pub mod effati;
pub mod jaiem;
pub mod leng;
pub mod liu;
pub mod longitudinal;
pub mod mei;
pub mod network;
pub mod online;
pub mod parasuraman;
pub mod pentzer;
pub mod physics;
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
mod training;

pub use card::{Card, Layout, Need};
pub use point::{MOST_WHEELS, Point, Readings, Wheels};

use crate::error::Result;

/// Every baseline, in the order of lists and tables.
pub const ALL: &[&Card] = &[
    &dynamics::cards::KIM,
    &dynamics::cards::JARAMILLO,
    &dynamics::cards::MORALES,
    &dynamics::cards::YACOUB,
    &dynamics::cards::YAO,
    &sadrpour::RECURSIVE,
    &sadrpour::BAYESIAN,
    &quann::GAUSSIAN_PROCESS,
    &physics::cards::WAHAB,
    &physics::cards::TOUZOUT,
    &physics::cards::ANJUM,
    &physics::cards::DATOUO,
    &physics::cards::HOU,
    &physics::cards::DOGRU,
    &pentzer::RECURSIVE,
    &effati::KNOWN_CENTRES,
    &mei::FIRST_ORDER,
    &jaiem::SECOND_ORDER,
    &parasuraman::SPEED_AND_MASS,
    &leng::ROAD_GRADE,
    &leng::WITH_MASS,
    &liu::LINEAR,
    &liu::POLYNOMIAL,
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
