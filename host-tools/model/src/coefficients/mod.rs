//! coefficients.toml: what `gmr fit` writes, `gmr gap --out` extends, and every other command
//! reads. One typed value, read once and written once; the file's layout is `document`'s.

mod covariance;
mod document;
mod error;
mod fingerprint;
mod fitted_model;
mod kind;
mod logs;
mod parameters;
mod robot;
mod usability;

use std::path::{Path, PathBuf};

use ::logs::robot::Robot;
use ::logs::robot::chassis::Chassis;
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::model::Model;
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use support::context::Context;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};
use support::output::write_content;

pub use self::error::{Difference, InvalidCoefficients, InvalidCovariance};
pub use self::fitted_model::FittedModel;
pub use self::kind::{Method, ModelKind};
pub use self::logs::FittedLog;
pub use self::parameters::{BRIDGE_DROP, EQ18, GEAR_LOSS, IMBALANCE, Quantity, TORQUE};
pub use self::usability::{Usability, of_r2};

use self::document::{
    Document, ExtensionSection, FORMAT, FORMAT_WITH_GEAR, FORMAT_WITH_GYRO, FORMAT_WITH_TRAITS, FitSection,
    NoiseSection,
};
use crate::effects::written::{self, Written, Wrong};

/// What is said of coefficients whose ground cannot adapt.
pub const GROUND_NEEDS: &str =
    "coefficients of eq18, or with effects, on ground that adapts; expected those of gmr fit --model signed";

/// Whether the coefficients of a file can be used with a robot, with a gyro or without.
///
/// # Errors
/// As [`CoefficientsFile::read_with_gyro`].
pub fn check(file: &Path, robot: &Robot) -> Result<()> {
    CoefficientsFile::read_with_gyro(file, robot).map(drop)
}

/// Coefficients with where they come from.
#[derive(Debug, Clone)]
pub struct CoefficientsFile {
    /// What estimator and board run; the robot as its own file says it now.
    pub coefficients: FittedModel,
    /// Which model.
    pub kind: ModelKind,
    /// How it was fitted.
    pub method: Method,
    /// Covariance of the parameters, in the order of [`TORQUE`] or [`EQ18`]; no row for scrub where
    /// the wheels do not.
    pub covariance: DMatrix<f64>,
    /// Of the parameters, then the coefficients of the effects' columns; `None` without effects,
    /// and of files that do not tell.
    pub joint_covariance: Option<DMatrix<f64>>,
    /// What was added to the fitted model; [`FittedModel::columns`] is what estimators make of it.
    pub effects: Vec<Written>,
    /// What it was fitted to.
    pub origin: Origin,
}

/// What coefficients were fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// The logs.
    pub logs: Vec<FittedLog>,
    /// Their rows.
    pub rows: u64,
    /// Total masses met, kg.
    pub masses_kg: Vec<f64>,
    /// Static power that was taken off, W.
    pub static_power_w: f64,
    /// R² on these rows; none where their power never changes.
    pub r2: Option<f64>,
    /// Root mean square of the residual, W.
    pub rmse_w: f64,
    /// Standard deviation of a drive's energy about the model's, beyond the noise, as a share of
    /// it; 0 in files that do not tell.
    pub energy_std_share: f64,
    /// Standard deviation of the mean power of one kind of driving about a fit to the others,
    /// beyond the noise, W; 0 in files that do not tell.
    pub energy_std_w: f64,
    /// Whether the fit can be used.
    pub usability: Usability,
}

/// What a reader of coefficients takes besides those that every reader does.
#[derive(Clone, Copy, Default)]
pub struct Taking<'a> {
    /// True slip: the reader gives the turn rate of a gyro with every sample.
    pub true_slip: bool,
    /// Coefficients that are marked as not usable; this call says so.
    pub not_usable: Option<&'a Context>,
}

