//! The layout of coefficients.toml, as serde sees it.
//!
//! To add a key: give its section here a field with `#[serde(default)]`, so that files without it stay readable, and with
//! `skip_serializing_if` where most files will not have it; give [`super::CoefficientsFile`] what it means, and say so in
//! [`super::CoefficientsFile::document`] and `of_document`; list a number that cannot be negative in [`Document::numbers`]. An older
//! reader passes over keys that it does not know. Where it would then compute something else, raise [`FORMAT`]: it refuses the file.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::error::InvalidCoefficients;
use super::kind::{Method, ModelKind};
use super::parameters::number;
use crate::effects::written::Written;

/// Version of the file's layout.
pub(super) const FORMAT: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Document {
    pub(super) format: u32,
    pub(super) model: ModelKind,
    pub(super) method: Method,
    pub(super) robot: RobotSection,
    pub(super) parameters: toml::Table,
    pub(super) noise: NoiseSection,
    pub(super) fit: FitSection,
    /// What is known of the model with its effects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) extension: Option<ExtensionSection>,
    /// What `gmr gap --out` added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) effects: Vec<Written>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct RobotSection {
    pub(super) name: String,
    /// Rows vx, vy (m) and ω of R, one column a wheel.
    pub(super) kinematics: Vec<Vec<f64>>,
    pub(super) gyration_radius_m: f64,
    pub(super) mass_no_load_kg: f64,
    pub(super) mass_full_load_kg: f64,
    pub(super) speed_dead_band_rad_s: f64,
    pub(super) filter_cutoff_hz: f64,
    pub(super) static_power_w: f64,
    pub(super) regeneration: bool,
    /// Whether the wheels are dragged sideways in turns.
    pub(super) scrubs: bool,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct NoiseSection {
    pub(super) density_w2_s: f64,
    pub(super) model_std_w: f64,
    pub(super) power_scale_w: f64,
    pub(super) tail: f64,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct FitSection {
    pub(super) rows: u64,
    /// The logs, from the folder of this file: `gmr gap` asks them what the model gets wrong without any effect.
    #[serde(default)]
    pub(super) logs: Vec<PathBuf>,
    /// Size and checksum of each, empty where it was no file: whether they are still what was fitted.
    #[serde(default)]
    pub(super) fingerprints: Vec<String>,
    pub(super) masses_kg: Vec<f64>,
    /// Not a number where the power never changes.
    pub(super) r2: f64,
    pub(super) rmse_w: f64,
    /// Covariance of the parameters in the order above.
    pub(super) covariance: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ExtensionSection {
    /// Of the parameters, then the coefficients of the effects in their order.
    pub(super) joint_covariance: Vec<Vec<f64>>,
}

impl Document {
    /// # Errors
    /// Another layout or format.
    pub(super) fn parse(text: &str) -> Result<Self, InvalidCoefficients> {
        let document: Self = toml::from_str(text).map_err(|error| InvalidCoefficients::Layout {
            message: error.message().replace('\n', " "),
            line: error.span().map(|span| 1 + text[..span.start].matches('\n').count() as u64),
        })?;
        match document.format {
            FORMAT => Ok(document),
            found => Err(InvalidCoefficients::Format { found, expected: FORMAT }),
        }
    }

    /// # Errors
    /// Names a number that no fit can give, and says what was expected (Eq. 20 for the coefficients).
    pub(super) fn check_numbers(&self) -> Result<(), InvalidCoefficients> {
        match self.numbers().into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some((key, value)) => Err(InvalidCoefficients::Number { key: key.to_owned(), value }),
            None => Ok(()),
        }
    }

    /// What has to be finite and not below 0.
    fn numbers(&self) -> Vec<(&str, f64)> {
        let parameters =
            self.parameters.iter().filter_map(|(name, value)| Some((name.as_str(), number(value)?)));
        let others = [
            ("density_w2_s", self.noise.density_w2_s),
            ("model_std_w", self.noise.model_std_w),
            ("power_scale_w", self.noise.power_scale_w),
            ("tail", self.noise.tail),
            ("filter_cutoff_hz", self.robot.filter_cutoff_hz),
        ];
        parameters.chain(others).collect()
    }
}
