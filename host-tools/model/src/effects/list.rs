//! The list of all effects, and what is looked up in it.

use support::error::Result;

use super::plant::{Finding, PlantCause};
use super::{Candidate, Entry, NotTestable, Physical, Scope, World};
use super::{
    compute_load, gear_load_loss, grade, lubricant_warm_up, payload_mislabel, payload_offset, regeneration,
    rolling_resistance_change, sensor_delay, sensor_gain, sensor_offset, speed_scale, static_step, stribeck,
    supply_sag, surface_switch, turning_scrub, viscous_change, wheel_drag, windage, winding_temperature,
};

/// All effects, in the order of the documentation.
pub static ENTRIES: [Entry; 21] = [
    grade::GRADE,
    winding_temperature::WINDING_TEMPERATURE,
    windage::WINDAGE,
    stribeck::STRIBECK,
    viscous_change::VISCOUS_CHANGE,
    lubricant_warm_up::LUBRICANT_WARM_UP,
    rolling_resistance_change::ROLLING_RESISTANCE_CHANGE,
    surface_switch::SURFACE_SWITCH,
    payload_offset::PAYLOAD_OFFSET,
    wheel_drag::WHEEL_DRAG,
    turning_scrub::TURNING_SCRUB,
    gear_load_loss::GEAR_LOAD_LOSS,
    supply_sag::SUPPLY_SAG,
    regeneration::REGENERATION,
    payload_mislabel::PAYLOAD_MISLABEL,
    static_step::STATIC_STEP,
    compute_load::COMPUTE_LOAD,
    sensor_gain::SENSOR_GAIN,
    sensor_offset::SENSOR_OFFSET,
    sensor_delay::SENSOR_DELAY,
    speed_scale::SPEED_SCALE,
];

/// The entry of an id.
pub fn find(id: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.id == id)
}

/// Every candidate that some runs can show, and the effects that they cannot.
pub fn candidates(scope: &Scope) -> (Vec<Candidate>, Vec<NotTestable>) {
    let mut candidates = Vec::new();
    let mut missing = Vec::new();
    for entry in &ENTRIES {
        match entry.candidates(scope) {
            Ok(ways) => candidates.extend(ways),
            Err(reason) => missing.push(NotTestable { id: entry.id.to_owned(), reason }),
        }
    }
    (candidates, missing)
}

/// The size in the world of an effect's coefficient with its standard error, `with_base` being its
/// covariance with the base's parameters: where nothing is folded in, and of users' effects, the
/// coefficient itself. None where this robot does not let it be told.
pub fn physical(
    candidate: &Candidate,
    (coefficient, std_err): (f64, f64),
    with_base: &[f64],
    world: &World,
) -> Option<Physical> {
    let entry = find(&candidate.id).filter(|_| !candidate.steps_half_slip());
    match entry.and_then(|entry| (entry.physical)(&candidate.detail)) {
        Some(conversion) => conversion.apply(coefficient, std_err, with_base, world),
        None => Some(Physical { value: coefficient, unit: candidate.unit.clone(), std_err }),
    }
}

/// The plant's cause of what was found, or why there is none.
///
/// # Errors
/// An option out of the plant's range.
pub fn cause(finding: &Finding<'_>) -> Result<std::result::Result<PlantCause, String>> {
    let Some(entry) = find(&finding.candidate.id) else {
        return Ok(Err("the plant knows no cause for a formula".to_owned()));
    };
    let cause = (entry.cause)(finding)?;
    Ok(cause.map(|cause| PlantCause { place: finding.place(), ..cause }))
}
