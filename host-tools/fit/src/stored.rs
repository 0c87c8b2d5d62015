//! A fit as coefficients.toml keeps it.

use model::coefficients::{CoefficientsFile, FittedLog, ModelKind, Origin, TORQUE};
use model_core::model::Model;
use nalgebra::DMatrix;
use support::error::Result;

use super::{Fit, usable};

impl Fit {
    /// Of the parameters that both sides share. The imbalance may be anything that its own scatter
    /// allows. The gear's loss is as it was found: the inertia gain makes up for nearly all that it
    /// might be else, and a model that keeps the loss does not have that scatter.
    pub fn shared_covariance(&self) -> DMatrix<f64> {
        let all = &self.uncertainty.covariance;
        let size = match self.kind {
            ModelKind::Signed => TORQUE.len() - usize::from(!self.robot.scrubs()),
            ModelKind::Eq18 | ModelKind::Eq18Published => all.nrows(),
        };
        let shared = all.view((0, 0), (size, size)).into_owned();
        let gear_loss = match &self.model {
            Model::Signed { torque, .. } => torque.gear_loss,
            Model::Eq18 { .. } => 0.0,
        };
        let last = all.nrows() - 1;
        if gear_loss == 0.0 || all[(last, last)] <= 0.0 {
            return shared;
        }
        let with_gear = all.view((0, last), (size, 1));
        shared - with_gear * with_gear.transpose() / all[(last, last)]
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
