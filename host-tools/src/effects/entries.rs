//! All effects: what each means, in which unit, with which sign, and what it needs.

use serde::{Deserialize, Serialize};

use super::PROCESSOR;

/// An entry.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Entry {
    /// Its name in JSON, files and docs.
    pub id: &'static str,
    /// Its physical meaning, one sentence.
    pub meaning: &'static str,
    /// Unit of its coefficient.
    pub unit: &'static str,
    /// The signs that its coefficient can have.
    pub sign: Sign,
    /// What a log has to have for it, beyond speeds and power.
    pub needs: &'static str,
    /// Whether it may concern single runs.
    pub single_runs: bool,
}

/// The signs that a coefficient can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sign {
    /// Above 0.
    Positive,
    /// Below 0.
    Negative,
    /// Either.
    Either,
}

const fn entry(
    id: &'static str,
    unit: &'static str,
    sign: Sign,
    needs: &'static str,
    meaning: &'static str,
) -> Entry {
    Entry { id, meaning, unit, sign, needs, single_runs: false }
}

const fn in_runs(entry: Entry) -> Entry {
    Entry { single_runs: true, ..entry }
}

/// All effects, in the order of the documentation.
pub const ENTRIES: [Entry; 21] = [
    entry("grade", "1", Sign::Either, "", "the road slopes: gravity pulls along the way"),
    entry("winding-temperature", "1", Sign::Positive, "", "copper heats, and its resistance rises"),
    entry("windage", "N·m·s²/rad²", Sign::Positive, "", "air or a fan brakes with the square of the speed"),
    entry("stribeck", "N·m", Sign::Positive, "", "friction is greater near standstill"),
    entry(
        "viscous-change",
        "N·m·s/rad",
        Sign::Either,
        "",
        "the grease is thicker or thinner than in the fit",
    ),
    entry("lubricant-warm-up", "N·m·s/rad", Sign::Positive, "", "viscous friction falls as the gears warm"),
    entry("rolling-resistance-change", "N·m/kg", Sign::Either, "", "the floor is another than in the fit"),
    in_runs(entry("surface-switch", "N·m/kg", Sign::Either, "", "the floor changes within a run")),
    entry("payload-offset", "N·m/kg", Sign::Either, "", "the load is off centre: one side carries more"),
    entry("wheel-drag", "N·m", Sign::Positive, "", "one wheel drags: brake, hair or bearing"),
    entry("turning-scrub", "N·m", Sign::Positive, "", "tyres scrub in turns"),
    entry(
        "gear-load-loss",
        "1/(N·m)",
        Sign::Positive,
        "",
        "gears lose more than in proportion to their torque",
    ),
    entry("supply-sag", "1/W", Sign::Positive, "", "battery and leads have a resistance"),
    entry("regeneration", "1", Sign::Positive, "", "braking energy returns to the supply"),
    in_runs(entry("payload-mislabel", "kg", Sign::Either, "2 runs", "the mass noted for a run is wrong")),
    in_runs(entry("static-step", "W", Sign::Either, "", "the static power changes its state")),
    entry("compute-load", "W/%", Sign::Positive, PROCESSOR, "the static power follows the processor's load"),
    entry("sensor-gain", "1", Sign::Either, "", "the power sensor reads a factor off"),
    entry("sensor-offset", "W", Sign::Either, "", "the power sensor reads a constant off"),
    entry("sensor-delay", "s", Sign::Either, "", "power and speed are shifted in time"),
    entry("speed-scale", "1", Sign::Either, "", "wheel radius or encoder scale is off"),
];

/// The entry of an id.
pub fn find(id: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.id == id)
}
