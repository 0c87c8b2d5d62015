//! What there is to say of an effect.

use model_core::effects::Cause;
use serde::{Deserialize, Serialize};

use super::candidate::Way;
use super::detail::Detail;
use super::physical::Conversion;
use super::plant::{Finding, Part};
use super::scope::Scope;
use super::written::{Fields, Unread};
use crate::error;

/// An effect.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Its name in JSON, files and docs.
    pub id: &'static str,
    /// Its physical meaning, one sentence.
    pub meaning: &'static str,
    /// Unit of its coefficient.
    pub unit: &'static str,
    /// The signs that its coefficient can have.
    pub sign: Sign,
    /// What a log has to have for it, beyond speeds and power.
    pub needs: &'static str,
    /// Whether it may concern single runs.
    pub single_runs: bool,
    /// Drives or columns in which it shows as no other does.
    pub shows_in: &'static str,
    /// The plant's cause in typical strengths, one a kind: benchmarks scale them.
    pub typical: &'static [&'static str],
    /// How its coefficient converts to the world's size, where that is another.
    pub(super) physical: fn(&Detail) -> Option<Conversion>,
    /// The ways in which it may show in some runs, or why these cannot show it.
    pub(super) candidates: fn(&Scope) -> Result<Vec<Way>, String>,
    /// Whether it is what estimator and board know as this.
    pub(super) owns: fn(&Cause<f64>) -> bool,
    /// What estimator and board make of an entry of a coefficients file, with the coefficient of each.
    pub(super) read: fn(&Fields<'_>) -> Result<Vec<(Cause<f64>, f64)>, Unread>,
    /// The plant's cause, or why there is none.
    pub(super) cause: fn(&Finding<'_>) -> error::Result<Result<Part, String>>,
}

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
