//! A fit as coefficients.toml keeps it.

use model::coefficients::{CoefficientsFile, FittedLog, ModelKind, Origin, TORQUE};
use model_core::model::Model;
use nalgebra::DMatrix;
use support::error::Result;

use super::{Fit, usable};
use crate::physical::FreeTerms;

impl Fit {
    /// Of the parameters that both sides share. The imbalance varies within its own scatter. The
    /// losses of gear and bridge stay as fitted: other parameters compensate for nearly any change
    /// of theirs, and a model that keeps them does not have that scatter.
    pub fn shared_covariance(&self) -> DMatrix<f64> {
        let all = &self.uncertainty.covariance;
        let size = match self.kind {
            ModelKind::Signed => TORQUE.len() - usize::from(!self.robot.scrubs()),
            ModelKind::Eq18 | ModelKind::Eq18Published => all.nrows(),
        };
        let shared = all.view((0, 0), (size, size)).into_owned();
        let losses = match &self.model {
            Model::Signed { torque, .. } => {
                let FreeTerms { gear_loss, bridge_drop, .. } = FreeTerms::of(torque);
                usize::from(gear_loss.is_some()) + usize::from(bridge_drop)
            }
            Model::Eq18 { .. } => 0,
        };
        if losses == 0 {
            return shared;
        }
        // They come last.
        let first = all.nrows() - losses;
        let of_losses = all.view((first, first), (losses, losses)).into_owned();
        let Some(cholesky) = of_losses.cholesky() else { return shared };
        let with = all.view((0, first), (size, losses));
        let Some(half) = cholesky.l().solve_lower_triangular(&with.transpose()) else { return shared };
        let conditional = shared - half.transpose() * half;
        // Rounding makes it slightly asymmetric.
        let mut conditional = (&conditional + conditional.transpose()) * 0.5;
        // A parameter that the losses determine has no variance; rounding may be below 0.
        for place in 0..size {
            if conditional[(place, place)] < 0.0 {
                conditional.row_mut(place).fill(0.0);
                conditional.column_mut(place).fill(0.0);
            }
        }
        conditional
    }

    /// What is written of it.
    ///
    /// # Errors
    /// A log that can no longer be read.
    pub fn to_file(&self) -> Result<CoefficientsFile> {
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
