//! Weights that converge and cannot weigh the truth away.
//!
//! The loss is Huber's at a scale that is fixed before each search, so each search minimises one
//! well-defined cost and ends as its ending says. The scale comes from least squares, then once
//! from the first robust fit: where a few rows had drawn the least squares away, the usual residual
//! is smaller than it looked.
//!
//! A robust loss is right where a few rows are wrong. Where the model is, the rows far from it are
//! the ones that tell; so the threshold is the tightest at which the robust fit explains nearly as
//! much of the power's variance as least squares does, and none where there is no such.

use model_core::torque::Drive;
use numerics::levenberg_marquardt::LeastSquares;
use numerics::robust::scale_of_sizes;

use super::super::dataset::Stretch;
use super::bounds::Bounds;
use super::cost::{Cost, Loss, Parameters, residual, torque};
use super::search::{Descent, FINAL, MOST_STEPS, best_of};

/// Residuals beyond this many standard deviations count linearly: the tightest that costs no more
/// than [`MOST_COST`].
const THRESHOLDS: [f64; 3] = [4.0, 8.0, 16.0];

/// R² that weights may cost on the rows they are fitted to. On clean data of the plant they cost
/// below 0.001, on measured data whose model lacks a term 0.1 and more.
const MOST_COST: f64 = 0.005;

/// Where residuals count linearly, not squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Huber {
    /// Beyond so many standard deviations,
    pub threshold_std: f64,
    /// which is this size, W.
    pub size_w: f64,
}

impl From<Huber> for Loss {
    fn from(huber: Huber) -> Self {
        Self::Huber(huber.size_w)
    }
}

/// What came of it.
pub(super) struct Weighed {
    pub(super) descent: Descent,
    /// The loss that it minimises; `None` where weights cost too much, or the search has been cut
    /// short, and all residuals are squared.
    pub(super) huber: Option<Huber>,
}

/// Fits by the robust loss, from the least-squares fit and from the ends of its trials.
pub(super) fn weigh(
    all: &Cost<'_>,
    squares: &Descent,
    finalists: &[Parameters],
    bounds: &Bounds,
    steps: &mut u32,
) -> Weighed {
    let allowed = squares.cost + MOST_COST * variation(all);
    for threshold in THRESHOLDS {
        if *steps > MOST_STEPS {
            break;
        }
        let Some(first) = usual(all.rows, all.drive, &squares.parameters) else { break };
        let mut starts = vec![squares.parameters];
        starts.extend_from_slice(finalists);
        let first = Cost { loss: Loss::Huber(threshold * first), ..*all };
        let rough = best_of(&first, &starts, bounds, &FINAL, steps);
        let Some(second) = usual(all.rows, all.drive, &rough.parameters) else { break };
        let huber = Huber { threshold_std: threshold, size_w: threshold * second };
        let second = Cost { loss: huber.into(), ..*all };
        let descent = best_of(&second, &[rough.parameters, squares.parameters], bounds, &FINAL, steps);
        if all.cost(&descent.parameters) <= allowed {
            return Weighed { descent, huber: Some(huber) };
        }
    }
    Weighed { descent: squares.clone(), huber: None }
}

/// The loss of the tightest threshold for rows whose least squares has these parameters.
pub(crate) fn usual_loss(rows: Stretch<'_>, drive: Drive, parameters: &Parameters) -> Loss {
    usual(rows, drive, parameters).map_or(Loss::Squares, |usual| Loss::Huber(THRESHOLDS[0] * usual))
}

/// Robust standard deviation of the residuals of rows in which a wheel draws power, W; `None` where
/// there is no such row or the model meets most of them exactly.
fn usual(rows: Stretch<'_>, drive: Drive, parameters: &Parameters) -> Option<f64> {
    let torque = torque(parameters);
    let sizes = rows.iter().filter_map(|row| residual(&torque, &row, drive).map(f64::abs));
    scale_of_sizes(&mut sizes.collect::<Vec<f64>>()).filter(|usual| *usual > 0.0)
}

/// Σ (P − P̄)², W².
fn variation(all: &Cost<'_>) -> f64 {
    let rows = all.rows.others();
    let mean = rows.iter().map(|row| row.power).sum::<f64>() / rows.len().max(1) as f64;
    rows.iter().map(|row| (row.power - mean).powi(2)).sum()
}
