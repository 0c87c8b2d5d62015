//! Open-RMF's `config.yaml` of a fleet, from a fit: `rmf_battery`'s mechanical, ambient and tool
//! system.

use std::fmt::Write as _;

use logs::robot::Robot;
use model::coefficients::FittedModel;
use serde::Serialize;
use support::error::Result;

use super::{Lost, cruise_m_s, drives_lost, straight_w};
use crate::predict::rmf::Vehicle;

/// What Open-RMF is told of a robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Export {
    /// Version of this object.
    pub version: u32,
    /// The robot.
    pub robot: String,
    /// `mechanical_system`.
    pub mechanical_system: Vehicle,
    /// Speed at which the friction is right, m/s.
    pub cruise_m_s: f64,
    /// `ambient_system` power: the static power, W; null where it is unknown.
    pub ambient_power_w: Option<f64>,
    /// `tool_system` power, W: nothing in a fit tells a tool from the rest.
    pub tool_power_w: f64,
    /// `battery_system`: nominal voltage, V, and capacity, A·h; null without `[battery]`.
    pub battery_voltage_v: Option<f64>,
    /// A·h
    pub battery_capacity_ah: Option<f64>,
    /// What the formula has no word for.
    pub lost: Vec<Lost>,
}

/// The vehicle of a fit: its friction is that of driving straight at cruising speed.
///
/// # Errors
/// The model gives no power there.
pub fn vehicle(robot: &Robot, coefficients: &FittedModel, mass_kg: f64) -> Result<Vehicle> {
    vehicle_at(robot, coefficients, mass_kg, cruise_m_s(robot))
}

fn vehicle_at(robot: &Robot, coefficients: &FittedModel, mass_kg: f64, speed: f64) -> Result<Vehicle> {
    let gyration = robot.gyration_radius_m();
    let vehicle = Vehicle {
        mass_kg,
        moment_of_inertia_kg_m2: mass_kg * gyration * gyration,
        friction_coefficient: 0.0,
    };
    Ok(vehicle.with_friction_of(straight_w(robot, coefficients, mass_kg, speed)?, speed))
}

/// The export at a mass, kg, with the friction at a speed, m/s.
///
/// # Errors
/// The model gives no power there.
pub fn export(
    robot: &Robot,
    coefficients: &FittedModel,
    mass_kg: f64,
    speed: f64,
    ambient_power_w: Option<f64>,
) -> Result<Export> {
    let vehicle = vehicle_at(robot, coefficients, mass_kg, speed)?;
    let at = |speed: f64| -> Result<f64> {
        let watts = straight_w(robot, coefficients, mass_kg, speed)?;
        Ok(vehicle.with_friction_of(watts, speed).friction_coefficient)
    };
    let mut lost = vec![
        Lost {
            what: "friction over speed",
            so: format!(
                "the fit's is {:.4} at half that speed and {:.4} at a quarter more; Open-RMF has one",
                at(0.5 * speed)?,
                at(1.25 * speed)?
            ),
        },
        Lost { what: "turning", so: "no friction on the spot: turns cost their inertia only".to_owned() },
        Lost { what: "payload", so: format!("one mass for all tasks: {mass_kg} kg") },
        Lost { what: "slopes and intervals", so: "none".to_owned() },
    ];
    lost.extend(drives_lost(coefficients));
    let pack = robot.battery();
    Ok(Export {
        version: 1,
        robot: robot.name().to_owned(),
        mechanical_system: vehicle,
        cruise_m_s: speed,
        ambient_power_w,
        tool_power_w: 0.0,
        battery_voltage_v: pack.map(|pack| pack.cells * pack.curve.energy(0.0, 1.0)),
        battery_capacity_ah: pack.map(|pack| pack.capacity / 3600.0),
        lost,
    })
}

impl Export {
    /// For the fleet adapter's `config.yaml`; what it has no word for as comments.
    pub fn yaml(&self, robot: &Robot) -> String {
        let limits = robot.limits();
        let known = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| format!("~  # {unit}; not known"), |value| format!("{value:.4}  # {unit}"))
        };
        let mut text =
            format!("# {}: from a fit, at {} kg\nrmf_fleet:\n", self.robot, self.mechanical_system.mass_kg);
        // Writing to a String cannot fail.
        if let (Some(speed), Some(acceleration)) = (limits.speed_m_s, limits.acceleration_m_s2) {
            let _ = writeln!(text, "  limits:\n    linear: [{speed}, {acceleration}]  # m/s, m/s²");
        }
        let _ = write!(
            text,
            "  battery_system:\n    voltage: {}\n    capacity: {}\n    charging_current: ~  # A; the charger's\n  mechanical_system:\n    \
             mass: {:.4}  # kg\n    moment_of_inertia: {:.5}  # kg m²\n    friction_coefficient: {:.5}  # straight at {:.3} m/s\n  \
             ambient_system:\n    power: {}\n  tool_system:\n    power: {:.1}  # W; in the ambient power, if there is a tool\n",
            known(self.battery_voltage_v, "V"),
            known(self.battery_capacity_ah, "Ah"),
            self.mechanical_system.mass_kg,
            self.mechanical_system.moment_of_inertia_kg_m2,
            self.mechanical_system.friction_coefficient,
            self.cruise_m_s,
            known(self.ambient_power_w, "W"),
            self.tool_power_w
        );
        text.push_str("# what Open-RMF's formula cannot express:\n");
        for Lost { what, so } in &self.lost {
            let _ = writeln!(text, "#   {what}: {so}");
        }
        text
    }
}
