//! What is told of a plan.

use std::fmt::Write as _;

use numerics::robust::NORMAL_95;
use serde::Serialize;

use super::load::Load;
use super::reach::{Need, Reach};
use super::rmf::Vehicle;
use support::figure::figure;

/// Energy of a plan or a leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    pub(super) duration_s: f64,
    pub(super) distance_m: f64,
    pub(super) energy_j: f64,
    pub(super) driving_j: f64,
    pub(super) std_parameters_j: f64,
    pub(super) std_mass_j: f64,
    pub(super) std_residual_j: f64,
    pub(super) std_static_j: f64,
    pub(super) std_rows_j: f64,
    pub(super) rmf_j: f64,
    pub(super) measured_j: Option<f64>,
}

impl Cost {
    fn std_j(&self) -> f64 {
        let driven = [self.std_parameters_j, self.std_mass_j, self.std_residual_j];
        let parts = driven.into_iter().chain([self.std_static_j, self.std_rows_j]);
        parts.map(|share| share * share).sum::<f64>().sqrt()
    }
}

/// A leg of a plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Leg {
    /// As the plan calls it, or its number.
    pub leg: String,
    /// s
    pub duration_s: f64,
    /// m
    pub distance_m: f64,
    /// With static power, where it is known, J.
    pub energy_j: f64,
    /// 95 % interval, J.
    pub low_j: f64,
    /// Its other end, J.
    pub high_j: f64,
    /// As the log measured it, J; null for a plan.
    pub measured_j: Option<f64>,
}

impl Leg {
    pub(super) fn new(leg: String, cost: Cost) -> Self {
        let reach = NORMAL_95 * cost.std_j();
        Self {
            leg,
            duration_s: cost.duration_s,
            distance_m: cost.distance_m,
            energy_j: cost.energy_j,
            low_j: cost.energy_j - reach,
            high_j: cost.energy_j + reach,
            measured_j: cost.measured_j,
        }
    }
}

/// A limit that legs are driven with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Limit {
    /// Its key in robot.toml.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Whether robot.toml says it.
    pub is_given: bool,
}

/// What a plan costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// The robot.
    pub robot: String,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Its standard deviation, kg.
    pub mass_std_kg: f64,
    /// s
    pub duration_s: f64,
    /// m
    pub distance_m: f64,
    /// What the battery gives, J; what the drives take where static power is unknown.
    pub energy_j: f64,
    /// 95 % interval, J.
    pub low_j: f64,
    /// Its other end, J.
    pub high_j: f64,
    /// Of the drives alone, J.
    pub driving_j: f64,
    /// Static power in it, W; null where it is unknown.
    pub static_power_w: Option<f64>,
    /// Standard deviation by the coefficients' covariance, J.
    pub std_parameters_j: f64,
    /// By the mass, J.
    pub std_mass_j: f64,
    /// By what the model left unexplained, J.
    pub std_residual_j: f64,
    /// By the static power, J.
    pub std_static_j: f64,
    /// By what the motion does between the rows of a profile at even times, J; 0 of other plans.
    pub std_rows_j: f64,
    /// By Open-RMF's formula with this vehicle, J.
    pub rmf_j: f64,
    /// The vehicle.
    pub rmf_vehicle: Vehicle,
    /// As the log measured it, J; null for a plan.
    pub measured_j: Option<f64>,
    /// What legs are driven with.
    pub limits: Vec<Limit>,
    /// By legs.
    pub legs: Vec<Leg>,
    /// Whether the battery has it; null where nobody asked.
    pub battery: Option<Reach>,
}

