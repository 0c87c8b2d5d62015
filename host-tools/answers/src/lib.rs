//! What is asked of logs with a fit, or without one: a module a question.
//!
//! Its face: [`inspect`], what a log is worth; [`look`], what is in any log, without a robot.toml;
//! [`estimate`], a log replayed through the board's pipeline; [`predict`], the energy of a planned
//! drive; [`export`], a fit in the words of other programs.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod estimate;
pub mod export;
pub mod inspect;
pub mod look;
pub mod predict;
