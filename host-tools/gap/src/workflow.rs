//! `gmr gap`: from files to the report, with all that is written beside it.

use std::path::{Path, PathBuf};

use answers::export::joints::Language;
use answers::inspect;
use fit::dataset::Reading;
use fit::physical;
use logs::checks;
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::runs::{Rows, Runs};
use logs::speed_column;
use model::coefficients::{CoefficientsFile, InvalidCoefficients, Taking};
use model::effects::{NotTestable, written};
use model_core::eq18::Gate;
use model_core::model::Model;
use plant::PlantSet;
use serde_json::Value;
use support::context::Context;
use support::error::{Error, Result};
use support::output::{check_apart, write_content};
use support::overwrite::{self, Form};
use support::progress::StageProgress;

use crate::driven_plant::Simulated;
use crate::manoeuvre::{Suggestion, Wish};
use crate::report::json::Beside;
use crate::report::{Report, json, page};
use crate::simulator::export::Changes;
use crate::simulator::{Simulator, Source, Told};
use crate::{driven_plant, extension, manoeuvre, power_only, refit, weighed};
use residuals::thresholds::calibrate::LEAST_RUNS;
use residuals::types::{Base, Options, Verdict};
use residuals::user::{self, UserCandidates};

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot, which knows in which units its logs are.
    pub robot: &'a Robot,
    /// Where it was read.
    pub robot_file: &'a Path,
    /// The logs in question.
    pub logs: &'a [PathBuf],
    /// Coefficients of an earlier clean fit.
    pub coeffs: Option<&'a Path>,
    /// The clean logs, where they are not those that the coefficients name.
    pub base: &'a [PathBuf],
    /// Logs of a simulator in the place of a clean fit.
    pub sim: &'a [PathBuf],
    /// Language and file for the changes that a simulator's model needs.
    pub export: Option<(Language, &'a Path)>,
    /// Total mass of logs without one, kg.
    pub mass_kg: f64,
    /// Effects of the user's own.
    pub effects: Option<&'a Path>,
    /// Where the page is written.
    pub report: Option<&'a Path>,
    /// Where the coefficients with the named effects go.
    pub out: Option<&'a Path>,
    /// Motors of a simulated robot that is driven along.
    pub plant: Option<PlantSet>,
    /// Where the drive that distinguishes the rivals of a tie is written.
    pub profile: &'a Path,
    /// What that drive is asked to be.
    pub wish: Wish,
    /// Whether other files are written over, and unusable coefficients are accepted.
    pub force: bool,
    /// How often a gap without a name may be reported of runs that have none, by relabelled runs.
    pub level: f64,
}

/// The answer.
pub struct Answer {
    /// The verdict, and what led to it.
    pub report: Report,
    /// The simulation's side.
    pub simulated: Option<Simulated>,
    /// Somebody's own simulator.
    pub simulator: Option<Told>,
    /// What its model of the robot needs.
    pub changes: Option<Changes>,
    /// What to drive where there is a tie.
    pub suggestion: Option<Suggestion>,
}

impl Answer {
    fn of(report: Report) -> Self {
        Self { report, simulated: None, simulator: None, changes: None, suggestion: None }
    }

    /// What is suggested, where it is a drive.
    fn drive(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref().filter(|suggestion| suggestion.knots.is_some())
    }

    /// For scripts; a drive was written to `profile`.
    pub fn json(&self, profile: &Path) -> Value {
        let profile = self.drive().map(|_| profile.display().to_string());
        let beside = Beside {
            simulated: self.simulated.as_ref(),
            simulator: self.simulator.as_ref(),
            changes: self.changes.as_ref(),
            suggestion: self.suggestion.as_ref(),
            profile: profile.as_deref(),
        };
        json::json(&self.report, beside)
    }
}

