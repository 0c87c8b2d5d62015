//! Battery and load as a VDA 5050 state (version 2.1) has them.

use logs::robot::Robot;
use model::coefficients::FittedModel;
use model_core::charge::{Pack, USUAL_RESISTANCE_OHM};
use serde::Serialize;
use support::error::Result;

use super::straight_w;

/// What is known now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Now {
    /// Charge, 0 to 1.
    pub charge: f64,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Static power, W.
    pub static_w: f64,
    /// Speed for which the reach is told, m/s.
    pub speed_m_s: f64,
}

/// The fields of a state.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct State {
    /// Of the protocol.
    version: &'static str,
    battery_state: BatteryState,
    loads: Vec<LoadState>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct BatteryState {
    /// Percent.
    battery_charge: f64,
    /// V, at rest by the pack's curve.
    battery_voltage: f64,
    charging: bool,
    /// m; whole metres, and never more than there are.
    reach: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
struct LoadState {
    /// kg
    weight: f64,
}

/// The state, with the reach at an even speed on level ground.
///
/// # Errors
/// The model gives no power there.
pub fn state(robot: &Robot, coefficients: &FittedModel, pack: &Pack<f64>, now: &Now) -> Result<State> {
    let watts = straight_w(robot, coefficients, now.mass_kg, now.speed_m_s)?.max(0.0) + now.static_w;
    let current = watts / (pack.cells * pack.curve.voltage(0.5));
    let seconds = pack.energy(now.charge, 0.0, USUAL_RESISTANCE_OHM * current) / watts.max(1e-9);
    let payload = now.mass_kg - robot.mass_no_load_kg();
    let rounded = |value: f64, digits: f64| (value * digits).round() / digits;
    let loads = (payload > 0.0).then(|| LoadState { weight: rounded(payload, 1e3) });
    Ok(State {
        version: "2.1.0",
        battery_state: BatteryState {
            battery_charge: rounded(100.0 * now.charge, 10.0),
            battery_voltage: rounded(pack.cells * pack.curve.voltage(now.charge), 100.0),
            charging: false,
            reach: (seconds * now.speed_m_s).clamp(0.0, f64::from(u32::MAX)) as u32,
        },
        loads: loads.into_iter().collect(),
    })
}
