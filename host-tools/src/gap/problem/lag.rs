//! By how much power is later than speed already in clean runs.

use model_core::torque::TorqueModel;

use crate::gap::runs::Runs;
use crate::gap::thresholds::problem::{LAG_ACCURACY_ROWS, MOST_LAG_ROWS};
use crate::gap::twin::{State, Twin};
use crate::gap::types::Base;

/// The lag with the least residual, s; to a hundredth of a row.
///
/// Speeds from encoder ticks are means over the sample before, and power sensors average over a time of their own. In the
/// residual that looks like a derivative, of the base and of every effect alike.
pub fn of_clean<const N: usize>(clean: &Runs<N>, base: &Base) -> f64 {
    let cost = |torque: TorqueModel<f64>, lag: f64| {
        let twin = Twin { runs: clean, drive: base.drive, lag };
        let left = twin.residual(&State { torque, effects: Vec::new() });
        left.iter().flatten().map(|x| x * x).sum::<f64>()
    };
    // Golden section: the cost is a parabola but for the kinks of the interpolation.
    let most = MOST_LAG_ROWS * clean.period_s;
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (-most, most);
    let (mut left, mut right) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_left, mut at_right) = (cost(base.torque, left), cost(base.torque, right));
    while high - low > LAG_ACCURACY_ROWS * clean.period_s {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - ratio * (high - low);
            at_left = cost(base.torque, left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + ratio * (high - low);
            at_right = cost(base.torque, right);
        }
    }
    0.5 * (low + high)
}
