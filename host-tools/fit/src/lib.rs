//! Step one of the paper: coefficients from logs whose payload is known.
//!
//! Its face: [`fit`], from files to coefficients with standard errors and a verdict on every
//! parameter;
//! [`run_gram`], all that a fit needs to know of a run, as sums that add up.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod assess;
mod cutoff;
pub mod dataset;
pub mod entrance;
pub mod form;
pub mod from_grams;
pub mod from_logs;
pub mod gram;
mod kinds;
pub mod linear;
pub mod nnls;
mod of_runs;
pub mod pgd;
pub mod physical;
mod pilot;
mod rows;
pub mod run_gram;
mod stored;
mod unseen;
pub mod usable;
pub mod verdict;
pub mod warning;

use std::path::PathBuf;
use std::time::Instant;

use logs::foreign;
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model_core::coefficients::Image;
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::eq18::{self, Gate};
use model_core::model::Model;
use model_core::payload::Noise;
use model_core::torque::TorqueModel;
use nalgebra::DVector;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::Quality;

use self::assess::Uncertainty;
use self::dataset::{Dataset, Kept, Reading};
use self::form::{Choice, Form, Judged, Term};
pub use self::of_runs::of_runs;
use self::pilot::Pilots;
use self::usable::{Defect, MassEffect};
use self::verdict::Parameter;
use self::warning::Warning;
use model::coefficients::{FittedModel, Method, ModelKind};

/// A model, what it is worth, and how it was found.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The robot, with the filter's cutoff.
    pub robot: Chassis,
    /// The model.
    pub model: Model<f64>,
    /// What estimates with it have to expect.
    pub noise: Noise<f64>,
    /// Whether it can tell payloads.
    pub identifies_mass: bool,
    /// Which model.
    pub kind: ModelKind,
    /// Which method.
    pub method: Method,
    /// Errors on the fitted rows.
    pub quality: Quality,
    /// The parameters one by one.
    pub parameters: Vec<Parameter>,
    /// Their covariance and what is undetermined.
    pub uncertainty: Uncertainty,
    /// How the solver ended.
    pub ending: String,
    /// Steps that it took.
    pub iterations: u64,
    /// Algorithm 1's distance from the optimum.
    pub certificate: Option<linear::Certificate>,
    /// Share of the rows in which no wheel draws power, by the model: at rest or clamped.
    pub idle_share: f64,
    /// The logs that it was fitted to.
    pub files: Vec<PathBuf>,
    /// Payloads met, kg.
    pub masses: Vec<f64>,
    /// Rows read.
    pub rows: u64,
    /// Time for the solver alone, without reading, s.
    pub solve_s: f64,
    /// Why payloads estimated with these coefficients are unknown, in one line; `None` where they
    /// are not.
    pub shortcoming: Option<String>,
    /// Why the fit cannot be used; `None` where it can.
    pub defect: Option<Defect>,
    /// Which residuals counted linearly, not squared; `None` where all counted squared.
    pub huber: Option<physical::Huber>,
    /// What random starts found, where they were asked for.
    pub restarts: Option<physical::Restarts>,
    /// What keeps the coefficients from being what they look like.
    pub warnings: Vec<Warning>,
    /// Standard deviation of a drive's energy about the model's, beyond the noise, as a share of it
    /// ([`assess::energy_spread`]).
    pub energy_std_share: f64,
    /// Standard deviation of the mean power of one kind of driving about a fit to the others,
    /// beyond the noise, W.
    pub energy_std_w: f64,
    /// What unseen blocks said of each further term; empty where none was asked for.
    pub judged: Vec<Judged>,
}

impl Fit {
    /// What `gmr estimate` and the board run.
    pub fn coefficients(&self) -> FittedModel {
        FittedModel {
            robot: self.robot.clone(),
            model: self.model,
            noise: self.noise,
            columns: Columns::NONE,
            identifies_mass: self.identifies_mass,
        }
    }

