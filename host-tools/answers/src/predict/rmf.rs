//! Open-RMF's formula of what driving takes: `rmf_battery`, `SimpleMotionPowerSink` and
//! `SimpleDevicePowerSink`.
//!
//! P = m |a| |v| + I |α| |ω| + f m g |v| + ambient + tool. Braking costs as much as starting,
//! turning on the spot costs inertia only, and friction knows no speed.

use serde::Serialize;

/// As `rmf_battery` has it.
const GRAVITY: f64 = 9.81;

/// A vehicle as Open-RMF's fleet adapters are told it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Vehicle {
    /// Total mass, kg.
    pub mass_kg: f64,
    /// About the vertical axis, kg·m².
    pub moment_of_inertia_kg_m2: f64,
    /// Of all that resists driving straight, without unit.
    pub friction_coefficient: f64,
}

impl Vehicle {
    /// What driving takes, W, at a speed in m/s and a turn rate in rad/s with their rates of
    /// change.
    pub fn power_w(&self, speed: f64, acceleration: f64, turn: f64, turn_acceleration: f64) -> f64 {
        let inertia = self.mass_kg * (acceleration * speed).abs()
            + self.moment_of_inertia_kg_m2 * (turn_acceleration * turn).abs();
        inertia + self.friction_coefficient * self.mass_kg * GRAVITY * speed.abs()
    }

    /// The same vehicle with the friction at which this power, W, drives it straight at this speed,
    /// m/s.
    #[must_use]
    pub fn with_friction_of(self, power_w: f64, speed: f64) -> Self {
        let friction_coefficient = (power_w / (self.mass_kg * GRAVITY * speed)).max(0.0);
        Self { friction_coefficient, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, as the formula above: 20 · 0.5 · 1 + 10 · 0.1 · 2 + 0.22 · 20 · 9.81 · 1.
    #[test]
    fn the_formula_is_rmf_batterys() {
        let vehicle = Vehicle { mass_kg: 20.0, moment_of_inertia_kg_m2: 10.0, friction_coefficient: 0.22 };
        assert!((vehicle.power_w(1.0, -0.5, 2.0, 0.1) - (10.0 + 2.0 + 43.164)).abs() < 1e-9);
        let same = vehicle.with_friction_of(43.164, 1.0);
        assert!((same.friction_coefficient - 0.22).abs() < 1e-12);
    }
}
