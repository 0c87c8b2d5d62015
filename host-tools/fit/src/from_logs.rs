//! What `gmr fit` asks of logs, and what it is told.

use std::path::{Path, PathBuf};

use logs::robot::Robot;
use model::coefficients::{Method, ModelKind};
use model_core::coefficients::Image;
use model_core::model::Model;
use serde::Serialize;
use support::context::Context;
use support::error::Result;
use support::metrics::Quality;

use crate::dataset::{Dataset, Reading};
use crate::form::{Judged, Term};
use crate::linear::Certificate;
use crate::physical::{Huber, Restarts};
use crate::usable::Defect;
use crate::verdict::Parameter;
use crate::warning::Warning;
use crate::{Fit, entrance, fit, pgd, physical, read_choosing};

/// What a fit is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot, which knows in which units its logs are.
    pub robot: &'a Robot,
    /// Logs with known payload.
    pub files: &'a [PathBuf],
    /// Total mass of logs that do not tell it, kg.
    pub mass_kg: f64,
    /// Which model.
    pub kind: ModelKind,
    /// Further terms of the signed model that the logs may ask for.
    pub terms: &'a [Term],
    /// Which method.
    pub method: Method,
    /// Of Algorithm 1.
    pub pgd: &'a pgd::Settings,
    /// So many random starts are held against the fit on its own cost.
    pub random_starts: u32,
    /// Where the coefficients are to be written.
    pub out: Option<&'a Path>,
    /// What makes the logs ones that no fit can be used of.
    pub defect: Option<&'a Defect>,
    /// Whether those of a fit that cannot be used are written as well.
    pub force: bool,
}

/// What a fit is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Use {
    /// Power and payload.
    Usable,
    /// No payload can be found with it.
    UsableForPower,
    /// Nothing.
    NotUsable,
}

/// A fit as it is told.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// What it is good for.
    pub verdict: Use,
    /// Why it cannot be used.
    pub why: Option<String>,
    /// The one thing to do about that.
    pub remedy: Option<String>,
    /// The robot's name.
    pub robot: String,
    /// Which model.
    pub model: ModelKind,
    /// Which method.
    pub method: Method,
    /// Errors on the fitted rows.
    #[serde(flatten)]
    pub quality: Quality,
    /// Rows read.
    pub rows: u64,
    /// Total masses met.
    pub masses_kg: Vec<f64>,
    /// Of the filter.
    pub filter_cutoff_hz: f64,
    /// Share of the rows in which no wheel draws power.
    pub idle_share: f64,
    /// Of the parameters' information; none where it is singular.
    pub condition: Option<f64>,
    /// How the solver ended.
    pub ending: String,
    /// Beyond it residuals count linearly; none where all count squared.
    pub huber_threshold_std: Option<f64>,
    /// Steps that the solver took.
    pub iterations: u64,
    /// What random starts found, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restarts: Option<Restarts>,
    /// Time for the solver alone.
    pub fit_s: f64,
    /// Algorithm 1's distance from the optimum.
    pub pgd: Option<Certificate>,
    /// Of the power's noise.
    pub noise_density_w2_s: f64,
    /// What the parameters' scatter does to the predicted power.
    pub prediction_std_w: f64,
    /// One by one.
    pub parameters: Vec<Parameter>,
    /// 0 where the power is not late.
    pub power_delay_s: f64,
    /// Slip at which half of the scrub has built up.
    pub half_slip: f64,
    /// The angle that wheels roll meanwhile.
    pub slip_relaxation_rad: f64,
    /// Difference of the sides that is hardly a turn; 0 for the dead band.
    pub slip_rest_rad_s: f64,
    /// How much of the scrub a rad/s of true slip adds.
    pub true_slip_s_rad: f64,
    /// Share of the friction that passes a gear with a loss of its own.
    pub wheel_friction_share: f64,
    /// What unseen blocks said of each further term.
    pub terms: Vec<Judged>,
    /// What the logs look like, then what the fit says against itself.
    pub warnings: Vec<Warning>,
    /// Why payloads estimated with it are unknown.
    #[serde(skip)]
    pub shortcoming: Option<String>,
    /// As a board would hold it, but for its gyro; none where no board has such a model.
    #[serde(skip)]
    pub image: Option<Image>,
    /// What is to be written, where that was asked for and may be.
    #[serde(skip)]
    pub written: Option<String>,
}

