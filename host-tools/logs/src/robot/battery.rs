//! `[battery]` of robot.toml: what is known of the pack beforehand.

use model_core::charge::{Curve, MOST_POINTS, Pack, Point};
use serde::Deserialize;

/// As it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    capacity_ah: f64,
    cells: f64,
    /// Charge 0 to 1 and voltage of one cell at rest, V.
    open_circuit_v: Option<Vec<[f64; 2]>>,
    #[serde(default)]
    cutoff_v: f64,
}

/// What a robot.toml says of its battery.
///
/// # Errors
/// What is wrong, in words, with what is allowed.
pub(super) fn pack(written: toml::de::ValueDeserializer<'_>) -> Result<Pack<f64>, String> {
    const KEYS: &str = "capacity_ah, cells, open_circuit_v (a list of [charge, volts of a cell]), cutoff_v";
    let written = Written::deserialize(written)
        .map_err(|error| format!("{}; expected of {KEYS}", error.message().replace('\n', " ")))?;
    let curve = match written.open_circuit_v {
        None => Curve::lithium_ion(),
        Some(points) => {
            let points = points.into_iter().map(|[charge, voltage]| Point { charge, voltage });
            Curve::new(points).ok_or_else(|| {
                format!(
                    "open_circuit_v; expected 2 to {MOST_POINTS} points [charge, volts of a cell], charges rising from 0 to 1, volts \
                     above 0 and rising"
                )
            })?
        }
    };
    Pack::new(written.capacity_ah, written.cells, curve, written.cutoff_v)
        .map_err(|wrong| format!("{}; expected {}", wrong.name, wrong.expected))
}
