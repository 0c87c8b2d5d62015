//! By how much power is later than speed already in clean runs.

use logs::runs::Runs;
use model_core::torque::TorqueModel;
use numerics::search::golden_section;

use crate::thresholds::problem::{LAG_ACCURACY_ROWS, MOST_LAG_ROWS};
use crate::twin::{State, Twin};
use crate::types::Base;

/// The lag with the least residual, s; to a hundredth of a row.
///
/// Speeds from encoder ticks are means over the sample before, and power sensors average over a
/// time of their own. In the residual that looks like a derivative, of the base and of every effect
/// alike.
pub fn of_clean(clean: &Runs, base: &Base) -> f64 {
    let cost = |torque: TorqueModel<f64>, lag: f64| {
        let twin = Twin { runs: clean, drive: base.drive, lag, early: 0.0 };
        let left = twin.residual(&State { torque, effects: Vec::new() });
        left.iter().flatten().map(|x| x * x).sum::<f64>()
    };
    // The cost is a parabola but for the kinks of the interpolation.
    let most = MOST_LAG_ROWS * clean.period_s;
    golden_section(-most, most, 0.5 * LAG_ACCURACY_ROWS / MOST_LAG_ROWS, |lag| cost(base.torque, lag))
        .map_or(0.0, |found| found.at)
}
