//! Effects that a fitted model may lack: one file each.
//!
//! A file says all that there is to say of its effect: name, meaning, unit, signs and range, what
//! the log needs, the regressors that show it, how coefficient files hold it, how its coefficient
//! converts to the world's size, the plant's cause for it, and where it shows. A new effect is a
//! file here, named below, and a line in [`ENTRIES`]; if boards are to know it, a term in
//! model-core as well.
//!
//! | here | there |
//! |---|---|
//! | [`Candidate`]: regressors to be tried, with range and [`Detail`] | `gap` fits and names |
//! | [`written::Written`]: an `[[effects]]` entry of coefficients.toml | estimator and board apply it |
//! | [`plant::PlantCause`]: a physical cause | `gmr gap --plant` drives with it |

mod candidate;
mod column;
mod detail;
mod entry;
mod fields;
mod key;
mod list;
mod physical;
pub mod plant;
mod regressor;
mod scope;
mod sign;
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
pub use entry::Entry;
pub use list::{ENTRIES, candidates, cause, find, physical};
pub use payload_mislabel::PAYLOAD_MISLABEL;
pub use physical::{Physical, World};
pub use regressor::{HALF_SLIP, Regressor, Switched};
pub use scope::{Scope, ScopeColumn};
pub use sign::Sign;
pub use static_step::STATIC_STEP;
pub use surface_switch::SURFACE_SWITCH;
