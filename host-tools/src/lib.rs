//! The library behind `gmr`: logs, the simulated plant, fits, baselines and reports.
//!
//! What the board computes as well (filters, models, payload estimators) is not here but in `model-core`.

pub mod baselines;
pub mod cli;
pub mod compare;
pub mod error;
pub mod estimate;
pub mod fit;
pub mod inspect;
pub mod log;
pub mod metrics;
pub mod output;
pub mod plant;
pub mod progress;
pub mod report;
pub mod robot;