impl CoefficientsFile {
    /// Reads coefficients and checks that they are for this robot. Those with true slip are
    /// refused, for most of what asks for coefficients has no gyro:
    /// [`read_with_gyro`](Self::read_with_gyro).
    ///
    /// # Errors
    /// The file cannot be read, is of another format, is for another robot, holds what no model can
    /// have, or true slip: an
    /// [`InvalidCoefficients`] as [`Error::cause`].
    pub fn read(file: &Path, robot: &Robot) -> Result<Self> {
        Self::read_taking(file, robot, Taking::default())
    }

    /// The same for whoever gives the turn rate of a gyro with every sample.
    ///
    /// # Errors
    /// As [`read`](Self::read), but for true slip.
    pub fn read_with_gyro(file: &Path, robot: &Robot) -> Result<Self> {
        Self::read_taking(file, robot, Taking { true_slip: true, ..Taking::default() })
    }

    /// The same for a reader that takes more, or less.
    ///
    /// # Errors
    /// As [`read`](Self::read), but for what is taken.
    pub fn read_taking(file: &Path, robot: &Robot, taking: Taking<'_>) -> Result<Self> {
        Self::parse(&read_text(file, MOST_DESCRIPTION)?, file, robot, taking)
    }

    /// As [`read_taking`](Self::read_taking), of the text that `file` holds.
    ///
    /// # Errors
    /// As [`read_taking`](Self::read_taking).
    pub fn parse(text: &str, file: &Path, robot: &Robot, taking: Taking<'_>) -> Result<Self> {
        let refused = |wrong: InvalidCoefficients| {
            let (key, line) = (wrong.key().map(str::to_owned), wrong.line(text));
            let mut error = Error::of(wrong).in_file(file);
            if let Some(key) = key {
                error = error.in_column(key);
            }
            match line {
                Some(line) => error.at_line(line),
                None => error,
            }
        };
        let document = Document::parse(text).map_err(refused)?;
        let fitted = robot::of_section(&document.robot, robot)?.map_err(refused)?;
        let now = robot.chassis(fitted.cutoff_hz())?.with_conditioning(*fitted.conditioning());
        let drives = document.model == ModelKind::Signed;
        robot::check(&fitted, document.robot.regeneration, &now, robot, drives)
            .map_err(|difference| refused(InvalidCoefficients::OtherRobot(difference)))?;
        let read = Self::of_document(document, now, logs::folder_of(file)).map_err(refused)?;
        if read.coefficients.robot.conditioning().true_slip != 0.0 && !taking.true_slip {
            return Err(refused(InvalidCoefficients::TrueSlip));
        }
        if let Usability::NotUsable(why) = &read.origin.usability {
            let Some(context) = taking.not_usable else {
                return Err(refused(InvalidCoefficients::NotUsable(why.clone())));
            };
            context
                .notice(format_args!("{}: NOT USABLE ({why}), and used because of --force", file.display()));
        }
        Ok(read)
    }

