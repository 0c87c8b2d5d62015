//! Whether the data determine a parameter, and what to drive if they do not.

use model::coefficients::{self, Quantity};
use nalgebra::{DMatrix, DVector};
use numerics::robust::NORMAL_95;
use serde::Serialize;

use super::assess::Uncertainty;
use super::physical;

/// One fitted parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name in files and reports.
    pub name: String,
    /// The estimate.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Standard error, robust to autocorrelation; null where the data say nothing.
    pub std_err: Option<f64>,
    /// `determined`, `weak` or `undetermined`.
    pub verdict: Verdict,
    /// Why, with the parameters it is confused with, and the manoeuvre or payload that would settle
    /// it.
    pub advice: Option<String>,
    /// The manoeuvre or payload alone.
    #[serde(skip)]
    pub remedy: &'static str,
}

/// How well the data determine a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Its 95 % interval is within ± 20 % of it.
    Determined,
    /// Its 95 % interval does not reach 0.
    Weak,
    /// It could as well be 0, or anything.
    Undetermined,
}

/// Name, unit and remedy of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What would determine it.
    pub remedy: &'static str,
}

/// Undetermined directions with at least this share of a parameter make it undetermined.
const NOTABLE_SHARE: f64 = 0.05;

/// Correlations beyond this are named.
const CONFUSED: f64 = 0.95;

/// Judges every parameter.
pub fn judge(descriptions: &[Description], values: &[f64], uncertainty: &Uncertainty) -> Vec<Parameter> {
    descriptions
        .iter()
        .zip(values)
        .enumerate()
        .map(|(index, (description, &value))| {
            let variance = uncertainty.covariance[(index, index)];
            let lost = uncertainty.undetermined.iter().any(|d| d[index].abs() > NOTABLE_SHARE);
            let std_err = (!lost && variance.is_finite()).then(|| variance.max(0.0).sqrt());
            let verdict = match std_err {
                Some(error) if NORMAL_95 * error <= 0.2 * value.abs() => Verdict::Determined,
                Some(error) if NORMAL_95 * error < value.abs() => Verdict::Weak,
                _ => Verdict::Undetermined,
            };
            let advice = (verdict != Verdict::Determined).then(|| {
                let partners = partners(index, descriptions, uncertainty);
                let why = if partners.is_empty() {
                    "too little in these runs depends on it".to_owned()
                } else {
                    format!("cannot be told from {}", partners.join(", "))
                };
                format!("{why}: {}", description.remedy)
            });
            Parameter {
                name: description.name.to_owned(),
                value,
                unit: description.unit.to_owned(),
                std_err,
                verdict,
                advice,
                remedy: description.remedy,
            }
        })
        .collect()
}

/// Parameters that trade against this one.
fn partners(index: usize, descriptions: &[Description], uncertainty: &Uncertainty) -> Vec<&'static str> {
    let shared = |other: usize, direction: &DVector<f64>| {
        direction[index].abs() > NOTABLE_SHARE && direction[other].abs() > NOTABLE_SHARE
    };
    let correlation = |covariance: &DMatrix<f64>, other: usize| {
        covariance[(index, other)] / (covariance[(index, index)] * covariance[(other, other)]).sqrt()
    };
    (0..descriptions.len())
        .filter(|&other| other != index)
        .filter(|&other| {
            uncertainty.undetermined.iter().any(|direction| shared(other, direction))
                || correlation(&uncertainty.covariance, other).abs() > CONFUSED
        })
        .map(|other| descriptions[other].name)
        .collect()
}

pub(super) const PAYLOADS: &str = "add a run with another payload, empty and full at best";
const THREE_PAYLOADS: &str = "constant, linear and quadratic mass terms need at least three payloads";
const SPEEDS: &str = "drive at more speeds, from slow to full, each for some seconds";
const ACCELERATE: &str = "accelerate and brake harder and more often";
const TURN: &str = "turn on the spot and in wide and narrow curves, both ways";
const BRAKE: &str = "brake hard and turn tightly with full payload as well as empty";
const STRAIGHT: &str = "drive straight ahead, fast and slow, for some seconds each";
const ACCELERATE_LOADED: &str = "accelerate hard with full payload as well as empty, straight and turning";

const fn describe(quantity: Quantity, remedy: &'static str) -> Description {
    Description { name: quantity.name, unit: quantity.unit, remedy }
}

/// The parameters of the signed torque model, in their order.
pub const TORQUE: [Description; 7] = [
    describe(coefficients::TORQUE[0], PAYLOADS),
    describe(coefficients::TORQUE[1], PAYLOADS),
    describe(coefficients::TORQUE[2], SPEEDS),
    describe(coefficients::TORQUE[3], ACCELERATE),
    describe(coefficients::TORQUE[4], ACCELERATE_LOADED),
    describe(coefficients::TORQUE[5], ACCELERATE_LOADED),
    describe(coefficients::TORQUE[6], TURN),
];

/// Difference of the right side's Coulomb torque from the left's.
pub const IMBALANCE: Description = describe(coefficients::IMBALANCE, STRAIGHT);

/// What a gear takes of what passes it.
pub const GEAR_LOSS: Description = describe(coefficients::GEAR_LOSS, BRAKE);

/// What a bridge takes of whatever current passes it.
pub const BRIDGE_DROP: Description = describe(coefficients::BRIDGE_DROP, ACCELERATE_LOADED);

/// Of the parameter at this place of [`Parameters`](super::physical::Parameters).
pub fn of_torque(place: usize) -> &'static Description {
    match place {
        physical::IMBALANCE => &IMBALANCE,
        physical::GEAR_LOSS => &GEAR_LOSS,
        _ => TORQUE.get(place).unwrap_or(&BRIDGE_DROP),
    }
}

/// β_0 … β_14 of Eq. 18.
pub const EQ18: [Description; 15] = [
    describe(coefficients::EQ18[0], THREE_PAYLOADS),
    describe(coefficients::EQ18[1], THREE_PAYLOADS),
    describe(coefficients::EQ18[2], THREE_PAYLOADS),
    describe(coefficients::EQ18[3], SPEEDS),
    describe(coefficients::EQ18[4], ACCELERATE),
    describe(coefficients::EQ18[5], ACCELERATE_LOADED),
    describe(coefficients::EQ18[6], PAYLOADS),
    describe(coefficients::EQ18[7], PAYLOADS),
    describe(coefficients::EQ18[8], ACCELERATE),
    describe(coefficients::EQ18[9], ACCELERATE_LOADED),
    describe(coefficients::EQ18[10], ACCELERATE_LOADED),
    describe(coefficients::EQ18[11], ACCELERATE_LOADED),
    describe(coefficients::EQ18[12], ACCELERATE),
    describe(coefficients::EQ18[13], ACCELERATE_LOADED),
    describe(coefficients::EQ18[14], ACCELERATE_LOADED),
];
