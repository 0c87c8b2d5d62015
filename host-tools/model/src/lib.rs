//! What a fit knows, and what it may lack.
//!
//! Its face: [`coefficients::CoefficientsFile`], coefficients.toml as one typed value, read and
//! written once; [`effects`], each effect with all there is to say of it: id, unit, sign, range,
//! regressors, cause, words; [`pipeline`], a model at work on samples, as boards run it.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod coefficients;
pub mod effects;
pub mod pipeline;
