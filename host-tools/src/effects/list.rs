//! The list of all effects, and what is looked up in it.

use super::compute_load::COMPUTE_LOAD;
use super::gear_load_loss::GEAR_LOAD_LOSS;
use super::grade::GRADE;
use super::lubricant_warm_up::LUBRICANT_WARM_UP;
use super::payload_mislabel::PAYLOAD_MISLABEL;
use super::payload_offset::PAYLOAD_OFFSET;
use super::regeneration::REGENERATION;
use super::rolling_resistance_change::ROLLING_RESISTANCE_CHANGE;
use super::sensor_delay::SENSOR_DELAY;
use super::sensor_gain::SENSOR_GAIN;
use super::sensor_offset::SENSOR_OFFSET;
use super::speed_scale::SPEED_SCALE;
use super::static_step::STATIC_STEP;
use super::stribeck::STRIBECK;
use super::supply_sag::SUPPLY_SAG;
use super::surface_switch::SURFACE_SWITCH;
use super::turning_scrub::TURNING_SCRUB;
use super::viscous_change::VISCOUS_CHANGE;
use super::wheel_drag::WHEEL_DRAG;
use super::windage::WINDAGE;
use super::winding_temperature::WINDING_TEMPERATURE;
use super::{Candidate, Entry, NotTestable, Physical, Scope, World};
use crate::error::Result;

use super::plant::{Finding, Part};

/// All effects, in the order of the documentation.
pub static ENTRIES: [Entry; 21] = [
    GRADE,
    WINDING_TEMPERATURE,
    WINDAGE,
    STRIBECK,
    VISCOUS_CHANGE,
    LUBRICANT_WARM_UP,
    ROLLING_RESISTANCE_CHANGE,
    SURFACE_SWITCH,
    PAYLOAD_OFFSET,
    WHEEL_DRAG,
    TURNING_SCRUB,
    GEAR_LOAD_LOSS,
    SUPPLY_SAG,
    REGENERATION,
    PAYLOAD_MISLABEL,
    STATIC_STEP,
    COMPUTE_LOAD,
    SENSOR_GAIN,
    SENSOR_OFFSET,
    SENSOR_DELAY,
    SPEED_SCALE,
];

/// The entry of an id.
pub fn find(id: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.id == id)
}

/// Every candidate that some runs can show, and the effects that they cannot.
pub fn candidates(scope: &Scope) -> (Vec<Candidate>, Vec<NotTestable>) {
    let mut found = Vec::new();
    let mut missing = Vec::new();
    for entry in &ENTRIES {
        match entry.candidates(scope) {
            Ok(ways) => found.extend(ways),
            Err(reason) => missing.push(NotTestable { id: entry.id.to_owned(), reason }),
        }
    }
    (found, missing)
}

/// The size in the world of an effect's coefficient with its standard error, `with_base` being its covariance with the base's parameters:
/// where nothing is folded in, and of users' effects, the coefficient itself. None where this robot does not let it be told.
pub fn physical(
    candidate: &Candidate,
    (coefficient, std_err): (f64, f64),
    with_base: &[f64],
    world: &World,
) -> Option<Physical> {
    match find(&candidate.id).and_then(|entry| (entry.physical)(&candidate.detail)) {
        Some(conversion) => conversion.apply(coefficient, std_err, with_base, world),
        None => Some(Physical { value: coefficient, unit: candidate.unit.clone(), std_err }),
    }
}

/// The plant's cause of what was found, or why there is none.
///
/// # Errors
/// An option out of the plant's range.
pub fn cause(finding: &Finding<'_>) -> Result<std::result::Result<Part, String>> {
    let Some(entry) = find(&finding.candidate.id) else {
        return Ok(Err("the plant knows no cause for a formula".to_owned()));
    };
    let part = (entry.cause)(finding)?;
    Ok(part.map(|part| Part { place: finding.place(), ..part }))
}
