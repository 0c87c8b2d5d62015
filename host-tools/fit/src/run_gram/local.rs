//! The signed model near coefficients that are known: what rows say of every parameter there,
//! clamped wheels, delay and slip memory included.
//!
//! ```text
//! e = p − P(θ₀),  J = ∂P/∂θ at θ₀:   JᵀJ δ = Jᵀe
//! ```
//!
//! One step of Gauss and Newton, from sums that add up; exact where δ is small, for which clamped
//! wheels stay clamped.

use model_core::torque::{Drive, TorqueModel};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::dataset::Kept;
use crate::physical;

/// Parameters that the sums are about, in the order of [`physical::Parameters`]: all but the losses
/// of gear and bridge, which stay what the reference has.
pub const PARAMETERS: usize = physical::GEAR_LOSS;

/// Coefficients that rows are held against.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The model.
    pub torque: TorqueModel<f64>,
    /// Whether its drives clamp.
    pub drive: Drive,
}

/// Sums at a reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Local {
    /// Rows with power, by the model.
    pub rows: u64,
    /// Σ e², W².
    pub squares: f64,
    /// Jᵀe, in the order of the parameters.
    pub score: Vec<f64>,
    /// JᵀJ, the lower triangle row by row.
    pub normal: Vec<f64>,
}

impl Default for Local {
    fn default() -> Self {
        Self {
            rows: 0,
            squares: 0.0,
            score: vec![0.0; PARAMETERS],
            normal: vec![0.0; PARAMETERS * (PARAMETERS + 1) / 2],
        }
    }
}

impl Local {
    /// Adds a row.
    pub(super) fn add(&mut self, row: &Kept<'_>, reference: &Reference) {
        let (power, slope) = physical::predict(&reference.torque, row, reference.drive);
        if slope.iter().all(|slope| *slope == 0.0) {
            // All wheels stand or are clamped: no parameter is in it.
            return;
        }
        let error = row.power - power;
        self.rows += 1;
        self.squares += error * error;
        self.score.iter_mut().zip(&slope).for_each(|(sum, slope)| *sum += slope * error);
        let pairs = (0..PARAMETERS).flat_map(|i| (0..=i).map(move |j| (i, j)));
        self.normal.iter_mut().zip(pairs).for_each(|(sum, (i, j))| *sum += slope[i] * slope[j]);
    }

    /// Adds the other.
    pub fn merge(&mut self, other: &Self) {
        self.rows += other.rows;
        self.squares += other.squares;
        self.score.iter_mut().zip(&other.score).for_each(|(sum, value)| *sum += value);
        self.normal.iter_mut().zip(&other.normal).for_each(|(sum, value)| *sum += value);
    }

    /// Whether it has as many sums as there are.
    pub(super) fn is_whole(&self) -> bool {
        self.score.len() == PARAMETERS && self.normal.len() == PARAMETERS * (PARAMETERS + 1) / 2
    }

    /// JᵀJ.
    pub fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(PARAMETERS, PARAMETERS, |i, j| {
            let (row, column) = (i.max(j), i.min(j));
            self.normal[row * (row + 1) / 2 + column]
        })
    }

    /// Jᵀe.
    pub fn scores(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.score)
    }
}