    /// Whether a robot can be so.
    fn is_plausible(&self) -> bool {
        self.coefficients().is_plausible()
    }

    /// As a board would hold it, but for its gyro; `None` where no board has such a model.
    fn image(&self) -> Option<Image> {
        let conditioning = Conditioning { true_slip: 0.0, ..*self.robot.conditioning() };
        FittedModel { robot: self.robot.with_conditioning(conditioning), ..self.coefficients() }.encode()
    }
}

/// Reads the logs: the first rows of each to choose the filter's cutoff unless it is given, and the
/// signed model's further terms ([`form`]), then each once.
///
/// # Errors
/// As [`Dataset::read`].
pub fn read(context: &Context, robot: &Robot, files: &[PathBuf], reading: &Reading) -> Result<Dataset> {
    Ok(read_choosing(context, robot, files, reading, &form::TERMS)?.0)
}

/// As [`read`], with what the first rows said of each of these further terms of the signed
/// model; other models have none.
///
/// # Errors
/// As [`read`].
pub fn read_choosing(
    context: &Context,
    robot: &Robot,
    files: &[PathBuf],
    reading: &Reading,
    terms: &[Term],
) -> Result<(Dataset, Vec<Judged>)> {
    if files.is_empty() {
        return Err(Error::usage("no log was given"));
    }
    foreign::prepare(context, files);
    let pilots = Pilots::read(context, robot, files, reading.mass_kg)?;
    let given = reading.cutoff_hz.or(robot.filter_cutoff_hz());
    let terms = if reading.gate == Gate::Signed { terms } else { &[] };
    let (cutoff_hz, choice) = match given {
        Some(given) => (given, form::choose(robot, &robot.chassis(given)?, terms, &pilots, &|_| false, None)),
        None => cutoff::by_the_data(robot, &pilots, terms)?,
    };
    let core = robot.chassis(cutoff_hz)?.with_conditioning(choice.form.conditioning);
    let mut dataset = Dataset::read(context, robot, core, files, reading)?;
    dataset.free_terms = choice.form.free_terms;
    dataset.long_search = choice.long_search;
    Ok((dataset, choice.judged))
}

/// The filter's cutoff for these logs as [`read`] chooses it, Hz: the robot's, or by the data.
///
/// # Errors
/// A log that cannot be read.
pub fn choose_cutoff(context: &Context, robot: &Robot, files: &[PathBuf], mass_kg: f64) -> Result<f64> {
    match robot.filter_cutoff_hz() {
        Some(given) => Ok(given),
        None => {
            Ok(cutoff::by_the_data(robot, &Pilots::read(context, robot, files, mass_kg)?, &form::TERMS)?.0)
        }
    }
}

/// Chooses among further terms of the signed model for logs that are to be read as `core` says,
/// without the rows of `held_out` times (s).
///
/// # Errors
/// A log that cannot be read.
pub fn choose_form(
    context: &Context,
    robot: &Robot,
    core: &Chassis,
    terms: &[Term],
    files: &[PathBuf],
    mass_kg: f64,
    held_out: &(dyn Fn(f64) -> bool + Sync),
) -> Result<Form> {
    let pilots = Pilots::read(context, robot, files, mass_kg)?;
    Ok(form::choose(robot, core, terms, &pilots, held_out, None).form)
}

