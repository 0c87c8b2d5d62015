//! A form of the model: the terms it adds to the plain one.

use model_core::conditioning::Conditioning;

use super::super::physical::FreeTerms;

/// Terms beyond the plain signed model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Form {
    /// What lies between samples and motion.
    pub conditioning: Conditioning<f64>,
    /// The terms of the torque model that are free.
    pub free_terms: FreeTerms,
}
