//! Whether the search has missed a lower minimum: random starts of other draws, on the cost that it
//! ended on.

use logs::robot::Robot;
use model_core::torque::{Drive, TorqueModel};
use numerics::levenberg_marquardt::{LeastSquares, descend};
use rayon::prelude::*;
use serde::Serialize;

use super::super::dataset::{Dataset, Stretch};
use super::bounds::Bounds;
use super::cost::{Cost, Loss, parameters};
use super::robust::Huber;
use super::search::FINAL;
use super::starts::{Alone, DRAWS};

/// What random starts found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Restarts {
    /// How many.
    pub starts: u32,
    /// What the fit costs above the lowest end of theirs, as a share of it; below 0 where none came
    /// as low.
    pub cost_above_share: f64,
}

/// Searches from random starts on the fit's own rows, bounds and loss, and compares where they end.
pub fn restart(
    dataset: &Dataset,
    robot: &Robot,
    fitted: &TorqueModel<f64>,
    huber: Option<Huber>,
    starts: u32,
) -> Restarts {
    let bounds = Bounds::of(&dataset.robot, dataset.store.all(), robot.motor(), dataset.free_terms);
    restart_within(dataset.store.all(), robot.drive(), &bounds, fitted, huber, starts)
}

/// As [`restart`], for any rows and bounds.
pub(super) fn restart_within(
    rows: Stretch<'_>,
    drive: Drive,
    bounds: &Bounds,
    fitted: &TorqueModel<f64>,
    huber: Option<Huber>,
    starts: u32,
) -> Restarts {
    let loss = huber.map_or(Loss::Squares, Loss::from);
    let cost = Cost { rows, drive, loss, free: bounds.free() };
    let alone = Alone::of(&cost);
    let lowest = (0..u64::from(starts))
        .into_par_iter()
        // The first draws are the search's own.
        .map(|draw| descend(&cost, &alone.drawn(DRAWS + draw, bounds), bounds.as_box(), &FINAL).cost)
        .filter(|cost| cost.is_finite())
        .reduce(|| f64::INFINITY, f64::min);
    Restarts { starts, cost_above_share: cost.cost(&parameters(fitted)) / lowest - 1.0 }
}
