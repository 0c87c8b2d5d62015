//! Whether coefficients can be used: what `gmr fit` says of them, and what their file keeps.

use serde::{Deserialize, Serialize};

/// Whether a model says more of its own rows than their mean does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Usability {
    /// It can be used.
    Usable,
    /// It cannot, and why. Such coefficients are written only with `gmr fit --force`.
    NotUsable(String),
}

/// The same as a key of coefficients.toml.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum VerdictSection {
    Usable,
    NotUsable,
}

impl Usability {
    /// Of a file. Older files have no verdict: there R² decides.
    pub(super) fn of_file(verdict: Option<VerdictSection>, why: Option<String>, r2: f64) -> Self {
        match verdict {
            Some(VerdictSection::NotUsable) => Self::NotUsable(why.unwrap_or_else(|| of_r2(r2))),
            None if r2 < 0.0 => Self::NotUsable(of_r2(r2)),
            Some(VerdictSection::Usable) | None => Self::Usable,
        }
    }

    /// As a file keeps it: the verdict, and why.
    pub(super) fn section(&self) -> (VerdictSection, Option<String>) {
        match self {
            Self::Usable => (VerdictSection::Usable, None),
            Self::NotUsable(why) => (VerdictSection::NotUsable, Some(why.clone())),
        }
    }
}

/// R² below 0 in words.
pub fn of_r2(r2: f64) -> String {
    format!("R² {}", support::figure::figure(r2))
}