/// Analyses what the model lacks, and writes the files requested.
///
/// # Errors
/// A file that cannot be read, is not of this robot or would be written over; too few runs; data
/// that determine no model.
pub fn gap(context: &Context, request: &Request<'_>) -> Result<Answer> {
    if let Some(file) = request.report {
        page::check(file)?;
    }
    if power_only::is_power_only(context, request.logs)? {
        return Ok(Answer::of(of_power_only(context, request)?));
    }
    answer(context, request)
}

/// Of logs of power only.
fn of_power_only(context: &Context, request: &Request<'_>) -> Result<Report> {
    let given = [
        (request.coeffs.is_some(), "--coeffs"),
        (!request.base.is_empty(), "--base"),
        (request.report.is_some(), "--report"),
        (request.plant.is_some(), "--plant"),
        (!request.sim.is_empty(), "--sim"),
        (request.export.is_some(), "--export"),
    ];
    for (given, flag) in given {
        if given {
            return Err(Error::usage(format!(
                "{flag} with logs without wheel speeds: nothing can be predicted; expected logs with {}, or no {flag}",
                speed_column(0)
            )));
        }
    }
    check_outputs(request, &[])?;
    checks::each_once(request.logs, &[])?;
    let unit_w = request.robot.log_units().power_in_w();
    let mut report = power_only::investigate(&power_only::read(context, request.logs, unit_w)?)?;
    if let Some(file) = request.effects {
        let effects = user::read(file)?.into_iter();
        let needs = || format!("needs {}", speed_column(0));
        report.not_testable.extend(effects.map(|effect| NotTestable { id: effect.id, reason: needs() }));
    }
    Ok(report)
}

/// Refuses to write over what is read, the clean logs that the coefficients name included.
fn check_outputs(request: &Request<'_>, clean_logs: &[PathBuf]) -> Result<()> {
    let Request { out, report, profile, robot_file, logs, coeffs, effects, force, .. } = *request;
    let export = request.export.map(|(_, file)| file);
    let outputs = out.into_iter().chain(report).chain([profile]).chain(export);
    let logs = logs.iter().chain(clean_logs).map(PathBuf::as_path);
    let inputs = logs.chain(coeffs).chain(effects).chain([robot_file]);
    check_apart(outputs, inputs)?;
    let written = [
        (out, Form::Coefficients),
        (report, Form::Page),
        (export, Form::Exported),
        (Some(profile), Form::Profile),
    ];
    let mut files = written.into_iter().filter_map(|(file, form)| Some((file?, form)));
    files.try_for_each(|(file, form)| overwrite::check(file, form, force))
}

