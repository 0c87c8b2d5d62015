//! The residual of measured power against a model: its noise, its structure, and the effects that
//! explain it.
//!
//! Arrows go one way: [`types`] → [`predictor`] (predicted power of recorded runs) → [`noise`] →
//! [`problem`] (the regression) → [`detect`] (is there structure?) → [`name`] (which effect fits?).
//! Its face: [`problem::Problem`]; the numbers that decide verdicts are in [`thresholds`].
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod calibrate;
pub mod detect;
pub mod identifiable;
pub mod late;
pub mod name;
pub mod noise;
pub mod predictor;
pub mod problem;
pub mod scope;
pub mod smooth;
pub mod split;
pub mod thresholds;
pub mod types;
pub mod user;
