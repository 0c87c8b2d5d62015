//! Whether the battery has what a task needs.

use model_core::charge::{Pack, USUAL_RESISTANCE_OHM};
use numerics::robust::NORMAL_95;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use support::error::{Error, Result};

/// A pack's capacity is known to this share unless it was measured: what makers allow between
/// cells.
const CAPACITY_STD: f64 = 0.03;
/// How well a cell's resistance is known where nobody has learned it, Ω. Chosen: about half of it.
const CELL_STD_OHM: f64 = 0.06;

/// What is known of the battery now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Charge, 0 to 1.
    pub charge: f64,
    /// Its standard deviation.
    pub charge_std: f64,
    /// Charge that is not to be used.
    pub reserve: f64,
    /// Resistance of the pack, Ω, where it is known.
    pub resistance_ohm: Option<f64>,
}

/// What a task takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Need {
    /// J
    pub energy_j: f64,
    /// 95 % interval, J.
    pub low_j: f64,
    /// Its other end, J.
    pub high_j: f64,
    /// s
    pub duration_s: f64,
    /// Whether what the robot draws besides driving is in it.
    pub is_all: bool,
}

/// Whether a task fits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reach {
    /// What the battery gives to its cutoff or the reserve at the task's mean current, J.
    pub available_j: f64,
    /// 95 % interval, J.
    pub available_low_j: f64,
    /// Its other end, J.
    pub available_high_j: f64,
    /// That the task needs no more.
    pub fits_probability: f64,
    /// Charge behind the task, 0 to 1.
    pub charge_after: f64,
    /// 95 % interval.
    pub charge_after_low: f64,
    /// Its other end.
    pub charge_after_high: f64,
}

/// Holds a prediction against a battery.
///
/// # Errors
/// Static power is unknown: what the battery gives besides driving cannot be left out.
pub fn reach(need: &Need, pack: &Pack<f64>, question: &Question) -> Result<Reach> {
    if !need.is_all {
        let message = "what the robot draws besides driving is unknown; expected --static-power W or static_power_w in robot.toml";
        return Err(Error::failed(message));
    }
    let ohm = question.resistance_ohm.map_or(USUAL_RESISTANCE_OHM, |pack_ohm| pack_ohm / pack.cells);
    let ohm_std = question.resistance_ohm.map_or(CELL_STD_OHM, |_| 0.1 * ohm);
    let mean_w = need.energy_j / need.duration_s.max(1e-9);
    // Of a cell, A: at the middle of the curve, which no robot knows better before it drives.
    let current = mean_w / (pack.cells * pack.curve.voltage(0.5));
    let available = |charge: f64, ohm: f64| pack.energy(charge, question.reserve, ohm * current);
    let available_j = available(question.charge, ohm);
    let by_charge = available(question.charge + question.charge_std, ohm)
        - available(question.charge - question.charge_std, ohm);
    let by_ohm =
        available(question.charge, ohm + ohm_std) - available(question.charge, (ohm - ohm_std).max(0.0));
    let parts = [0.5 * by_charge, 0.5 * by_ohm, CAPACITY_STD * available_j];
    let std = parts.iter().map(|std| std * std).sum::<f64>().sqrt();
    let spread = std.hypot((need.high_j - need.low_j) / (2.0 * NORMAL_95)).max(f64::MIN_POSITIVE);
    let normal = Normal::standard();
    let after = |energy: f64, charge: f64| pack.after(charge, energy, ohm * current);
    Ok(Reach {
        available_j,
        available_low_j: (available_j - NORMAL_95 * std).max(0.0),
        available_high_j: available_j + NORMAL_95 * std,
        fits_probability: normal.cdf((available_j - need.energy_j) / spread),
        charge_after: after(need.energy_j, question.charge),
        charge_after_low: after(need.high_j, (question.charge - NORMAL_95 * question.charge_std).max(0.0)),
        charge_after_high: after(need.low_j, (question.charge + NORMAL_95 * question.charge_std).min(1.0)),
    })
}
