//! One thing to know about a log.

use serde::Serialize;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A fit on this log will mislead.
    Problem,
    /// Something cannot be found from this log, or not well.
    Warning,
    /// Good to know.
    Note,
}

/// One thing to know about a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// What it is.
    pub text: String,
    /// What to do; empty if nothing.
    pub advice: String,
    /// Whether the log is another one than its columns say.
    #[serde(skip)]
    pub is_misread: bool,
}
