//! Our model and those of the literature, and the paper's figures and tables.
//!
//! Its face: [`baselines`], earlier power models, one trait for all; [`compare`], every model on
//! the same split;
//! [`reproduce`], the paper's experiments from simulation.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod baselines;
pub mod compare;
pub mod reproduce;
