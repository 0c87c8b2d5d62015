//! Which model coefficients belong to, and how they were found.

use model_core::eq18::Gate;
use serde::{Deserialize, Serialize};
use support::error::{Error, Result};

/// Which model to fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// The signed torque model: six physical parameters
    Signed,
    /// Eq. 18 as it follows from its derivation
    Eq18,
    /// Eq. 18 as printed
    Eq18Published,
}

impl ModelKind {
    /// The products that its Gram matrix is formed from.
    pub fn gate(self) -> Gate {
        match self {
            Self::Signed => Gate::Signed,
            Self::Eq18 => Gate::Corrected,
            Self::Eq18Published => Gate::Published,
        }
    }
}

/// How to fit it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Levenberg–Marquardt with bounds on the six parameters (signed model)
    Physical,
    /// Exact non-negative least squares (Eq. 18)
    Nnls,
    /// Algorithm 1 of the paper (Eq. 18)
    Pgd,
}

impl Method {
    /// What a model is fitted with by default.
    pub fn default_for(model: ModelKind) -> Self {
        match model {
            ModelKind::Signed => Self::Physical,
            ModelKind::Eq18 => Self::Nnls,
            ModelKind::Eq18Published => Self::Pgd,
        }
    }

    /// # Errors
    /// The method cannot fit this model.
    pub fn check(self, model: ModelKind) -> Result<Self> {
        match (model, self) {
            (ModelKind::Signed, Self::Physical)
            | (ModelKind::Eq18 | ModelKind::Eq18Published, Self::Nnls | Self::Pgd) => Ok(self),
            (ModelKind::Signed, _) => Err(Error::usage("--model signed is fitted with --method physical")),
            (_, Self::Physical) => {
                Err(Error::usage("--method physical fits --model signed; eq18 is fitted with nnls or pgd"))
            }
        }
    }
}
