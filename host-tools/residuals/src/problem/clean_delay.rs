//! The delay of power after speed in clean runs.

use logs::runs::Runs;
use model_core::torque::TorqueModel;
use numerics::search::golden_section;

use crate::predictor::{Predictor, State};
use crate::thresholds::problem::{DELAY_ACCURACY_ROWS, MOST_DELAY_ROWS};
use crate::types::Base;

/// The delay with the least residual, s; to a hundredth of a row.
///
/// Speeds from encoder ticks are means over the previous sample, and power sensors average, too. In
/// the residual that looks like a derivative of the base and of every effect.
pub fn estimate(clean: &Runs, base: &Base) -> f64 {
    let cost = |torque: TorqueModel<f64>, delay: f64| {
        let predictor = Predictor { clean_delay: delay, ..Predictor::new(clean, base.drive) };
        let residual = predictor.residual(&State { torque, effects: Vec::new() });
        residual.iter().flatten().map(|x| x * x).sum::<f64>()
    };
    // The cost is a parabola but for the kinks of the interpolation.
    let most = MOST_DELAY_ROWS * clean.period_s;
    golden_section(-most, most, 0.5 * DELAY_ACCURACY_ROWS / MOST_DELAY_ROWS, |delay| cost(base.torque, delay))
        .map_or(0.0, |least| least.at)
}
