//! The dictionary of causes, and effects asked for by name.

use std::fmt::Write;

use support::error::{Error, Result};

use super::cause::Listed;
use super::entry::{Choice, Effect, Entry, Values};
use super::{friction, gearing, heat, load, road, sensing, statics, supply};

/// Effects of what `gmr simulate` writes, beside the moving robot: static power, and sensors of a
/// log.
const OF_LOGS: [&str; 6] =
    ["static-step", "compute-load", "sensor-gain", "sensor-offset", "sensor-delay", "speed-scale"];

/// The first of these effects that a robot in lockstep with a board cannot have: the board has
/// rails and sensors of its own.
pub fn of_logs(effects: &[Effect]) -> Option<&Effect> {
    effects.iter().find(|effect| OF_LOGS.contains(&effect.id()))
}

/// All effects, in the order of the documentation.
static DICTIONARY: [Listed; 21] = [
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

/// All effects, in the order of the documentation.
pub fn entries() -> impl Iterator<Item = &'static Entry> {
    DICTIONARY.iter().map(|listed| &listed.entry)
}

/// The dictionary of causes for scripts, with the keys of [`Entry`] and [`Choice`].
pub fn json() -> serde_json::Value {
    let option = |choice: &Choice| {
        serde_json::json!({
            "name": choice.name,
            "meaning": choice.meaning,
            "allowed": choice.allowed(),
            "default": match (choice.default, choice.values) {
                (Some(place), Values::Word(words)) => words.get(place as usize).copied().into(),
                (value, _) => serde_json::Value::from(value),
            },
        })
    };
    let entries = entries().map(|Entry { id, meaning, unit, range, options, .. }| {
        let options: Vec<_> = options.iter().map(option).collect();
        serde_json::json!({ "id": id, "meaning": meaning, "unit": unit, "range": range, "options": options })
    });
    serde_json::json!({ "effects": entries.collect::<Vec<_>>() })
}

/// What builds an effect's cause.
pub(super) fn listed(effect: &Effect) -> &'static Listed {
    // Every way to make an effect has found its entry here.
    DICTIONARY.iter().find(|listed| listed.entry.id == effect.id()).unwrap_or(&DICTIONARY[0])
}

impl Effect {
    /// The effect `id` of a size in its own unit.
    ///
    /// # Errors
    /// Usage: an unknown id, a size out of the plausible range.
    pub fn new(id: &str, size: f64) -> Result<Self> {
        let entry = entries().find(|entry| entry.id == id).ok_or_else(|| {
            let ids: Vec<&str> = entries().map(|entry| entry.id).collect();
            Error::usage(format!("effect `{id}`; allowed: {}", ids.join(", ")))
        })?;
        Self::of(entry).with_size(size)
    }

    /// Reads `id=size` or `id=size:option=value:…`.
    ///
    /// # Errors
    /// Usage, naming the part that cannot be read or is out of range, and what is allowed.
    pub fn parse(text: &str) -> Result<Self> {
        let mut parts = text.split(':');
        let (id, size) = parts.next().and_then(|first| first.split_once('=')).ok_or_else(|| {
            Error::usage(format!("effect `{text}`; allowed: ID=SIZE or ID=SIZE:OPTION=VALUE:…"))
        })?;
        // An unknown id is reported first, whatever else is wrong.
        let effect = Self::new(id, 0.0)?;
        let size = number(size).ok_or_else(|| effect.refuse_size(size))?;
        let mut effect = effect.with_size(size)?;
        for option in parts {
            let (name, value) = option.split_once('=').unwrap_or((option, ""));
            let choice = effect.choice(name)?;
            let read = match choice.values {
                Values::Number(..) => number(value),
                Values::Word(words) => words.iter().position(|word| *word == value).map(|place| place as f64),
            };
            let read = read.ok_or_else(|| effect.refuse_option(choice, value))?;
            effect = effect.with(name, read)?;
        }
        Ok(effect)
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

/// The dictionary of causes as text: ids, meanings, units, ranges, options.
pub fn list() -> String {
    let mut text = String::new();
    for Entry { id, meaning, unit, range: (low, high), options, .. } in entries() {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{id}\n    {meaning}\n    size: {unit}, {low} to {high}");
        for choice in options.iter() {
            let Choice { name, meaning, .. } = choice;
            let (allowed, default) = (choice.allowed(), choice.default_text());
            let _ = writeln!(text, "    :{name}=  {meaning}, {allowed}{default}");
        }
    }
    text
}