fn answer(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { robot, logs, coeffs, sim, mass_kg: mass, effects, .. } = *request;
    checks::check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    let user_effects = effects.map_or(Ok(Vec::new()), user::read)?;
    // Before the long work, and before the clean logs are checked for changes.
    let taking = Taking { true_slip: true, not_usable: request.force.then_some(context) };
    let read = |file| Ok((file, CoefficientsFile::read_taking(file, robot, taking)?));
    let fitted: Option<(&Path, _)> = coeffs.map(read).transpose()?;
    let weighed = fitted.as_ref().map(|(_, fitted)| fitted.with_weighed(robot)).transpose()?;
    let robot = weighed.as_ref().unwrap_or(robot);
    if let (Some(_), Some((file, fitted))) = (request.plant, &fitted)
        && fitted.coefficients.robot.conditioning().true_slip != 0.0
    {
        // The simulated robot has no gyro.
        return Err(Error::of(InvalidCoefficients::TrueSlip).in_file(file).in_column("true_slip_s_rad"));
    }
    let clean_logs = match (request.base, &fitted) {
        ([], Some((file, fitted))) => fitted.logs_still_there(context, file)?,
        (given, _) => given.to_vec(),
    };
    let simulator = match (sim, &fitted) {
        ([], Some(_)) => None,
        ([], None) => Source::beside(context, logs, robot)?,
        (logs, _) => Some(Source::of_logs(context, logs, robot)?),
    };
    let clean_and_sim = [&clean_logs[..], sim].concat();
    check_outputs(request, &clean_and_sim)?;
    checks::each_once(logs, &clean_and_sim)?;
    let named: Vec<String> =
        user_effects.iter().flat_map(|effect| effect.formula.variables()).cloned().collect();
    let simulator =
        simulator.map(|source| Simulator::read(context, robot, source, logs, mass, &named)).transpose()?;
    let (chassis, base) = match (&simulator, &fitted) {
        (Some(simulator), _) => (simulator.chassis.clone(), simulator.base.clone()),
        (None, Some((file, fitted))) => fitted_base(file, fitted)?,
        (None, None) => field_base(context, robot, logs, mass)?,
    };
    let raw = Runs::raw(context, robot, logs, mass, &named)?;
    let raw_clean = match (&simulator, &clean_logs[..]) {
        (Some(simulator), _) => Some(simulator.raw.clone()),
        (None, []) => None,
        (None, files) => Some(Runs::raw(context, robot, files, mass, &named)?),
    };
    // The base is one of filtered speeds; without clean runs nothing makes it one of others.
    let rows = if raw_clean.is_some() { Rows::Before } else { Rows::Behind };
    let mut runs = Runs::condition_to(&chassis, raw.clone(), rows)?;
    let mut clean = raw_clean.clone().map(|raw| runs.condition_alike(&chassis, raw)).transpose()?;
    if let (Some(simulator), Some(clean)) = (&simulator, &clean) {
        simulator.check_rate(&runs, clean)?;
    }
    say_what_is_missing(context, clean.as_ref().map(|clean| clean.runs.len()), coeffs.is_some());
    let measured = if simulator.is_some() { logs.to_vec() } else { [logs, &clean_logs[..]].concat() };
    inspect::check(context, robot, &measured, request.force)?;
    checks::say_where_none_moves(context, &runs);
    let mut options = Options::default();
    if let Some(file) = effects {
        options.user = UserCandidates::add(&user_effects, file, &mut runs, clean.as_mut())?;
        for NotTestable { id, reason } in &options.user.not_testable {
            context.notice(format_args!("{}: {id}: not testable: {reason}", file.display()));
        }
    }
    let progress = StageProgress::new(context, "looking for what the model lacks");
    let report = weighed::investigate(&runs, clean.as_ref(), &base, &options, request.level)?;
    let report = match (&simulator, &fitted) {
        (None, Some(_)) => {
            let refit = refit::asked_for(context, robot, &runs.robot, &base, &clean_logs, mass, &report)?;
            report.withheld(refit)
        }
        _ => report,
    };
    let simulated = match request.plant {
        Some(plant) => {
            progress.at("driving the simulated robot");
            Some(driven_plant::simulate(plant, robot, &chassis, &raw, raw_clean.as_deref(), &report)?)
        }
        None => None,
    };
    if report.verdict == Verdict::Ambiguous {
        progress.at("looking for a drive that parts the rivals");
    }
    let suggestion = manoeuvre::suggest(robot, &runs, clean.as_ref(), &report, &request.wish)?;
    if let Some(file) = request.report {
        progress.at("drawing");
        let threshold = if clean.is_some() { options.threshold } else { options.threshold_alone };
        let inputs = page::Inputs {
            robot: robot.name().to_owned(),
            coefficients: coeffs.map(Path::to_owned),
            logs: logs.to_vec(),
            clean: clean_and_sim,
            options: vec![
                ("mass of logs without one".to_owned(), format!("{mass} kg")),
                ("filter".to_owned(), format!("{} Hz", chassis.cutoff_hz())),
                ("threshold of structure".to_owned(), threshold.to_string()),
                ("most effects".to_owned(), options.most_effects.to_string()),
            ],
        };
        page::save(
            file,
            &report,
            &page::Picture::of(&runs, &report),
            &inputs,
            simulated.as_ref().map(Simulated::picture).as_ref(),
        )?;
    }
    if let (Some(out), Some((_, base))) = (request.out, &fitted) {
        // A board asks its model of filtered speeds.
        let mut as_on_board = Runs::condition(&chassis, raw)?;
        if let Some(file) = effects {
            UserCandidates::add(&user_effects, file, &mut as_on_board, None)?;
        }
        extension::write(context, &as_on_board, &report, base, out)?;
    }
    drop(progress);
    let simulator =
        simulator.zip(clean.as_ref()).map(|(simulator, clean)| simulator.told(&runs, clean, &report));
    let changes = |(language, file): (Language, &Path)| {
        let changes = Changes::of(&report, robot, mean_mass(&runs), language);
        write_content(file, changes.text(robot)).map(|()| changes)
    };
    let changes = request.export.map(changes).transpose()?;
    let asked = [("--part", request.wish.probability.is_some()), ("--room", request.wish.room.is_some())];
    for (flag, _) in asked.iter().filter(|(_, given)| *given && suggestion.is_none()) {
        context.notice(format_args!(
            "{flag} is not used: it plans a drive that parts the rivals of a tie, and this is none"
        ));
    }
    let answer = Answer { report, simulated, simulator, changes, suggestion };
    answer.drive().map_or(Ok(()), |suggestion| suggestion.write(request.profile))?;
    Ok(answer)
}

