//! From what was measured to what the link shows.

use crate::link::{Estimate, Rail, State, Wheel};
use crate::measurement::{EstimateSnapshot, RailSnapshot, Snapshot, WheelSnapshot};

/// Takes over what is known after a sample.
pub(super) fn show<const RECORDS: usize>(snapshot: &Snapshot, state: &mut State<RECORDS>) {
    for (rail, snapshot) in state.rails.iter_mut().zip(&snapshot.rails) {
        *rail = rail_of(snapshot);
    }
    for (wheel, snapshot) in state.wheels.iter_mut().zip(&snapshot.wheels) {
        *wheel = wheel_of(snapshot, wheel.position);
    }
    state.estimate = estimate_of(&snapshot.estimate);
    state.is_standing = snapshot.is_standing;
    state.counters.samples = snapshot.samples;
    state.counters.servo_timeouts = snapshot.servo_bus.timeouts;
    state.counters.servo_broken = snapshot.servo_bus.broken;
}

fn rail_of(snapshot: &RailSnapshot) -> Rail {
    let RailSnapshot { voltage, current, power, energy, health, counters, power_factor: _ } = *snapshot;
    Rail { power, voltage, current, energy, health, counters }
}

/// A servo that is silent is where it was.
fn wheel_of(snapshot: &WheelSnapshot, position_before: i32) -> Wheel {
    let WheelSnapshot { health, hardware_error, speed, acceleration, position } = *snapshot;
    Wheel { health, hardware_error, speed, acceleration, position: position.unwrap_or(position_before) }
}

fn estimate_of(snapshot: &EstimateSnapshot) -> Estimate {
    Estimate {
        mass: snapshot.mass,
        measured_power: snapshot.measured_power,
        predicted_power: snapshot.predicted_power,
        measured_energy: snapshot.measured_energy.unwrap_or(0.0),
        predicted_energy: snapshot.predicted_energy.unwrap_or(0.0),
        changes: snapshot.changes.count,
        last_change_us: snapshot.changes.last_us.unwrap_or(0),
    }
}