/// Terms that a fit of these logs would take beyond those that `core` and the model `known` of them
/// have, by unseen blocks: none for what this version fitted to them. What a fit would leave out
/// again is not lacking.
///
/// # Errors
/// A log that cannot be read.
pub fn lacking(
    context: &Context,
    robot: &Robot,
    core: &Chassis,
    known: &TorqueModel<f64>,
    terms: &[Term],
    files: &[PathBuf],
    mass_kg: f64,
) -> Result<Vec<Judged>> {
    let pilots = Pilots::read(context, robot, files, mass_kg)?;
    let Choice { form, mut judged, .. } = form::choose(robot, core, terms, &pilots, &|_| false, Some(known));
    judged.retain(|judged| judged.taken);
    if judged.iter().any(|judged| judged.term == Term::GearLoss) {
        let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg };
        let core = core.clone().with_conditioning(form.conditioning);
        let mut dataset = Dataset::read(context, robot, core, files, &reading)?;
        dataset.free_terms = form.free_terms;
        form::keep_what_stays(&mut judged, &physical::solve(&dataset, robot));
    }
    Ok(judged)
}

/// Fits the model to what was read.
///
/// # Errors
/// The data cannot determine a model: the robot stood still.
pub fn fit(
    robot: &Robot,
    dataset: &Dataset,
    kind: ModelKind,
    method: Method,
    pgd: &pgd::Settings,
) -> Result<Fit> {
    let method = method.check(kind)?;
    let shortcoming = shortcoming(dataset)?;
    let started = Instant::now();
    let everything = vec![1.0; dataset.store.len()];
    let mut certificate = None;
    let (mut huber, mut warnings, mut at_bounds) = (None, Vec::new(), Vec::new());
    let mut cut_short = None;
    let (model, ending, iterations, weights) = match kind {
        ModelKind::Signed => {
            let solution = physical::solve(dataset, robot);
            if let Some(at) = solution.unusable_gear_loss() {
                let mut without = dataset.clone();
                without.free_terms.gear_loss = None;
                let mut fit = fit(robot, &without, kind, method, pgd)?;
                fit.warnings.push(Warning::left_out(at));
                return Ok(fit);
            }
            let model = Model::Signed { torque: solution.torque, drive: robot.drive() };
            huber = solution.huber;
            warnings.extend(solution.at_bounds.iter().map(Warning::at_bound));
            at_bounds = solution.at_bounds;
            let steps = dataset.long_search.into_iter().chain([solution.iterations]).max().unwrap_or(0);
            if steps > physical::MOST_STEPS {
                cut_short = Some(steps).filter(|_| !solution.ending.has_converged());
                warnings.push(Warning::long_search(steps));
            }
            if !solution.ending.has_converged() {
                warnings.push(Warning::not_converged(&ending_name(&solution.ending)));
            }
            (model, ending_name(&solution.ending), u64::from(solution.iterations), solution.weights)
        }
        ModelKind::Eq18 | ModelKind::Eq18Published => {
            let gram = dataset.gram();
            let (beta, ending, iterations) = if method == Method::Pgd {
                let (beta, solution) = linear::by_pgd(&gram, pgd);
                certificate = Some(solution);
                (beta, ending_name(&solution.ending), solution.iterations)
            } else {
                let (beta, solution) = linear::by_nnls(&gram);
                (beta, ending_name(&solution.ending), u64::from(solution.iterations))
            };
            (Model::Eq18 { gate: kind.gate(), beta: beta.into() }, ending, iterations, everything)
        }
    };
    let solve_s = started.elapsed().as_secs_f64();
    let mut noise = assess::noise(dataset, &model);
    let (judgement, quality) = rayon::join(
        || judge(dataset, &model, &weights, &noise),
        || assess::quality(dataset, &model, robot.mape_floor_w()),
    );
    let Judgement { uncertainty, parameters, lasting_error, energy_std_w, mass_effect } = judgement;
    let quality =
        quality.ok_or_else(|| Error::failed("the fitted model predicts no finite power for any row"))?;
    // With one payload or speed the model's dependence on the mass is a guess: no window says
    // anything about it.
    let identifies_mass = shortcoming.is_none();
    noise.model_std = if identifies_mass { lasting_error } else { 0.0 };
    let energy_std_share = assess::energy_spread(dataset, &model, &noise);
    let mass_effect = mass_effect.filter(|_| identifies_mass);
    let defect = usable::defect(&quality, &at_bounds, mass_effect.as_ref(), cut_short);
    warnings.extend(warning::of_quality(&quality));
    if dataset.robot.conditioning().true_slip != 0.0 {
        warnings.push(Warning::needs_gyro());
    }
    let mut files: Vec<PathBuf> = dataset.runs.iter().map(|run| run.file.clone()).collect();
    files.dedup();
    let unused = weights.iter().filter(|weight| **weight == 0.0).count();
    let mut fit = Fit {
        robot: dataset.robot.clone(),
        model,
        noise,
        identifies_mass,
        kind,
        method,
        quality,
        parameters,
        uncertainty,
        ending,
        iterations,
        certificate,
        idle_share: unused as f64 / weights.len().max(1) as f64,
        files,
        masses: dataset.masses.clone(),
        rows: dataset.rows,
        solve_s,
        shortcoming,
        defect,
        huber,
        restarts: None,
        warnings,
        energy_std_share,
        energy_std_w,
        judged: Vec::new(),
    };
    // Where payloads are unknown, a warning says so already, and boards need not take the fit.
    if fit.shortcoming.is_none() && !fit.is_plausible() {
        fit.warnings.push(Warning::not_for_boards());
    }
    Ok(fit)
}

