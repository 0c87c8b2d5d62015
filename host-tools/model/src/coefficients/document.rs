//! The layout of coefficients.toml, as serde sees it.
//!
//! To add a key: give its section here a field with `#[serde(default)]`, so that files without it
//! stay readable, and with `skip_serializing_if` where most files will not have it; give
//! [`super::CoefficientsFile`] what it means, and say so in [`super::CoefficientsFile::document`]
//! and `of_document`; list a number that cannot be negative in [`Document::numbers`]. An older
//! reader passes over keys that it does not know. Where it would then compute something else, raise
//! [`FORMAT`]: it refuses the file.

use std::path::PathBuf;

use model_core::conditioning::Conditioning;
use model_core::payload::Noise;
use model_core::plausibility::LEAST_CUTOFF;
use model_core::slip::SlipMemory;
use serde::{Deserialize, Serialize};

use super::error::{CUTOFF, InvalidCoefficients, TRUE_SLIP};
use super::kind::{Method, ModelKind};
use super::parameters::{IMBALANCE, number};
use super::usability::VerdictSection;
use crate::effects::written::Written;

/// Version of the file's layout.
pub(super) const FORMAT: u32 = 1;

/// Of files with true slip: likewise.
pub(super) const FORMAT_WITH_GYRO: u32 = 3;

/// Of files with a loss of the gear or a slip memory's own rest: likewise.
pub(super) const FORMAT_WITH_GEAR: u32 = 4;

/// Every version known here.
pub(super) const FORMATS: [u32; 4] = [FORMAT, FORMAT_WITH_TRAITS, FORMAT_WITH_GYRO, FORMAT_WITH_GEAR];

/// Of files with a delay, slip memory or an imbalance of the sides: a reader that passed over these
/// would compute something else.
pub(super) const FORMAT_WITH_TRAITS: u32 = 2;

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
    /// By how much the power is later than the speeds.
    #[serde(default, skip_serializing_if = "is_nought")]
    pub(super) power_delay_s: f64,
    /// Slip at which half of the scrub has built up, and the angle that wheels roll meanwhile.
    #[serde(default, skip_serializing_if = "is_nought")]
    pub(super) half_slip: f64,
    #[serde(default, skip_serializing_if = "is_nought")]
    pub(super) slip_relaxation_rad: f64,
    /// Difference of the sides that is hardly a turn; 0 for the dead band.
    #[serde(default, skip_serializing_if = "is_nought")]
    pub(super) slip_rest_rad_s: f64,
    /// How much of the scrub a rad/s of true slip adds: needs a gyro.
    #[serde(default, skip_serializing_if = "is_nought")]
    pub(super) true_slip_s_rad: f64,
}

fn is_nought(value: &f64) -> bool {
    *value == 0.0
}

impl RobotSection {
    /// What lies between samples and motion beside the filter.
    pub(super) fn conditioning(&self) -> Conditioning<f64> {
        let slip = SlipMemory {
            half_slip: self.half_slip,
            relaxation: self.slip_relaxation_rad,
            rest: self.slip_rest_rad_s,
        };
        Conditioning { slip, delay: self.power_delay_s, true_slip: self.true_slip_s_rad }
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct NoiseSection {
    pub(super) density_w2_s: f64,
    /// Missing where `mass` says that the mass is not identifiable, so that older readers refuse
    /// the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) model_std_w: Option<f64>,
    /// That the mass cannot be told with these coefficients.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) mass: Option<MassSection>,
    /// Without a meaning: 0 for older readers, who weighed samples by it.
    pub(super) power_scale_w: f64,
    pub(super) tail: f64,
    /// Missing in files of older versions.
    #[serde(default)]
    pub(super) residual_std_w: f64,
}

/// What coefficients say of the mass, where it is not an error in W.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum MassSection {
    /// Fitted to one payload or one speed only.
    NotIdentifiable,
}

/// What older versions wrote for [`MassSection::NotIdentifiable`], W: more than any robot draws.
const NO_PAYLOAD_W: f64 = 1e6;

impl NoiseSection {
    /// The error that outlasts a window, W; `None` where the mass is not identifiable.
    ///
    /// # Errors
    /// Neither is there.
    pub(super) fn lasting_w(&self) -> Result<Option<f64>, InvalidCoefficients> {
        match (self.mass, self.model_std_w) {
            (Some(MassSection::NotIdentifiable), _) | (None, Some(NO_PAYLOAD_W)) => Ok(None),
            (None, Some(lasting)) => Ok(Some(lasting)),
            (None, None) => Err(InvalidCoefficients::Layout {
                message: "missing field `model_std_w`".to_owned(),
                line: None,
            }),
        }
    }