/// Notices of the clean runs: that there are none though coefficients are given, or too few.
fn say_what_is_missing(context: &Context, clean_runs: Option<usize>, has_coefficients: bool) {
    match clean_runs {
        None if has_coefficients => context.notice(
            "the clean runs of these coefficients are not there: what the model gets wrong without any effect is not \
             known, so only large effects are named; give the runs with --base",
        ),
        Some(count) if count < LEAST_RUNS => context.notice(format_args!(
            "{count} clean run{}: how much clean runs differ is not known, so small effects may be named that are none; record {} more, \
             and fit them all",
            if count == 1 { "" } else { "s" },
            LEAST_RUNS - count
        )),
        _ => {}
    }
}

/// The base of coefficients as `gmr fit` wrote them.
fn fitted_base(file: &Path, fitted: &CoefficientsFile) -> Result<(Chassis, Base)> {
    let read = &fitted.coefficients;
    let Model::Signed { torque, drive } = read.model else {
        return Err(Error::failed("model eq18; expected signed: effects act on its torques")
            .in_file(file)
            .in_column("model"));
    };
    if let Some(effect) = read.columns.iter().next() {
        let message = format!(
            "they hold the effect {} already; expected the coefficients as gmr fit wrote them, from which all effects are looked for \
             together",
            written::id_of(&effect.cause).0
        );
        return Err(Error::failed(message).in_file(file).in_column("effects"));
    }
    let covariance = Some(fitted.covariance.clone());
    let masses_kg = fitted.origin.masses_kg.clone();
    Ok((read.robot.clone(), Base { torque, covariance, drive, masses_kg, of_simulator: false }))
}

/// A base fitted to the field runs themselves.
fn field_base(context: &Context, robot: &Robot, logs: &[PathBuf], mass_kg: f64) -> Result<(Chassis, Base)> {
    let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg };
    let dataset = fit::read(context, robot, logs, &reading)?;
    let torque = physical::solve(&dataset, robot).torque;
    let masses_kg = dataset.masses;
    let base = Base { torque, covariance: None, drive: robot.drive(), masses_kg, of_simulator: false };
    Ok((dataset.robot, base))
}

/// Mean total mass of the rows, kg.
fn mean_mass(runs: &Runs) -> f64 {
    let masses = || runs.runs.iter().flat_map(|run| run.rows.iter().map(|row| row.mass));
    masses().sum::<f64>() / masses().count().max(1) as f64
}
