//! A fit as coefficients.toml keeps it.

use super::Fit;
use crate::coefficients::{CoefficientsFile, FittedLog, Origin};
use crate::error::Result;

impl<const N: usize> Fit<N> {
    /// What is written of it.
    ///
    /// # Errors
    /// A log that can no longer be read.
    pub fn to_file(&self) -> Result<CoefficientsFile<N>> {
        Ok(CoefficientsFile {
            coefficients: self.coefficients,
            kind: self.kind,
            method: self.method,
            joint_covariance: None,
            covariance: self.uncertainty.covariance.clone(),
            effects: Vec::new(),
            origin: Origin {
                logs: self.files.iter().map(|log| FittedLog::now(log)).collect::<Result<_>>()?,
                rows: self.rows,
                masses_kg: self.masses.clone(),
                static_power_w: self.coefficients.robot.static_power,
                r2: self.quality.r2,
                rmse_w: self.quality.rmse_w,
            },
        })
    }
}
