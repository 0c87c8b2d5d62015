//! What a planned drive will cost: energy with its interval, by legs, and whether the battery has
//! it.
//!
//! A [`Plan`] is a speed profile, a list of legs or the speeds of a log. Its motion passes the
//! filter of the fit, since the coefficients belong to motion behind it; the model's power is
//! summed at the coefficients and at each of them moved a little, which gives the energy's
//! gradient. The interval holds the coefficients' covariance, the mass' uncertainty, and the
//! residual that the fit left.

mod answer;
mod drive;
mod energy;
mod legs;
mod load;
mod plan;
mod reach;
mod report;
pub mod rmf;

pub use self::answer::{Request, predict};
pub use self::report::{Limit, Report};
pub use load::Load;
pub use plan::Plan;
pub use reach::{Need, Question, Reach, reach};
