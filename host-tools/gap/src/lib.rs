//! Where model and measurement disagree, which effect is missing, and what is left when it is
//! added.
//!
//! Arrows go one way: [`types`] → [`problem`] (what is asked of which runs) → [`detect`] → [`name`]
//! → [`confirm`] → [`report`]; [`investigate`] walks them, or [`likelihood`] answers in their
//! place. Its face: [`workflow::gap`], from files to all that was found.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod bench;
mod calibrate;
pub mod confirm;
pub mod detect;
pub mod extension;
mod identifiable;
pub mod investigate;
mod late;
pub mod likelihood;
pub mod manoeuvre;
pub mod name;
pub mod noise;
pub mod power_only;
pub mod problem;
pub mod refit;
pub mod report;
mod scope;
pub mod simulation;
pub mod simulator;
pub mod smooth;
pub mod split;
pub mod thresholds;
pub mod twin;
pub mod types;
pub mod user;
pub mod words;
pub mod workflow;
