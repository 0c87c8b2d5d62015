//! Effects that a fitted model may lack: one file each.
//!
//! A file says all that there is to say of its effect: name, meaning, unit, signs and range, what the log needs, the regressors that
//! show it, how coefficient files hold it, how its coefficient converts to the world's size, the plant's cause for it, and where it
//! shows. A new effect is a file here and a line in [`ENTRIES`]; if boards are to know it, a term in model-core as well.
//!
//! | here | there |
//! |---|---|
//! | [`Candidate`]: regressors to be tried, with range and [`Detail`] | `gap` fits and names |
//! | [`written::Written`]: an `[[effects]]` entry of coefficients.toml | estimator and board apply it |
//! | [`plant::Part`]: a physical cause | `gmr gap --plant` drives with it |

mod candidate;
mod column;
mod detail;
mod entry;
mod physical;
pub mod plant;
mod regressor;
mod scope;
#[cfg(test)]
mod tests;
pub mod words;
pub mod written;

mod compute_load;
mod gear_load_loss;
mod grade;
mod lubricant_warm_up;
mod payload_mislabel;
mod payload_offset;
mod regeneration;
mod rolling_resistance_change;
mod sensor_delay;
mod sensor_gain;
mod sensor_offset;
mod speed_scale;
mod static_step;
mod stribeck;
mod supply_sag;
mod surface_switch;
mod turning_scrub;
mod viscous_change;
mod wheel_drag;
mod windage;
mod winding_temperature;

pub use candidate::{Candidate, NotTestable};
pub use column::{PITCH, PROCESSOR, TEMPERATURES, temperature};
pub use detail::{Along, Detail, Heated, Runs, WheelSide};
pub use entry::{Entry, Sign};
pub use physical::{Physical, World};
pub use regressor::{Regressor, Switched};
pub use scope::{Scope, ScopeColumn};

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
    let mut found = Vec::new();
    let mut missing = Vec::new();
    for entry in &ENTRIES {
        match (entry.candidates)(scope) {
            Ok(ways) => found.extend(ways.into_iter().map(|way| way.of(entry))),
            Err(reason) => missing.push(NotTestable { id: entry.id.to_owned(), reason }),
        }
    }
    (found, missing)
}