    /// The same as files say it.
    pub(super) fn of(noise: &Noise<f64>, identifies_mass: bool) -> Self {
        Self {
            density_w2_s: noise.density,
            model_std_w: identifies_mass.then_some(noise.model_std),
            mass: (!identifies_mass).then_some(MassSection::NotIdentifiable),
            power_scale_w: 0.0,
            tail: noise.tail,
            residual_std_w: noise.residual_std,
        }
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct FitSection {
    pub(super) rows: u64,
    /// The logs, from the folder of this file: `gmr gap` asks them what the model gets wrong
    /// without any effect.
    #[serde(default)]
    pub(super) logs: Vec<PathBuf>,
    /// Size and checksum of each, empty where it was no file: whether they are still what was
    /// fitted.
    #[serde(default)]
    pub(super) fingerprints: Vec<String>,
    /// Total mass that somebody weighed with each log, kg; not a number where the log says it, and
    /// empty where all do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) weighed_kg: Vec<f64>,
    pub(super) masses_kg: Vec<f64>,
    /// Not a number where the power never changes.
    pub(super) r2: f64,
    pub(super) rmse_w: f64,
    /// How much energies of whole drives stray from the model's, as a share.
    #[serde(default)]
    pub(super) energy_std_share: f64,
    /// By how much the power of one kind of driving strays from a fit to the others, W.
    #[serde(default)]
    pub(super) energy_std_w: f64,
    /// Whether it can be used; files of older versions do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) verdict: Option<VerdictSection>,
    /// Why not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) why_not: Option<String>,
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
        let format = document.format;
        if FORMATS.contains(&format) {
            Ok(document)
        } else {
            Err(InvalidCoefficients::Format { format, known: FORMATS })
        }
    }

    /// # Errors
    /// Names a number that no fit can give, and says what was expected (Eq. 20 for the
    /// coefficients).
    pub(super) fn check_numbers(&self) -> Result<(), InvalidCoefficients> {
        let signed = [(IMBALANCE.name, self.imbalance()), ("power_delay_s", self.robot.power_delay_s)];
        let signed = signed.into_iter().find(|(_, value)| !value.is_finite());
        let others = || self.numbers().into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0));
        if let Some((key, value)) = signed.or_else(others) {
            return Err(InvalidCoefficients::Number { key: key.to_owned(), value });
        }
        match self.robot.filter_cutoff_hz {
            value if value < LEAST_CUTOFF => Err(InvalidCoefficients::Cutoff { value }),
            _ => Ok(()),
        }
    }

    /// 0 where the sides are alike.
    fn imbalance(&self) -> f64 {
        self.parameters.get(IMBALANCE.name).and_then(number).unwrap_or(0.0)
    }

    /// What has to be finite and not below 0.
    fn numbers(&self) -> Vec<(&str, f64)> {
        let parameters = self.parameters.iter().filter(|(name, _)| name.as_str() != IMBALANCE.name);
        let parameters = parameters.filter_map(|(name, value)| Some((name.as_str(), number(value)?)));
        let others = [
            ("density_w2_s", self.noise.density_w2_s),
            ("model_std_w", self.noise.model_std_w.unwrap_or(0.0)),
            ("power_scale_w", self.noise.power_scale_w),
            ("tail", self.noise.tail),
            ("residual_std_w", self.noise.residual_std_w),
            ("energy_std_share", self.fit.energy_std_share),
            ("energy_std_w", self.fit.energy_std_w),
            (CUTOFF, self.robot.filter_cutoff_hz),
            ("half_slip", self.robot.half_slip),
            ("slip_relaxation_rad", self.robot.slip_relaxation_rad),
            ("slip_rest_rad_s", self.robot.slip_rest_rad_s),
            (TRUE_SLIP, self.robot.true_slip_s_rad),
        ];
        parameters.chain(others).collect()
    }
}
