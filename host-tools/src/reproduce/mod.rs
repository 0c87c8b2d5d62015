//! The paper, reproduced: its figures and tables from simulation, the paper's method and ours side by side.

pub mod figures;
pub mod output;
pub mod page;
pub mod price;
pub mod print;
pub mod published;
mod spread;
pub mod standing;
pub mod study;
pub mod table;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use self::study::{Settings, Study};
use crate::error::{Error, Result};

/// Computes everything; `progress` is told which stage begins.
///
/// # Errors
/// What the simulation, a fit or a replay reports.
pub fn run(_settings: &Settings, _progress: &(dyn Fn(&'static str) + Sync)) -> Result<Study> {
    Err(Error::failed("not yet computed"))
}
