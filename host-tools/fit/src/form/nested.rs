//! A form of the model: what it has beyond the plain one.

use model_core::conditioning::Conditioning;

use super::super::physical::Own;

/// Terms beyond the plain signed model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Form {
    /// What lies between samples and motion.
    pub conditioning: Conditioning<f64>,
    /// What the torque model has of its own.
    pub own: Own,
}