fn ending_name(ending: &impl Serialize) -> String {
    match serde_json::to_value(ending) {
        Ok(serde_json::Value::String(name)) => name,
        _ => "unknown".to_owned(),
    }
}

/// What the data say about a fitted model.
struct Judgement {
    uncertainty: Uncertainty,
    parameters: Vec<Parameter>,
    /// What lasts longer than a window, W: the greater of [`assess::lasting_error`] and
    /// [`unseen::lasting_errors`].
    lasting_error: f64,
    /// Of the energy, W: [`unseen::Lasting::energy_w`].
    energy_std_w: f64,
    /// What the payload does to the power; `None` of one payload.
    mass_effect: Option<MassEffect>,
}

/// What the payload does to the power by a model, with the scatter of its parameters.
fn mass_effect(
    dataset: &Dataset,
    predict: impl Fn(&Kept<'_>) -> f64,
    gradient: impl Fn(&Kept<'_>) -> DVector<f64>,
    uncertainty: &Uncertainty,
) -> Option<MassEffect> {
    if dataset.masses.len() < 2 {
        return None;
    }
    let light = dataset.masses.iter().copied().fold(f64::INFINITY, f64::min);
    let heavy = dataset.masses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut difference = 0.0;
    let mut slopes = DVector::zeros(uncertainty.covariance.nrows());
    for row in dataset.store.iter() {
        let [at_light, at_heavy] = [light, heavy].map(|mass| Kept { mass, ..row });
        difference += predict(&at_heavy) - predict(&at_light);
        slopes += gradient(&at_heavy) - gradient(&at_light);
    }
    let rows = dataset.store.len().max(1) as f64;
    let variance = (&uncertainty.covariance * &slopes).dot(&slopes).max(0.0);
    Some(MassEffect {
        mean_w: difference / rows,
        std_err_w: variance.sqrt() / rows,
        masses_kg: [light, heavy],
    })
}

fn judge(dataset: &Dataset, model: &Model<f64>, weights: &[f64], noise: &Noise<f64>) -> Judgement {
    let lasting = |gradient: &(dyn Fn(&Kept<'_>) -> DVector<f64> + Sync), values: &[f64], covariance| {
        // What is at 0 is held there by its bound.
        let free = |row: &Kept<'_>| {
            let slopes = gradient(row);
            DVector::from_fn(values.len(), |i, _| if values[i] == 0.0 { 0.0 } else { slopes[i] })
        };
        let (unseen, of_parameters) = rayon::join(
            || unseen::lasting_errors(dataset, model, weights, free, noise),
            || assess::lasting_error(dataset, model, gradient, covariance, noise),
        );
        unseen::Lasting { mass_w: of_parameters.max(unseen.mass_w), ..unseen }
    };
    match model {
        Model::Signed { torque, drive } => {
            let all = physical::parameters(torque);
            let places = dataset.free_terms.places(dataset.robot.scrubs());
            let values: Vec<f64> = places.iter().map(|&place| all[place]).collect();
            let described = |&place: &usize| *verdict::of_torque(place);
            let descriptions: Vec<verdict::Description> = places.iter().map(described).collect();
            let predict = |row: &Kept<'_>| row.predicted(model).unwrap_or(f64::NAN);
            let gradient = |row: &Kept<'_>| {
                let slope = physical::gradient(torque, row, *drive);
                DVector::from_fn(places.len(), |i, _| slope[places[i]])
            };
            let uncertainty = assess::uncertainty(dataset, weights, predict, gradient, values.len());
            let lasting = lasting(&gradient, &values, &uncertainty.covariance);
            let parameters = verdict::judge(&descriptions, &values, &uncertainty);
            let mass_effect = mass_effect(dataset, predict, gradient, &uncertainty);
            let unseen::Lasting { mass_w: lasting_error, energy_w: energy_std_w } = lasting;
            Judgement { uncertainty, parameters, lasting_error, energy_std_w, mass_effect }
        }
        Model::Eq18 { gate, beta } => {
            let gradient = |row: &Kept<'_>| {
                DVector::from_column_slice(&eq18::regressors(*gate, &row.products(*gate), row.mass))
            };
            let predict = |row: &Kept<'_>| gradient(row).iter().zip(beta).map(|(x, b)| x * b).sum();
            let uncertainty = assess::uncertainty(dataset, weights, predict, gradient, beta.len());
            let lasting = lasting(&gradient, beta, &uncertainty.covariance);
            let parameters = verdict::judge(&verdict::EQ18, beta, &uncertainty);
            let mass_effect = mass_effect(dataset, predict, gradient, &uncertainty);
            let unseen::Lasting { mass_w: lasting_error, energy_w: energy_std_w } = lasting;
            Judgement { uncertainty, parameters, lasting_error, energy_std_w, mass_effect }
        }
    }
}

