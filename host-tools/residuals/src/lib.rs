//! What measured power has beyond a model's.
//!
//! Arrows go one way: [`types`] → [`twin`] (what model and effects say of recorded runs) →
//! [`noise`] → [`problem`] (what is asked of which runs) → [`detect`] (what shows) → [`name`] (what
//! fits). Its face: [`problem::Problem`]; the numbers on which verdicts hang are in [`thresholds`].
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod calibrate;
pub mod detect;
pub mod identifiable;
pub mod late;
pub mod name;
pub mod noise;
pub mod problem;
pub mod scope;
pub mod smooth;
pub mod split;
pub mod thresholds;
pub mod twin;
pub mod types;
pub mod user;
