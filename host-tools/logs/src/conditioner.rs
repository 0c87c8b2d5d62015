//! The board's filter for a log, and a gyro beside it where the coefficients ask for one.

use std::path::Path;

use model_core::coefficients::Robot as CoreRobot;
use model_core::delay::FRAMES;
use model_core::estimator::Unfit;
use model_core::filter::InvalidCutoff;
use model_core::gyro::GyroConditioner;
use support::error::{Error, Result};

use super::RUN;

/// The conditioner for a log of this robot.
///
/// # Errors
/// The log is too slow for the filter.
pub fn conditioner<const N: usize>(
    robot: &CoreRobot<f64, N>,
    file: &Path,
    period_s: f64,
) -> Result<GyroConditioner<f64, N>> {
    if period_s.is_nan() {
        let message = "no two rows belong to one run; expected runs of many rows";
        return Err(Error::failed(message).in_file(file).in_column(RUN));
    }
    let unfit = |why| {
        let message = match why {
            Unfit::Cutoff(InvalidCutoff { cutoff_hz, below_hz }) => format!(
                "sampled at {:.2} Hz, too slow for the filter's cutoff of {cutoff_hz} Hz; expected a cutoff below \
                 {below_hz:.2} Hz (filter_cutoff_hz in robot.toml)",
                1.0 / period_s,
            ),
            Unfit::Model | Unfit::Delay => format!(
                "sampled at {:.2} Hz, too fast for a delay of {} s; expected at most {FRAMES} sample periods",
                1.0 / period_s,
                robot.conditioning.delay,
            ),
            Unfit::Sides => "true slip of a robot that has no two sides".to_owned(),
        };
        Error::failed(message).in_file(file)
    };
    GyroConditioner::new(robot, period_s).map_err(unfit)
}
