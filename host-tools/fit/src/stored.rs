//! A fit as coefficients.toml keeps it.

use model::coefficients::{CoefficientsFile, FittedLog, ModelKind, Origin, TORQUE};
use nalgebra::DMatrix;
use support::error::Result;

use super::{Fit, usable};

impl Fit {
    /// Of the parameters that both sides share: the imbalance, which is the last, may be anything
    /// that its own scatter allows.
    fn shared_covariance(&self) -> DMatrix<f64> {
        let all = &self.uncertainty.covariance;
        let size = match self.kind {
            ModelKind::Signed => TORQUE.len() - usize::from(!self.robot.scrubs()),
            ModelKind::Eq18 | ModelKind::Eq18Published => all.nrows(),
        };
        all.view((0, 0), (size, size)).into_owned()
    }

    /// What is written of it.
    ///
    /// # Errors
    /// A log that can no longer be read.
    pub fn to_file<const N: usize>(&self) -> Result<CoefficientsFile<N>> {
        Ok(CoefficientsFile {
            coefficients: self.coefficients(),
            kind: self.kind,
            method: self.method,
            joint_covariance: None,
            covariance: self.shared_covariance(),
            effects: Vec::new(),
            origin: Origin {
                logs: self.files.iter().map(|log| FittedLog::now(log)).collect::<Result<_>>()?,
                rows: self.rows,
                masses_kg: self.masses.clone(),
                static_power_w: self.robot.static_power(),
                r2: self.quality.r2,
                rmse_w: self.quality.rmse_w,
                energy_std_share: self.energy_std_share,
                energy_std_w: self.energy_std_w,
                usability: usable::usability(self.defect.as_ref()),
            },
        })
    }
}
