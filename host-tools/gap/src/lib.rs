//! Where model and measurement disagree, which effect is missing, and what remains once it is
//! added.
//!
//! [`investigate`] detects and names with [`residuals`], then [`confirm`]s; [`weighed`] holds the
//! names to one [`likelihood`] of all effects, and [`report`] says what is left. Its face:
//! [`workflow::gap`], from files to the answer.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod bench;
pub mod clean_base;
pub mod confirm;
pub mod driven_plant;
pub mod extension;
pub mod investigate;
pub mod likelihood;
pub mod manoeuvre;
pub mod power_only;
pub mod refit;
pub mod report;
mod rounds;
pub mod simulator;
pub mod weighed;
pub mod words;
pub mod workflow;