    /// What a document means for a robot; its logs are seen from `folder`.
    fn of_document(
        document: Document,
        robot: Chassis,
        folder: &Path,
    ) -> std::result::Result<Self, InvalidCoefficients> {
        document.check_numbers()?;
        let drive = if document.robot.regeneration { Drive::Regenerative } else { Drive::Dissipative };
        let scrubs = robot.scrubs();
        let model = parameters::model(document.model, &document.parameters, scrubs, drive)?;
        let lasting = document.noise.lasting_w()?;
        let noise = Noise {
            density: document.noise.density_w2_s,
            model_std: lasting.unwrap_or(0.0),
            tail: document.noise.tail,
            residual_std: document.noise.residual_std_w,
        };
        let size = parameters::named(&model, scrubs).len();
        let covariance =
            covariance::of_rows(&document.fit.covariance, size).map_err(InvalidCoefficients::Covariance)?;
        let FitSection {
            rows,
            logs,
            fingerprints,
            weighed_kg,
            masses_kg,
            r2,
            rmse_w,
            energy_std_share,
            energy_std_w,
            verdict,
            why_not,
            ..
        } = document.fit;
        let fingerprints = fingerprints.into_iter().map(|text| (!text.is_empty()).then_some(text));
        let fingerprints = fingerprints.chain(std::iter::repeat(None));
        let weighed = weighed_kg.into_iter().map(|mass| (mass > 0.0).then_some(mass));
        let weighed = weighed.chain(std::iter::repeat(None));
        let logs = logs.into_iter().zip(fingerprints).zip(weighed);
        let logs = logs.map(|((log, fingerprint), weighed_kg)| FittedLog {
            path: folder.join(log),
            fingerprint,
            weighed_kg,
        });
        let plain = Self {
            coefficients: FittedModel {
                robot,
                model,
                noise,
                columns: Columns::NONE,
                identifies_mass: lasting.is_some(),
            },
            kind: document.model,
            method: document.method,
            covariance,
            joint_covariance: None,
            effects: Vec::new(),
            origin: Origin {
                logs: logs.collect(),
                rows,
                masses_kg,
                static_power_w: document.robot.static_power_w,
                r2: r2.is_finite().then_some(r2),
                rmse_w,
                energy_std_share,
                energy_std_w,
                usability: Usability::of_file(verdict, why_not, r2),
            },
        };
        let extended = plain.with_effects(document.effects).map_err(InvalidCoefficients::Effect)?;
        let Some(extension) = document.extension else { return Ok(extended) };
        let joint =
            covariance::of_rows(&extension.joint_covariance, size + extended.coefficients.columns.len())
                .map_err(InvalidCoefficients::Covariance)?;
        Ok(Self { joint_covariance: Some(joint), ..extended })
    }

    /// Writes them, whole or not at all.
    ///
    /// # Errors
    /// What the operating system refuses; a covariance that is none.
    pub fn write(&self, file: &Path) -> Result<()> {
        write_content(file, self.text(file)?)
    }

    /// As `file` would hold them.
    ///
    /// # Errors
    /// A covariance that is none.
    pub fn text(&self, file: &Path) -> Result<String> {
        let document = self.document(file).map_err(|wrong| {
            Error::of(InvalidCoefficients::Covariance(wrong)).in_file(file).in_column("covariance")
        })?;
        toml::to_string(&document).map_err(|error| Error::failed(error.to_string()).in_file(file))
    }

