//! The parameters of the signed torque model, from rows whose payload is known.
//!
//! The cost is that of the model itself, clamped wheels included: Σ ρ(P − Σ_i max(0, τ_i w_i + κ
//! τ_i²)). It has several minima (power may be torque or winding loss, a wheel may brake or be
//! clamped), so the search begins at several starts, and it stays within what a motor and a wheel
//! can be ([`Bounds`]).

mod block;
mod bounds;
mod cost;
mod restarts;
mod robust;
mod search;
mod starts;
#[cfg(test)]
mod tests;

use logs::robot::Robot;
use model_core::torque::{Drive, TorqueModel};

pub(super) use self::bounds::MOST_GEAR_LOSS;
pub use self::bounds::{AtBound, Bounds};
use self::cost::Cost;
pub(super) use self::cost::Loss;
pub use self::cost::{BRIDGE_DROP, GEAR_LOSS, IMBALANCE, PARAMETERS, Parameters};
pub use self::cost::{gradient, parameters, power, predict, torque};
pub use self::restarts::{Restarts, restart};
pub use self::robust::Huber;
pub(super) use self::robust::usual_loss;
pub(super) use self::search::{Descent, MOST_STEPS, search};
use self::search::{FINAL, TRIAL, best_of};
pub use self::starts::Alone;
use super::dataset::{Dataset, Rows, Stretch};
pub use numerics::levenberg_marquardt::Ending;

/// Terms of the torque model that are free in some fits and 0 in the others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FreeTerms {
    /// The sides' Coulomb torques differ.
    pub unequal_sides: bool,
    /// The gear takes a share of what passes it; of the friction this share passes.
    pub gear_loss: Option<f64>,
    /// The bridge takes a voltage from whatever current passes it.
    pub bridge_drop: bool,
}

impl FreeTerms {
    /// The terms that this model has.
    pub fn of(torque: &TorqueModel<f64>) -> Self {
        Self {
            unequal_sides: torque.imbalance != 0.0,
            gear_loss: (torque.gear_loss != 0.0).then_some(torque.wheel_friction_share),
            bridge_drop: torque.bridge_drop != 0.0,
        }
    }

    /// The places of the parameters that are free, for wheels that scrub or do not.
    pub fn places(self, scrubs: bool) -> Vec<usize> {
        // Wheels that do not scrub have no such parameter.
        let shared = 0..model_core::torque::PARAMETERS - usize::from(!scrubs);
        let free = [
            (self.unequal_sides, IMBALANCE),
            (self.gear_loss.is_some(), GEAR_LOSS),
            (self.bridge_drop, BRIDGE_DROP),
        ];
        shared.chain(free.into_iter().filter_map(|(is_free, place)| is_free.then_some(place))).collect()
    }
}

/// A fitted torque model.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The parameters.
    pub torque: TorqueModel<f64>,
    /// How the last search ended.
    pub ending: Ending,
    /// Steps taken, over all starts and losses.
    pub iterations: u32,
    /// Weight of each row of the store: 0 where no wheel draws power, 1 as a rule.
    pub weights: Vec<f64>,
    /// Which residuals count linearly, not squared; `None` where all count squared.
    pub huber: Option<Huber>,
    /// Parameters that ended at a bound of theirs.
    pub at_bounds: Vec<AtBound>,
}

impl Solution {
    /// A gear's loss that ended at its bound: the rows do not determine it, and a fit leaves it out.
    pub fn unusable_gear_loss(&self) -> Option<&AtBound> {
        self.at_bounds.iter().find(|at| at.is_of_gear_loss())
    }
}

/// Rows on which starts are tried: they are drawn evenly from the store.
const TRIAL_ROWS: usize = 4096;

/// Ends of trials that are followed on all rows.
const FINALISTS: usize = 3;

/// Fits the rows of the store.
///
/// Least squares first, from all starts; then rows far beyond the usual residual count
/// linearly, by Huber's rule at a fixed scale, where that does not cost what the model explains
/// (`robust`): where acceleration starts or a clamp lets go within the filter's memory no model
/// of filtered signals is right, and on clean data those few rows would decide the fit.
pub fn solve(dataset: &Dataset, robot: &Robot) -> Solution {
    let bounds = Bounds::of(&dataset.robot, dataset.store.all(), robot.motor(), dataset.free_terms);
    solve_within(dataset.store.all(), robot.drive(), &bounds)
}

/// As [`solve`], for any rows and bounds.
pub fn solve_within(rows: Stretch<'_>, drive: Drive, bounds: &Bounds) -> Solution {
    let stride = rows.others().len().div_ceil(TRIAL_ROWS).max(1);
    let trial: Rows = rows.iter().step_by(stride).collect();
    let free = bounds.free();
    let trial = Cost { rows: trial.all(), drive, loss: Loss::Squares, free };
    let all = Cost { rows, drive, loss: Loss::Squares, free };
    let mut steps = 0;
    let mut finalists = starts::finalists(&trial, bounds, &TRIAL, FINALISTS, &mut steps);
    if finalists.is_empty() {
        finalists.push(Parameters::zeros());
    }
    let squares = best_of(&all, &finalists, bounds, &FINAL, &mut steps);
    let robust::Weighed { descent, huber } = robust::weigh(&all, &squares, &finalists, bounds, &mut steps);
    let loss = huber.map_or(Loss::Squares, Loss::from);
    let torque = torque(&descent.parameters);
    Solution {
        torque,
        ending: descent.ending,
        iterations: steps,
        weights: rows.iter().map(|row| cost::weight(&torque, &row, drive, loss)).collect(),
        huber,
        at_bounds: bounds.met_by(&descent.parameters),
    }
}
