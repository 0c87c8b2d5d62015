//! Inputs and answers of the workflow: values that every step shares.

use model::effects::{Candidate, Detail, Physical};
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use serde::{Serialize, Serializer};

use super::noise::whiten::Whitener;
use super::thresholds::detect::{INEXACT, STRUCTURE, STRUCTURE_ALONE};
use super::thresholds::name::{COLUMN_PENALTY, MOST_EFFECTS};
use super::user::UserCandidates;

/// Where the base comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    /// The torque model.
    pub torque: TorqueModel<f64>,
    /// Covariance of its parameters; `None` where the base was fitted to these very runs.
    pub covariance: Option<DMatrix<f64>>,
    /// Whether the drives clamp.
    pub drive: Drive,
    /// Total masses that it was fitted to, kg; none where these are those of the runs in question.
    pub masses_kg: Vec<f64>,
    /// Whether it was fitted to a simulator: its runs lack the noise of what is measured.
    pub of_simulator: bool,
}

/// What may be set.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// |z| of a smooth function, or of an effect, beyond which there is structure.
    pub threshold: f64,
    /// The same where no clean runs say what the model gets wrong without any effect.
    pub threshold_alone: f64,
    /// Most effects that are added.
    pub most_effects: usize,
    /// Ids that are not in the dictionary (for benchmarks).
    pub removed: Vec<String>,
    /// The whitener of the noise, where it is known.
    pub whitener: Option<Whitener>,
    /// Relative uncertainty of every base parameter beyond its covariance.
    pub slack: f64,
    /// Variance that clean runs show of each other, relative to noise alone; at least 1. Ties and
    /// standard errors grow with it.
    pub misfit: f64,
    /// Effects of the user's own.
    pub user: UserCandidates,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            threshold: STRUCTURE,
            threshold_alone: STRUCTURE_ALONE,
            most_effects: MOST_EFFECTS,
            removed: Vec::new(),
            whitener: None,
            slack: INEXACT,
            misfit: 1.0,
            user: UserCandidates::default(),
        }
    }
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No structure beyond the noise.
    None,
    /// Effects are named, and the locked runs confirm them.
    Named,
    /// Several effects explain what is seen.
    Ambiguous,
    /// There is structure, and no effect explains it.
    Unexplained,
}

impl Verdict {
    /// Whether effects were added that the locked runs do not speak against.
    pub fn stands(self) -> bool {
        matches!(self, Self::Named | Self::Ambiguous)
    }
}

/// How what was found stands against noise, and against what clean runs show of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// Names are beyond both, or there are none.
    Clear,
    /// There is structure beyond both, but a name is not, as far as runs agree about it.
    Faint,
    /// Clean runs show as much structure of each other: it is no gap unless a name holds.
    WithinClean,
}

impl Standing {
    /// What is left where no name holds.
    pub fn without_a_name(self) -> Verdict {
        if self == Self::WithinClean { Verdict::None } else { Verdict::Unexplained }
    }
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Which.
    pub candidate: Candidate,
    /// Coefficients of its columns.
    pub coefficients: Vec<f64>,
    /// Their standard errors.
    pub std_errs: Vec<f64>,
    /// The headline coefficient as a physical quantity, where that is known.
    pub physical: Option<Physical>,
}

/// What became of a candidate in a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// It was added.
    Winner,
    /// It explains as much as the winner.
    Tie,
    /// Another explains more.
    Worse,
    /// Its sign or size is none that the effect can have.
    Implausible,
    /// Base and effects leave nothing of its column.
    Unidentifiable,
    /// There was nothing to be explained.
    NotNeeded,
}

impl Status {
    /// As JSON and pages say it; nothing where nothing was needed.
    pub fn text(self) -> &'static str {
        match self {
            Self::Winner => "winner",
            Self::Tie => "tie",
            Self::Worse => "worse",
            Self::Implausible => "implausible",
            Self::Unidentifiable => "unidentifiable here",
            Self::NotNeeded => "",
        }
    }
}

impl Serialize for Status {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.text())
    }
}

/// The score of a candidate in a round.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// Its id.
    pub id: String,
    /// What is special about it.
    pub detail: Detail,
    /// χ² that it gains over base and earlier effects, less the cost of its search.
    pub gain: f64,
    /// Coefficients of its columns.
    pub coefficients: Vec<f64>,
    /// What became of it.
    pub status: Status,
}

/// One round.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// Greatest |z| of smooth functions and effects.
    pub structure: f64,
    /// What was allowed.
    pub allowed: f64,
    /// Candidates, best first.
    pub candidates: Vec<Scored>,
    /// What the round ended with.
    pub outcome: String,
}

/// χ² that a candidate's search and its further columns gain by chance, in variances of the noise.
pub(crate) fn penalty(candidate: &Candidate) -> f64 {
    let single = candidate.regressors.iter().any(|regressor| regressor.run().is_some());
    let further = candidate.regressors.len().saturating_sub(1) as f64;
    candidate.search + if single { 0.0 } else { COLUMN_PENALTY * further }
}