/// Reads the logs, doubts them, and fits the model, the signed one with those of the terms that
/// they ask for.
///
/// # Errors
/// A log that cannot be read or is not one of this robot; power that is 0 all the time; data that
/// determine no model.
pub fn from_logs(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { robot, files, mass_kg, out, defect, force, .. } = *request;
    let mut warnings = entrance::look(context, robot, files, mass_kg)?;
    let mut fit = fit_logs(context, request)?;
    fit.defect = defect.cloned().or(fit.defect);
    // What the logs look like explains what the fit says of itself.
    warnings.append(&mut fit.warnings);
    let out = out.filter(|_| fit.defect.is_none() || force);
    let written = out.map(|out| written(&fit, robot, out)).transpose()?;
    Ok(told(fit, robot, warnings, written))
}

/// As `out` holds it.
fn written(fit: &Fit, robot: &Robot, out: &Path) -> Result<String> {
    let mut file = fit.to_file()?;
    for log in &mut file.origin.logs {
        log.weighed_kg = robot.log_units().mass_of(&log.path);
    }
    file.text(out)
}

fn told(fit: Fit, robot: &Robot, warnings: Vec<Warning>, written: Option<String>) -> Answer {
    // That a gyro is needed is said by a warning; what else it holds can still be absurd.
    let image = fit.image();
    let conditioning = *fit.robot.conditioning();
    let verdict = match (&fit.defect, &fit.shortcoming) {
        (Some(_), _) => Use::NotUsable,
        (None, Some(_)) => Use::UsableForPower,
        (None, None) => Use::Usable,
    };
    let (why, remedy) = fit.defect.map(|Defect { why, remedy }| (why, remedy)).unzip();
    Answer {
        verdict,
        why,
        remedy,
        robot: robot.name().to_owned(),
        model: fit.kind,
        method: fit.method,
        quality: fit.quality,
        rows: fit.rows,
        masses_kg: fit.masses,
        filter_cutoff_hz: fit.robot.cutoff_hz(),
        idle_share: fit.idle_share,
        condition: Some(fit.uncertainty.condition).filter(|condition| condition.is_finite()),
        ending: fit.ending,
        huber_threshold_std: fit.huber.map(|Huber { threshold_std, .. }| threshold_std),
        iterations: fit.iterations,
        restarts: fit.restarts,
        fit_s: fit.solve_s,
        pgd: fit.certificate,
        noise_density_w2_s: fit.noise.density,
        prediction_std_w: fit.uncertainty.prediction_std_w,
        parameters: fit.parameters,
        power_delay_s: conditioning.delay,
        half_slip: conditioning.slip.half_slip,
        slip_relaxation_rad: conditioning.slip.relaxation,
        slip_rest_rad_s: conditioning.slip.rest,
        true_slip_s_rad: conditioning.true_slip,
        wheel_friction_share: match &fit.model {
            Model::Signed { torque, .. } => torque.wheel_friction_share,
            Model::Eq18 { .. } => 0.0,
        },
        terms: fit.judged,
        warnings,
        shortcoming: fit.shortcoming,
        image,
        written,
    }
}

/// Reads the logs and fits the model, the signed one with those of the terms that the logs ask for.
fn fit_logs(context: &Context, request: &Request<'_>) -> Result<Fit> {
    let Request { robot, files, mass_kg, kind, terms, method, pgd, random_starts, .. } = *request;
    let reading = Reading { gate: kind.gate(), cutoff_hz: None, mass_kg };
    let read = |terms: &[Term]| read_choosing(context, robot, files, &reading, terms);
    let (fitted, dataset) = fit_choosing(robot, kind, method, pgd, terms, read)?;
    let restarts = match &fitted.model {
        Model::Signed { torque, .. } if random_starts > 0 => {
            Some(physical::restart(&dataset, robot, torque, fitted.huber, random_starts))
        }
        _ => None,
    };
    Ok(Fit { restarts, ..fitted })
}

/// Fits the model to what `read` makes of these further terms, or of fewer.
pub(super) fn fit_choosing(
    robot: &Robot,
    kind: ModelKind,
    method: Method,
    pgd: &pgd::Settings,
    terms: &[Term],
    read: impl Fn(&[Term]) -> Result<(Dataset, Vec<Judged>)>,
) -> Result<(Fit, Dataset)> {
    let mut terms = terms.to_vec();
    loop {
        let (dataset, judged) = read(&terms)?;
        let fitted = fit(robot, &dataset, kind, method, pgd)?;
        // What no board takes is no robot's: a term that ends so explains chance, and the form
        // without it is asked.
        let taken = judged.iter().rev().find(|judged| judged.taken).map(|judged| judged.term);
        match taken.filter(|_| fitted.shortcoming.is_none() && !fitted.is_plausible()) {
            Some(last) => terms.retain(|term| *term != last),
            None => return Ok((Fit { judged, ..fitted }, dataset)),
        }
    }
}
