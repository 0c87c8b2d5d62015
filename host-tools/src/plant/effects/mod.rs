//! The dictionary of effects as physical causes: forces, torques, resistances and sensors that are wrong.
//!
//! The ids are those of the gap workflow. No formula here is taken from the models that explain the effects: a cause
//! changes what the plant meets, and motors, gears, body and sensors make of it what they make of everything else.

mod causes;
mod conditions;
mod entry;
mod friction;
mod gearing;
mod heat;
mod load;
mod processor;
mod road;
mod sensing;
pub mod size;
mod statics;
mod supply;
#[cfg(test)]
mod tests;

use rand::RngExt;

use super::kinematics::{Geometry, Kinematics};
use super::noise::{Stream, stream};
pub(super) use causes::Causes;
use causes::Onset;
pub(super) use conditions::Conditions;
use entry::Setting;
pub use entry::{Choice, Effect, Entry, Values, list};
use sensing::SIDE_CHOICE as SIDE;
pub(super) use sensing::{DelayLine, power_delay_s};

/// Effects of what `gmr simulate` writes, beside the moving robot: static power, and sensors of a log.
const OF_LOGS: [&str; 6] =
    ["static-step", "compute-load", "sensor-gain", "sensor-offset", "sensor-delay", "speed-scale"];

/// The first of these effects that only a log can show, not a robot in lockstep with a board: that has rails and
/// sensors of its own.
pub(crate) fn of_logs(effects: &[Effect]) -> Option<&Effect> {
    effects.iter().find(|effect| OF_LOGS.contains(&effect.id()))
}

/// All effects, in the order of the documentation.
pub static DICTIONARY: [Entry; 21] = [
    road::GRADE,
    heat::WINDING,
    friction::WINDAGE,
    friction::STRIBECK,
    friction::VISCOUS,
    friction::WARM_UP,
    road::ROLLING,
    road::SURFACE,
    load::OFFSET,
    friction::DRAG,
    road::SCRUB,
    gearing::GEAR_LOAD,
    supply::SAG,
    supply::REGENERATION,
    load::MISLABEL,
    statics::STEP,
    statics::COMPUTE,
    sensing::GAIN,
    sensing::OFFSET,
    sensing::DELAY,
    sensing::SPEED_SCALE,
];

/// When an effect begins that is there from the start unless told otherwise.
const AT: Choice = Choice {
    name: "at",
    values: Values::Number(0.0, 1e7),
    default: Some(0.0),
    meaning: "when it begins, s since the start",
};

/// When an effect begins whose time nobody knows.
const DRAWN_AT: Choice = Choice {
    default: None,
    meaning: "when it begins, s since the start [default: drawn from the seed]",
    ..AT
};

/// Size and time of an effect that begins when told.
fn onset(effect: &Effect) -> Onset {
    Onset { size: effect.size(), at_s: effect.option("at").unwrap_or(0.0) }
}

/// Size and time of an effect that begins, unless told when, somewhere between a quarter and three quarters of the run.
fn onset_drawn(effect: &Effect, setting: &Setting<'_>) -> Onset {
    let mut rng = stream(setting.scenario.seed, Stream::Onset);
    let drawn = (0..=setting.place).map(|_| rng.random_range(0.25..0.75)).last().unwrap_or(0.5);
    let at_s = effect.option("at").unwrap_or(drawn * setting.scenario.duration_s);
    Onset { size: effect.size(), at_s }
}

/// Index of the front wheel of the side that the effect names.
fn wheel_of_side(effect: &Effect, geometry: &Geometry) -> usize {
    let right = effect.number("side") == 1.0;
    match (right, geometry.kinematics) {
        (false, _) => 0,
        (true, Kinematics::Omni) => 2,
        (true, _) => 1,
    }
}
