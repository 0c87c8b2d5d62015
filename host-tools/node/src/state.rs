//! What a node knows at one time.

use std::collections::BTreeMap;

use serde::Serialize;

/// In a word; `why` says the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Health {
    /// The payload is known.
    Ok,
    /// Speeds and power come, but they do not tell the payload, or not yet.
    Unknown,
    /// No wheel speeds, or no longer.
    NoSpeeds,
    /// No power, or no longer.
    NoPower,
}

/// What is known now; what is not is null.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct State {
    /// Since the start, or of the log, s.
    pub time_s: f64,
    /// In a word.
    pub state: Health,
    /// Why the payload is unknown, or what is to be said of it.
    pub why: Option<String>,
    /// Total mass less the mass without payload, kg.
    pub payload_kg: Option<f64>,
    /// 95 % interval, kg.
    pub payload_low_kg: Option<f64>,
    /// 95 % interval, kg.
    pub payload_high_kg: Option<f64>,
    /// Total mass, kg.
    pub mass_kg: Option<f64>,
    /// Power of the drives, filtered, W.
    pub measured_w: Option<f64>,
    /// The same by the model, W.
    pub predicted_w: Option<f64>,
    /// Energy of the drives since the start, J.
    pub energy_j: Option<f64>,
    /// What the sensor says, W.
    pub power_w: Option<f64>,
    /// V.
    pub voltage_v: Option<f64>,
    /// Of the battery, positive while it discharges, A.
    pub current_a: Option<f64>,
    /// 0 to 1.
    pub charge: Option<f64>,
    /// Its standard deviation.
    pub charge_std: Option<f64>,
    /// What the battery still gives at the present load, J.
    pub remaining_j: Option<f64>,
    /// 95 % interval, J.
    pub remaining_low_j: Option<f64>,
    /// 95 % interval, J.
    pub remaining_high_j: Option<f64>,
    /// How long that lasts at the mean power of the last minute, s.
    pub remaining_s: Option<f64>,
    /// Of the pack, Ω.
    pub resistance_ohm: Option<f64>,
    /// Why nothing is said of the charge.
    pub no_charge: Option<&'static str>,
    /// Age of the speeds, s.
    pub speeds_age_s: Option<f64>,
    /// Speeds a second.
    pub rate_hz: Option<f64>,
    /// Samples that the estimator took.
    pub samples: u64,
    /// Payload changes noticed.
    pub changes: u64,
    /// What went wrong so far, how often.
    pub faults: BTreeMap<&'static str, u64>,
}

impl State {
    /// One line for people.
    pub fn line(&self) -> String {
        let payload = match (self.payload_kg, self.payload_low_kg, self.payload_high_kg) {
            (Some(payload), Some(low), Some(high)) => {
                let said = self.why.as_ref().map_or(String::new(), |why| format!(", {why}"));
                format!("{payload:.3} kg (95 %: {low:.3} … {high:.3}){said}")
            }
            _ => format!("unknown: {}", self.why.as_deref().unwrap_or("no reason")),
        };
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| format!("– {unit}"), |value| format!("{value:.2} {unit}"))
        };
        let mut line = format!(
            "{:9.1} s  payload {payload}; drives {}, by the model {}; {}, {}",
            self.time_s,
            number(self.measured_w, "W"),
            number(self.predicted_w, "W"),
            number(self.voltage_v, "V"),
            number(self.current_a, "A"),
        );
        if let (Some(charge), Some(std)) = (self.charge, self.charge_std) {
            line += &format!("; charge {:.0} ± {:.0} %", 100.0 * charge, 196.0 * std);
        }
        if let (Some(energy), Some(time)) = (self.remaining_j, self.remaining_s) {
            line += &format!("; {:.1} Wh, {:.0} min left", energy / 3600.0, time / 60.0);
        }
        line
    }
}
