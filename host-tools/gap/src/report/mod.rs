//! The answer for scripts, on one screen, and as a page.

pub mod advice;
#[cfg(test)]
pub(crate) mod example;
pub mod json;
pub mod localise;
pub mod page;
pub mod summary;

use fit::form::Judged;
use model::effects::{Candidate, NotTestable};
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use serde_json::{Value, json};

use self::localise::Cell;
use super::confirm::Confirmed;
use super::likelihood::Gate;
use residuals::detect::over_dispersion::OverDispersion;
use residuals::noise::whiten::{Signal, Whitener};
use residuals::predictor::State;
use residuals::split::Split;
use residuals::thresholds::detect::DISTURBANCE;
use residuals::thresholds::detect::STRUCTURE;
use residuals::types::{Named, Round, Standing, Verdict};

/// The answer and what led to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The answer.
    pub verdict: Verdict,
    /// How what was found stands against noise and clean runs.
    pub standing: Standing,
    /// Effects added.
    pub effects: Vec<Named>,
    /// Ids of hypotheses that explain as much.
    pub ambiguous_with: Vec<String>,
    /// Effects that these runs cannot show.
    pub not_testable: Vec<NotTestable>,
    /// Round by round.
    pub rounds: Vec<Round>,
    /// Where the residual lies before anything is added, and after: open and locked runs together.
    pub localisation: Vec<Cell>,
    /// Measured less predicted power, W, of every run before, and after where effects stand: of
    /// open runs from the fit, of locked runs from the confirmation.
    pub residuals: (Signal, Option<Signal>),
    /// On the locked runs.
    pub confirmed: Confirmed,
    /// Base and effects at the end.
    pub state: State,
    /// Of the base's parameters, then the effects' coefficients as in `state`; `None` where nothing
    /// was added, or nothing is known of the base.
    pub covariance: Option<DMatrix<f64>>,
    /// The split.
    pub split: Split,
    /// The scatter of the residual relative to that of clean runs.
    pub over_dispersion: Option<OverDispersion>,
    /// Structure, |z|, that clean runs show of each other; `None` for too few of them.
    pub clean_structure: Option<f64>,
    /// Terms that the clean runs ask for and the base lacks: nothing is named before it is
    /// refitted.
    pub refit: Vec<Judged>,
    /// Base before, and after.
    pub base: [TorqueModel<f64>; 2],
    /// Rivals of each round that ended in a tie, the winner first, in all ways in which each may
    /// show.
    pub ties: Vec<Vec<Rival>>,
    /// Probability of each effect among those of the list, the likeliest first, where it is known.
    pub rivals: Vec<(String, f64)>,
    /// What predictions rest on.
    pub basis: Option<Basis>,
    /// How often relabelled runs show as much, where they were asked.
    pub relabelled: Option<Gate>,
    /// What is less sure than it might be, and why.
    pub notes: Vec<String>,
}

/// One of several hypotheses that explain a gap about as well.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// What it is.
    pub candidate: Candidate,
    /// Base and effects with it, of the open runs.
    pub state: State,
}

/// What predictions of other runs rest on, beside a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Whether the drives clamp.
    pub drive: Drive,
    /// Delay of power after speed in clean runs, s.
    pub clean_delay: f64,
    /// Autoregression of the noise.
    pub whitener: Whitener,
    /// Standard deviation of the whitened noise, W.
    pub std_w: f64,
    /// Inverse of the covariance of the base's fit.
    pub precision: DMatrix<f64>,
}

impl Report {
    /// About another base, which moves by as much. Coefficients for a board keep the base that was
    /// fitted as boards ask their model.
    #[must_use]
    pub fn about(mut self, given: TorqueModel<f64>) -> Self {
        let [before, after] = self.base.map(|torque| torque.to_array());
        let given_values = given.to_array();
        let moved = std::array::from_fn(|k| given_values[k] + after[k] - before[k]);
        self.base = [given, given.with_array(moved)];
        self.state.torque = self.base[1];
        self
    }

    /// With another verdict, and without any name.
    #[must_use]
    pub fn without_names(self, verdict: Verdict) -> Self {
        let mut localisation = self.localisation;
        for cell in &mut localisation {
            (cell.mean_after_w, cell.band_after_w) = (None, None);
        }
        Self {
            verdict,
            effects: Vec::new(),
            ambiguous_with: Vec::new(),
            ties: Vec::new(),
            rivals: Vec::new(),
            residuals: (self.residuals.0, None),
            localisation,
            covariance: None,
            ..self
        }
    }

    /// Whether the logs hold power only.
    pub fn is_power_only(&self) -> bool {
        self.basis.is_none()
    }

    /// Whether the model is off by more than the noise: no effect is named, but not all is
    /// explained.
    pub fn is_off(&self) -> bool {
        self.confirmed.before_w > DISTURBANCE.sqrt() * self.confirmed.floor_unclipped_w
    }

    /// Whether the model's form is off by more than noise in clean runs already, which hides small
    /// effects.
    pub fn hides(&self) -> bool {
        self.clean_structure.is_some_and(|shown| shown > STRUCTURE)
    }

    /// The gap that is closed on locked runs, if it could be tested.
    pub fn gap_closed(&self) -> Option<f64> {
        self.confirmed.closed
    }

    /// The base's parameters before and after.
    pub fn base_moves(&self) -> Value {
        let names = model::coefficients::TORQUE;
        let [before, after] = self.base.map(TorqueModel::to_array);
        let moves = names.iter().zip(before.iter().zip(after));
        Value::Object(
            moves
                .map(|(d, (before, after))| (d.name.to_owned(), json!({"before": before, "after": after})))
                .collect(),
        )
    }
}
