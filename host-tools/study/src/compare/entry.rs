//! One row of a comparison: a model's inputs, its quality, and a fair yardstick.

use serde::Serialize;

use crate::baselines::{Card, Parameter};

/// How a model got the mass of the test rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MassSource {
    /// From the log: the truth.
    Given,
    /// It estimated it from speed and power.
    Estimated,
    /// It has no use for it.
    Unused,
}

impl MassSource {
    /// That of a baseline.
    pub fn of(card: &Card) -> Self {
        match card {
            _ if card.finds_mass() => Self::Estimated,
            _ if card.takes_mass => Self::Given,
            _ => Self::Unused,
        }
    }

    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Estimated => "estimated",
            Self::Unused => "unused",
        }
    }
}

/// Whether a prediction uses power measured on the test drive, and how old.
///
/// Power changes slowly relative to a sample period: a model that sees the last sample starts ahead
/// of one with a plan only. So every row gives its horizon, with the R² of persistence (the power
/// of that long ago).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Horizon {
    /// Motion (and mass) alone: it can predict a plan.
    Plan,
    /// Power up to the second before, through the mass alone.
    Second,
    /// Power up to the sample before.
    Sample,
}

impl Horizon {
    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Second => "1 s",
            Self::Sample => "1 sample",
        }
    }

    /// That of a baseline whose mass is given or unused.
    pub fn of(card: &Card) -> Self {
        if card.learns_while_driving() { Self::Sample } else { Self::Plan }
    }
}

/// R² with several seeds of the weights of a network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WeightSeeds {
    /// How many.
    pub count: usize,
    /// The least R².
    pub least_r2: f64,
    /// The greatest R².
    pub greatest_r2: f64,
}

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// The model.
    pub name: String,
    /// What it is.
    pub source: String,
    /// Where the mass came from.
    pub mass: MassSource,
    /// Whether it uses power of the test drive.
    pub horizon: Horizon,
    /// R², null where the power never changes.
    pub r2: Option<f64>,
    /// R² of the power of one horizon before; null for a plan.
    pub persistence_r2: Option<f64>,
    /// %, above the robot's floor.
    pub mape_percent: Option<f64>,
    /// W
    pub rmse_w: f64,
    /// Mean size of the error of its estimated mass, %; null where it estimates none.
    pub mass_error_percent: Option<f64>,
    /// Share of test samples above the floor.
    pub mape_share: f64,
    /// Samples compared.
    pub samples: u64,
    /// Time to fit, reading not included, s.
    pub fit_s: f64,
    /// Of a network: this row is the median of them by RMSE.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight_seeds: Option<WeightSeeds>,
    /// What a baseline has learned, where that has names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Parameter>,
}

/// A model that is not in the table.
#[derive(Debug, Clone, Serialize)]
pub struct LeftOut {
    /// The model.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Measured and predicted power of one test row, W.
pub type Pair = (f64, f64);
