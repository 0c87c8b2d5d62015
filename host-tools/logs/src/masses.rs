//! Masses that a robot's log can have.

use support::error::{Error, Result};

use super::MASS;
use crate::robot::Robot;

/// Masses below the robot's least by more than this factor, or above its greatest, are of a
/// different unit.
const FAR: f64 = 5.0;

/// The masses that a log of a robot can have, kg.
pub fn masses(robot: &Robot) -> (f64, f64) {
    (robot.mass_no_load_kg() / FAR, robot.mass_full_load_kg() * FAR)
}

/// Refuses a total mass that is none, or none of this robot.
///
/// # Errors
/// Says what was allowed.
pub fn check_mass(robot: &Robot, mass_kg: f64) -> Result<()> {
    let (least, most) = masses(robot);
    if mass_kg >= least && mass_kg <= most {
        return Ok(());
    }
    let expected = if mass_kg > 0.0 && mass_kg.is_finite() {
        format!("from {least} to {most} kg for robot {} (is this another unit?)", robot.name())
    } else {
        "above 0".to_owned()
    };
    Err(Error::failed(format!("a total mass of {mass_kg} kg; expected {expected}")).in_column(MASS))
}