/// Speeds closer than this share of the fastest are one and the same.
const SAME_SPEED: f64 = 0.02;

/// What keeps a model of these rows from telling payloads: they were recorded at one speed, or with
/// one payload.
///
/// # Errors
/// The robot never moved: there is nothing to fit.
fn shortcoming(dataset: &Dataset) -> Result<Option<String>> {
    let speeds = || dataset.store.iter().flat_map(|row| row.wheels).filter(|wheel| wheel.direction != 0.0);
    let file = &dataset.runs[0].file;
    let fastest = speeds().map(|wheel| wheel.speed.abs()).fold(0.0, f64::max);
    if fastest == 0.0 {
        return Err(Error::failed(format!(
            "the robot never moves (no wheel above the dead band of {} rad/s); expected a drive at several speeds",
            dataset.robot.dead_band()
        ))
        .in_file(file)
        .in_column(logs::speed_column(0)));
    }
    let slowest = speeds().map(|wheel| wheel.speed.abs()).fold(f64::INFINITY, f64::min);
    if fastest - slowest <= SAME_SPEED * fastest {
        return Ok(Some(format!(
            "{}:{}: constant speed only ({slowest:.3} to {fastest:.3} rad/s): friction, inertia and losses cannot be told \
             apart, so payload estimates with these coefficients will be unknown; drive at several speeds, and accelerate",
            file.display(),
            logs::speed_column(0)
        )));
    }
    if let [mass] = dataset.masses[..] {
        return Ok(Some(format!(
            "{}: one payload only ({mass} kg): what depends on the mass cannot be told from what does not, so payload \
             estimates with these coefficients will be unknown; add a run with another payload",
            file.display()
        )));
    }
    Ok(None)
}