    /// As `file` holds them.
    fn document(&self, file: &Path) -> std::result::Result<Document, InvalidCovariance> {
        let FittedModel { robot, model, noise, identifies_mass, .. } = &self.coefficients;
        let regeneration = matches!(model, Model::Signed { drive: Drive::Regenerative, .. });
        let scrubs = robot.scrubs();
        let covariance = covariance::rounded(&self.covariance)?;
        let joint = self.joint_covariance.as_ref().map(covariance::rounded).transpose()?;
        let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
            matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
        };
        let (verdict, why_not) = self.origin.usability.section();
        let (parameters, traits) = (parameters::named(model, scrubs), parameters::traits(model));
        let has_losses = traits.iter().any(|(name, _)| [GEAR_LOSS.name, BRIDGE_DROP.name].contains(name));
        Ok(Document {
            format: if has_losses || robot.conditioning().slip.rest != 0.0 {
                FORMAT_WITH_GEAR
            } else if robot.conditioning().true_slip != 0.0 {
                FORMAT_WITH_GYRO
            } else if *robot.conditioning() == Conditioning::PLAIN && traits.is_empty() {
                FORMAT
            } else {
                FORMAT_WITH_TRAITS
            },
            model: self.kind,
            method: self.method,
            robot: robot::section(robot, self.origin.static_power_w, regeneration),
            parameters: parameters
                .into_iter()
                .chain(traits)
                .map(|(name, value)| (name.to_owned(), toml::Value::Float(value)))
                .collect(),
            noise: NoiseSection::of(noise, *identifies_mass),
            fit: FitSection {
                rows: self.origin.rows,
                logs: self.origin.logs.iter().map(|log| logs::seen_from(file, &log.path)).collect(),
                fingerprints: self
                    .origin
                    .logs
                    .iter()
                    .map(|log| log.fingerprint.clone().unwrap_or_default())
                    .collect(),
                weighed_kg: if self.origin.logs.iter().any(|log| log.weighed_kg.is_some()) {
                    self.origin.logs.iter().map(|log| log.weighed_kg.unwrap_or(f64::NAN)).collect()
                } else {
                    Vec::new()
                },
                masses_kg: self.origin.masses_kg.clone(),
                r2: self.origin.r2.unwrap_or(f64::NAN),
                rmse_w: self.origin.rmse_w,
                energy_std_share: self.origin.energy_std_share,
                energy_std_w: self.origin.energy_std_w,
                verdict: Some(verdict),
                why_not,
                covariance: rows(&covariance),
            },
            extension: joint.map(|joint| ExtensionSection { joint_covariance: rows(&joint) }),
            effects: self.effects.clone(),
        })
    }

    /// The robot with what was weighed with the logs of this fit: they do not say it themselves.
    ///
    /// # Errors
    /// As [`Robot::with_log_units`].
    pub fn with_weighed(&self, robot: &Robot) -> Result<Robot> {
        let mut units = robot.log_units().clone();
        let weighed = self.origin.logs.iter().filter_map(|log| Some((log.path.clone(), log.weighed_kg?)));
        units.masses.extend(weighed);
        robot.clone().with_log_units(units)
    }

    /// The same with the torque model as it moved.
    #[must_use]
    pub fn with_torque(mut self, moved: &TorqueModel<f64>) -> Self {
        if let Model::Signed { torque, .. } = &mut self.coefficients.model {
            // A little below nought is nought: no robot has less (Eq. 20).
            *torque = torque.with_array(moved.to_array().map(|value| value.max(0.0)));
        }
        self
    }

    /// The same with what is known of the extended model: the covariance of parameters and effects,
    /// and the noise that mass estimates have to expect.
    #[must_use]
    pub fn with_joint_covariance(mut self, joint: DMatrix<f64>, noise: Noise<f64>) -> Self {
        self.joint_covariance = Some(joint);
        self.coefficients.noise = noise;
        self
    }

    /// The same with these effects in the place of its own.
    ///
    /// # Errors
    /// The effect that is unknown, lacks something, or makes powers that no robot draws.
    pub fn with_effects(mut self, effects: Vec<Written>) -> std::result::Result<Self, Wrong> {
        let wheels = self.coefficients.robot.wheels();
        let columns = written::columns(&effects, wheels)?;
        let has_torques = matches!(self.coefficients.model, Model::Signed { .. });
        for (place, effect) in effects.iter().enumerate() {
            let wrong = |key, message| Wrong { place, key, message };
            if !has_torques {
                let message = format!(
                    "{} beside model eq18; expected model signed: effects act on its torques",
                    effect.id
                );
                return Err(wrong("id", message));
            }
            let columns = written::columns(std::slice::from_ref(effect), wheels)?;
            if !(FittedModel { columns, ..self.coefficients.clone() }).is_plausible() {
                let message = format!(
                    "{} with coefficient {} makes powers that no robot draws",
                    effect.id, effect.coefficient
                );
                return Err(wrong("coefficient", message));
            }
        }
        self.coefficients.columns = columns;
        self.effects = effects;
        Ok(self)
    }

    /// The logs that they were fitted to, as far as these are still there; `file` is where they
    /// were read.
    ///
    /// # Errors
    /// A log is no longer what was fitted.
    pub fn logs_still_there(&self, context: &Context, file: &Path) -> Result<Vec<PathBuf>> {
        let mut there = Vec::new();
        for log in &self.origin.logs {
            if log.is_there(file)? {
                there.push(log.path.clone());
            }
        }
        let all = self.origin.logs.len();
        if !there.is_empty() && there.len() < all {
            context.notice(format_args!(
                "{}: {} of the {all} clean runs are no longer where they were, and are done without",
                file.display(),
                all - there.len()
            ));
        }
        Ok(there)
    }
}
