//! Signs of coefficients.

use serde::{Deserialize, Serialize};

/// The signs that a coefficient can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sign {
    /// Above 0.
    Positive,
    /// Below 0.
    Negative,
    /// Either.
    Either,
}
