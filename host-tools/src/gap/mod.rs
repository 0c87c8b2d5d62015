//! The gap workflow: where model and measurement disagree, which effect is missing, and what is left when it is added.

pub mod advice;
pub mod bench;
pub mod confirm;
mod detect;
pub mod dictionary;
#[cfg(test)]
mod example;
pub mod excess;
pub mod extended;
pub mod inquiry;
pub mod investigate;
pub mod joint;
pub mod lag;
pub mod localise;
pub mod manoeuvre;
mod naming;
pub mod noise;
mod opening;
pub mod output;
pub mod page;
pub mod panel;
pub mod power_only;
mod rivals;
pub mod scan;
pub mod shape;
pub mod simulation;
pub mod smooth;
pub mod split;
pub mod spread;
pub mod summary;
pub mod twin;
pub mod user;
pub mod whiten;
pub mod words;

pub use crate::log::{checks as input, motions as edges, runs};
