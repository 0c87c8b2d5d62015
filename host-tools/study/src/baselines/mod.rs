//! Power models of the literature (the paper's Table 1): one engine a family, with each source's
//! terms as data ([`cards`]). All are fitted and evaluated through one trait.

mod baseline;
mod card;
pub mod cards;
pub mod dynamics;
pub mod longitudinal;
pub mod network;
pub mod physics;
mod point;
pub mod process;
pub mod recursive;
pub mod regression;
#[cfg(test)]
mod robustness;
#[cfg(test)]
pub(crate) mod testing;
mod training;

pub use baseline::{Baseline, Parameter, Symbol};
pub use card::{Card, Family, Layout, Need, PowerOfBraking, Preset};
pub use cards::{ALL, BEYOND, every, families};
pub use point::{Point, Readings};