impl Report {
    pub(super) fn new(
        robot: &str,
        load: &Load,
        rmf_vehicle: Vehicle,
        cost: Cost,
        legs: Vec<Leg>,
        limits: Vec<Limit>,
    ) -> Self {
        let reach = NORMAL_95 * cost.std_j();
        Self {
            robot: robot.to_owned(),
            mass_kg: load.mass_kg,
            mass_std_kg: load.mass_std_kg,
            duration_s: cost.duration_s,
            distance_m: cost.distance_m,
            energy_j: cost.energy_j,
            low_j: cost.energy_j - reach,
            high_j: cost.energy_j + reach,
            driving_j: cost.driving_j,
            static_power_w: load.static_w,
            std_parameters_j: cost.std_parameters_j,
            std_mass_j: cost.std_mass_j,
            std_residual_j: cost.std_residual_j,
            std_static_j: cost.std_static_j,
            std_rows_j: cost.std_rows_j,
            rmf_j: cost.rmf_j,
            rmf_vehicle,
            measured_j: cost.measured_j,
            limits,
            legs,
            battery: None,
        }
    }

    /// What a battery has to have.
    pub fn need(&self) -> Need {
        Need {
            energy_j: self.energy_j,
            low_j: self.low_j,
            high_j: self.high_j,
            duration_s: self.duration_s,
            is_all: self.static_power_w.is_some(),
        }
    }

    /// For people.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        // Writing to a String cannot fail.
        let _ = write!(text, "{}", self.sentences());
        if self.legs.len() > 1 {
            let _ = writeln!(text, "{:<16} {:>9} {:>9} {:>10} {:>23}", "leg", "s", "m", "J", "95 %");
            for leg in &self.legs {
                let Leg { leg: name, duration_s, distance_m, energy_j, low_j, high_j, measured_j } = leg;
                let measured = measured_j.map_or(String::new(), |joules| format!("  measured {joules:.1}"));
                let interval = format!("{low_j:.1} to {high_j:.1}");
                let _ = writeln!(
                    text,
                    "{name:<16} {duration_s:>9.1} {distance_m:>9.2} {energy_j:>10.1} {interval:>23}{measured}"
                );
            }
        }
        text
    }

    fn sentences(&self) -> String {
        let mut text = format!(
            "{} J ({} to {}, 95 %) for {} m in {:.0} s with {} kg in all; {} W h\n",
            figure(self.energy_j),
            figure(self.low_j),
            figure(self.high_j),
            figure(self.distance_m),
            self.duration_s,
            figure(self.mass_kg),
            figure(self.energy_j / 3600.0)
        );
        let _ = match self.static_power_w {
            Some(watts) => writeln!(text, "{:.1} J of it drive, {watts:.2} W are static", self.driving_j),
            None => writeln!(
                text,
                "the drives alone: static power is unknown (static_power_w in robot.toml, or --static-power)"
            ),
        };
        let _ = write!(
            text,
            "standard deviation: {:.1} J by the coefficients, {:.1} by the mass, {:.1} by what the model leaves, {:.1} by static power",
            self.std_parameters_j, self.std_mass_j, self.std_residual_j, self.std_static_j
        );
        if self.std_rows_j > 0.0 {
            let _ = write!(text, ", {:.1} by what is between the plan's rows", self.std_rows_j);
        }
        text.push('\n');
        text += "the interval is for the same robot on the same floor as in the fit\n";
        for limit in self.limits.iter().filter(|limit| !limit.is_given) {
            let _ = writeln!(text, "{} is taken as {}: robot.toml does not say it", limit.name, limit.value);
        }
        if let Some(measured) = self.measured_j {
            let error = |joules: f64| 100.0 * (joules / measured - 1.0);
            let _ = writeln!(
                text,
                "measured: {measured:.1} J; this prediction is {:+.1} % off, Open-RMF's formula {:+.1} %",
                error(self.energy_j),
                error(self.rmf_j)
            );
        }
        if let Some(battery) = &self.battery {
            let _ = writeln!(
                text,
                "battery: {:.0} J are left to its end, 95 %: {:.0} to {:.0} J; the task fits with {:.1} % and leaves {:.1} % of the charge ({:.1} to \
                 {:.1} %)",
                battery.available_j,
                battery.available_low_j,
                battery.available_high_j,
                100.0 * battery.fits_probability,
                100.0 * battery.charge_after,
                100.0 * battery.charge_after_low,
                100.0 * battery.charge_after_high
            );
        }
        text
    }
}
