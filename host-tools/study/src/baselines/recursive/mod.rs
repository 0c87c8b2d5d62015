//! Parameters that are learned while driving: by recursive least squares, with or without a prior.

mod bayes;
mod estimator;
mod forgetting;
mod online;
mod prior;
#[cfg(test)]
mod tests;

pub use self::bayes::Bayes;
pub use self::estimator::Recursive;
pub use self::forgetting::Forgetting;
pub use self::online::{MEMORY_S, Online};
