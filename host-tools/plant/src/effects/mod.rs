//! The dictionary of effects as physical causes: forces, torques, resistances and sensors that are
//! wrong.
//!
//! The ids are those of the gap workflow. No formula here is taken from the models that explain the
//! effects: a cause changes what the plant meets, and motors, gears, body and sensors make of it
//! what they make of everything else.

mod cause;
mod causes;
mod conditions;
mod entry;
mod friction;
mod gearing;
mod heat;
mod list;
mod load;
mod options;
mod processor;
mod road;
mod sensing;
pub mod size;
mod statics;
mod supply;
#[cfg(test)]
mod tests;

pub(super) use causes::Causes;
pub(super) use conditions::Conditions;
pub use entry::{Choice, Effect, Entry, Values};
pub use list::of_logs;
pub use list::{entries, json, list};
pub(super) use sensing::{DelayLine, power_delay_s};
