//! A robot's runs as sums near coefficients that are known, and its own base: what it differs from
//! them by.

use std::collections::{BTreeMap, BTreeSet};

use fit::physical::{IMBALANCE, parameters};
use fit::run_gram::{Local, PARAMETERS, RunGram};
use fit::verdict;
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector};
use numerics::scaled_inverse::ScaledInverse;

use super::keys::{DAY, ROBOT, key};

/// A coefficient, or a combination of some, that may change.
pub(super) struct Direction {
    pub(super) name: String,
    pub(super) unit: &'static str,
    pub(super) along: DVector<f64>,
    /// What it is now.
    pub(super) value: f64,
}

/// One side's wheels: a0 of both sides and the imbalance together (right a0 + d, left a0 − d).
const SIDES: [(&str, f64); 2] = [("coulomb of the left wheels", -0.5), ("coulomb of the right wheels", 0.5)];

/// All that are asked.
pub(super) fn directions(reference: &TorqueModel<f64>, has_sides: bool) -> Vec<Direction> {
    let values = parameters(reference);
    let unit = |place: usize| DVector::from_fn(PARAMETERS, |i, _| if i == place { 1.0 } else { 0.0 });
    let plain = verdict::TORQUE.iter().enumerate().map(|(place, description)| Direction {
        name: description.name.to_owned(),
        unit: description.unit,
        along: unit(place),
        value: values[place],
    });
    let sides = SIDES.iter().filter(|_| has_sides).map(|(name, share)| Direction {
        name: (*name).to_owned(),
        unit: verdict::TORQUE[0].unit,
        along: unit(0) * 0.5 + unit(IMBALANCE) * *share,
        value: values[0],
    });
    plain.chain(sides).collect()
}

/// A run's sums.
pub(super) struct Run<'a> {
    pub(super) name: &'a str,
    pub(super) day: &'a str,
    pub(super) normal: DMatrix<f64>,
    pub(super) score: DVector<f64>,
    /// Σ e², W², and the number of rows.
    pub(super) squares: f64,
    pub(super) rows: u64,
}

/// A robot with a base of its own.
pub(super) struct Robot<'a> {
    pub(super) name: &'a str,
    pub(super) days: Vec<&'a str>,
    pub(super) runs: Vec<Run<'a>>,
    /// (Σ N)⁺.
    pub(super) inverse: DMatrix<f64>,
    pub(super) total: DMatrix<f64>,
}

/// Runs by robot, by name.
pub(super) fn by_robot<'a>(runs: &[&'a RunGram]) -> BTreeMap<&'a str, Vec<Run<'a>>> {
    let mut grouped: BTreeMap<&str, Vec<Run<'_>>> = BTreeMap::new();
    for run in runs {
        if let Some(local) = &run.local {
            grouped.entry(key(run, ROBOT)).or_default().push(Run::of(run, local));
        }
    }
    grouped
}

impl<'a> Run<'a> {
    fn of(run: &'a RunGram, local: &Local) -> Self {
        Self {
            name: &run.run,
            day: key(run, DAY),
            normal: local.matrix(),
            score: local.scores(),
            squares: local.squares,
            rows: local.rows,
        }
    }
}

impl<'a> Robot<'a> {
    pub(super) fn new(name: &'a str, runs: Vec<Run<'a>>) -> Self {
        let days: Vec<&str> = runs.iter().map(|run| run.day).collect::<BTreeSet<_>>().into_iter().collect();
        let total = runs.iter().fold(DMatrix::zeros(PARAMETERS, PARAMETERS), |sum, run| sum + &run.normal);
        Self { name, days, inverse: pseudo_inverse(&total), total, runs }
    }

    /// Σ Jᵀe.
    pub(super) fn scores(&self) -> DVector<f64> {
        self.runs.iter().fold(DVector::zeros(PARAMETERS), |sum, run| sum + &run.score)
    }

    /// What it differs from the reference by, within what its runs determine.
    pub(super) fn base(&self) -> DVector<f64> {
        &self.inverse * self.scores()
    }
}

/// The step that runs of these (information, score) share, its information, and Σ (score left)²;
/// none where the information is not above `least`.
pub(super) fn shared_step(runs: &[(f64, f64)], least: f64) -> Option<(f64, f64, f64)> {
    let information: f64 = runs.iter().map(|(information, _)| information).sum();
    if information.is_nan() || information <= least {
        return None;
    }
    let step = runs.iter().map(|(_, score)| score).sum::<f64>() / information;
    Some((step, information, runs.iter().map(|run| (run.1 - step * run.0).powi(2)).sum()))
}

/// Of a Gram matrix, within what it determines.
fn pseudo_inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let scaled = ScaledInverse::of(matrix);
    scaled.unscaled(&scaled.inverse)
}
