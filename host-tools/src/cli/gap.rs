//! `gmr gap`: where model and measurement disagree, and which effect is missing.

use std::path::{Path, PathBuf};

use answers::export::joints::Language;
use fit::dataset::Reading;
use fit::physical;
use gap::investigate::investigate;
use gap::manoeuvre::room::Room;
use gap::manoeuvre::{Suggestion, Wish};
use gap::power_only;
use gap::report::Report;
use gap::report::json::Beside;
use gap::report::{json as output, page, summary};
use gap::simulation::Simulated;
use gap::simulator::export::Changes;
use gap::simulator::{Simulator, Source, Told};
use gap::types::{Base, Options, Verdict};
use gap::user::{self, UserCandidates};
use gap::{extension, manoeuvre, refit, simulation};
use logs::checks;
use logs::robot::{FOUND, Robot};
use logs::runs::Runs;
use logs::speed_column;
use logs::with_wheels;
use model::coefficients::{CoefficientsFile, InvalidCoefficients, Taking};
use model::effects::{NotTestable, written};
use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::Gate;
use model_core::model::Model;
use plant::PlantSet;
use support::context::Context;
use support::error::{Error, Result};
use support::output::{check_apart, write_content};
use support::own::Form;
use support::progress::StageProgress;

use super::overwrite::OverwriteArgument;
use super::units::UnitArguments;
use super::weighed::{Log, paths};
use gap::thresholds::calibrate::LEAST_RUNS;

/// Arguments of `gmr gap`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr gap --robot robot.toml --coeffs coefficients.toml --report gap.html --out extended.toml monday/*.csv", after_long_help = format!("{}\n\n{}", "Example:\n  gmr gap --robot robot.toml --coeffs coefficients.toml --report gap.html --out extended.toml monday/*.csv", output::KEYS))]
pub(crate) struct Arguments {
    /// Logs: four runs at least, one or several a file; the total mass behind the name where they do not hold it
    #[arg(required = true, value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients of an earlier clean fit: what is new since then? Without, base and effects are fitted together
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// The clean runs that the coefficients were fitted to, if they are no longer where they were: what the model gets wrong
    /// there as well is no effect
    #[arg(long, value_name = "LOG[=KG]", num_args = 1..)]
    base: Vec<Log>,
    /// Logs of your simulator in place of a clean fit: what does the robot have that it lacks? Columns as in a measured log, the power in
    /// power_w or sim_power_w, or the wheels' torques in sim_torque1_nm and so on. Without this, measured logs that have such sim_
    /// columns are held against them, row by row
    #[arg(long, value_name = "SIM.csv", num_args = 1.., conflicts_with_all = ["coeffs", "base", "plant"])]
    sim: Vec<Log>,
    /// Write what the simulator's model of the robot needs for what is named: elements, sizes, intervals
    #[arg(long, value_enum)]
    export: Option<Language>,
    /// Where that is written [default: gap_changes.xml, or .sdf]
    #[arg(long, value_name = "FILE", requires = "export")]
    export_file: Option<PathBuf>,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Effects of your own beside those of the dictionary, as formulas over the logs' columns: [[effect]] entries with id, formula,
    /// unit, sign, range = [least, greatest] and meaning
    #[arg(long, value_name = "MINE.toml")]
    effects: Option<PathBuf>,
    /// Everything that was found, with plots, as one HTML page that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the coefficients with the named effects, for gmr estimate, gmr flash and the board
    #[arg(long, value_name = "FILE.toml", requires = "coeffs")]
    out: Option<PathBuf>,
    /// Drive a simulated robot with these motors along the recorded wheel speeds as well: calibrated on the clean runs, without the
    /// named effects and with them
    #[arg(long, value_enum)]
    plant: Option<PlantSet>,
    /// Where the speed profile that parts the rivals of a tie is written
    #[arg(long, value_name = "FILE", default_value = "gap_profile.csv")]
    profile: PathBuf,
    /// On a tie: a drive that parts the rivals with this probability (0.5 to 0.99), and how long that takes
    #[arg(long, value_name = "PROBABILITY", value_parser = probability)]
    part: Option<f64>,
    /// On a tie: a drive that stays in a room of this length and width, m
    #[arg(long, value_name = "LENGTHxWIDTH", value_parser = room)]
    room: Option<Room>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let given = arguments.runs.iter().chain(&arguments.base).chain(&arguments.sim);
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, given)?;
    if let Some(file) = &arguments.report {
        page::check(file)?;
    }
    let found = if power_only::is_power_only(context, &paths(&arguments.runs))? {
        Found {
            report: run_power_only(context, arguments, robot.log_units().power_in_w())?,
            simulated: None,
            simulator: None,
            changes: None,
            suggestion: None,
        }
    } else {
        with_wheels!(robot, run_with(context, robot, arguments))?
    };
    show(&found, arguments)
}

/// Logs that do not say how the robot moved.
fn run_power_only(context: &Context, arguments: &Arguments, unit_w: f64) -> Result<Report> {
    let given = [
        (arguments.coeffs.is_some(), "--coeffs"),
        (!arguments.base.is_empty(), "--base"),
        (arguments.report.is_some(), "--report"),
        (arguments.plant.is_some(), "--plant"),
        (!arguments.sim.is_empty(), "--sim"),
        (arguments.export.is_some(), "--export"),
    ];
    for (given, flag) in given {
        if given {
            return Err(Error::usage(format!(
                "{flag} with logs without wheel speeds: nothing can be predicted; expected logs with {}, or no {flag}",
                speed_column(0)
            )));
        }
    }
    check_outputs(arguments, &[])?;
    let logs = paths(&arguments.runs);
    checks::each_once(&logs, &[])?;
    let mut report = power_only::investigate(&power_only::read(context, &logs, unit_w)?)?;
    if let Some(file) = &arguments.effects {
        let own = user::read(file)?.into_iter();
        let needs = || format!("needs {}", speed_column(0));
        report.not_testable.extend(own.map(|effect| NotTestable { id: effect.id, reason: needs() }));
    }
    Ok(report)
}

/// Refuses to write over what is read, the clean logs that the coefficients name included.
fn check_outputs(arguments: &Arguments, clean_logs: &[PathBuf]) -> Result<()> {
    let export = arguments.export_file();
    let outputs = arguments.out.iter().chain(&arguments.report).chain([&arguments.profile]).chain(&export);
    let runs = paths(&arguments.runs);
    let inputs = runs.iter().chain(&arguments.coeffs).chain(&arguments.effects);
    let inputs = inputs.chain(clean_logs).chain([&arguments.robot]);
    check_apart(outputs.map(PathBuf::as_path), inputs.map(PathBuf::as_path))?;
    arguments.overwrite.check(&arguments.out, Form::Coefficients)?;
    arguments.overwrite.check(&arguments.report, Form::Page)?;
    arguments.overwrite.check(&export, Form::Exported)?;
    arguments.overwrite.check([&arguments.profile], Form::Profile)
}

/// All that is shown.
struct Found {
    report: Report,
    simulated: Option<Simulated>,
    simulator: Option<Told>,
    changes: Option<Changes>,
    suggestion: Option<Suggestion>,
}

/// A probability that somebody may ask for.
fn probability(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number from 0.5 to 0.99")?;
    if (0.5..=0.99).contains(&value) { Ok(value) } else { Err("expected 0.5 to 0.99".to_owned()) }
}

/// `4x3`: a room's sides, m.
fn room(text: &str) -> std::result::Result<Room, String> {
    let expected = || "expected length x width in m, each from 0.1 to 1000, as 4x3".to_owned();
    let (length, width) = text.split_once('x').ok_or_else(expected)?;
    let side = |text: &str| text.trim().parse().ok().filter(|side: &f64| (0.1..=1000.0).contains(side));
    let (length_m, width_m) = side(length).zip(side(width)).ok_or_else(expected)?;
    Ok(Room { length_m, width_m })
}

impl Arguments {
    /// What a drive that parts rivals is asked to be.
    fn wish(&self) -> Wish {
        Wish { probability: self.part, room: self.room }
    }

    /// Where what a simulator's model needs is written.
    fn export_file(&self) -> Option<PathBuf> {
        let language = self.export?;
        let default = match language {
            Language::Mjcf => "gap_changes.xml",
            Language::Sdf => "gap_changes.sdf",
        };
        Some(self.export_file.clone().unwrap_or_else(|| PathBuf::from(default)))
    }
}

impl Found {
    /// What is suggested, where it is a drive.
    fn drive(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref().filter(|suggestion| suggestion.knots.is_some())
    }
}

fn show(found: &Found, arguments: &Arguments) -> Result<()> {
    if arguments.json {
        let profile = found.drive().map(|_| arguments.profile.display().to_string());
        let beside = Beside {
            simulated: found.simulated.as_ref(),
            simulator: found.simulator.as_ref(),
            changes: found.changes.as_ref(),
            suggestion: found.suggestion.as_ref(),
            profile: profile.as_deref(),
        };
        return support::output::print_json(&output::json(&found.report, beside));
    }
    println!("{}", summary::text(&found.report).trim_end());
    if let Some(simulated) = &found.simulated {
        println!("{}", simulated.line());
    }
    if let Some(told) = &found.simulator {
        println!("{}", told.line());
    }
    if let Some(file) = arguments.export_file() {
        println!("What its model needs: {}", file.display());
    }
    if let Some(suggestion) = &found.suggestion {
        println!("{}", suggestion.lines(&arguments.profile).trim_end());
    }
    Ok(())
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<Found> {
    let (logs, sim) = (paths(&arguments.runs), paths(&arguments.sim));
    let mass = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    checks::check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    let own = match &arguments.effects {
        Some(file) => user::read(file)?,
        None => Vec::new(),
    };
    // Before the long work, and before the clean logs are asked whether they have changed.
    let fitted = match &arguments.coeffs {
        Some(file) => {
            let taking = Taking { true_slip: true, not_usable: arguments.overwrite.force.then_some(context) };
            Some((file, CoefficientsFile::<N>::read_taking(file, robot, taking)?))
        }
        None => None,
    };
    let weighed = fitted.as_ref().map(|(_, fitted)| fitted.with_weighed(robot)).transpose()?;
    let robot = weighed.as_ref().unwrap_or(robot);
    if let (Some(_), Some((file, fitted))) = (&arguments.plant, &fitted)
        && fitted.coefficients.robot.conditioning.true_slip != 0.0
    {
        // The simulated robot has no gyro.
        return Err(Error::of(InvalidCoefficients::TrueSlip).in_file(file).in_column("true_slip_s_rad"));
    }
    let clean_logs = match (&arguments.base[..], &fitted) {
        ([], Some((file, fitted))) => fitted.logs_still_there(context, file)?,
        (given, _) => paths(given),
    };
    let simulator = match (&sim[..], &fitted) {
        ([], Some(_)) => None,
        ([], None) => Source::beside(context, &logs, robot)?,
        (logs, _) => Some(Source::of_logs(context, logs, robot)?),
    };
    check_outputs(arguments, &[&clean_logs[..], &sim].concat())?;
    checks::each_once(&logs, &[&clean_logs[..], &sim].concat())?;
    let named: Vec<String> = own.iter().flat_map(|effect| effect.formula.variables()).cloned().collect();
    let simulator = simulator
        .map(|source| Simulator::<N>::read(context, robot, source, &logs, mass, &named))
        .transpose()?;
    let (core, base) = match (&simulator, &fitted) {
        (Some(simulator), _) => (simulator.core, simulator.base.clone()),
        (None, Some((file, fitted))) => fitted_base(file, fitted)?,
        (None, None) => own_base(context, robot, arguments, mass)?,
    };
    let raw = Runs::<N>::raw(context, robot, &logs, mass, &named)?;
    let mut runs = Runs::condition(&core, raw.clone())?;
    let raw_clean = match (&simulator, &clean_logs[..]) {
        (Some(simulator), _) => Some(simulator.raw.clone()),
        (None, []) => None,
        (None, files) => Some(Runs::<N>::raw(context, robot, files, mass, &named)?),
    };
    let mut clean = raw_clean.clone().map(|raw| Runs::condition(&core, raw)).transpose()?;
    if let (Some(simulator), Some(clean)) = (&simulator, &clean) {
        simulator.check_rate(&runs, clean)?;
    }
    if clean.is_none() && arguments.coeffs.is_some() {
        context.notice(
            "the clean runs of these coefficients are not there: what the model gets wrong without any effect is not \
             known, so only large effects are named; give the runs with --base",
        );
    }
    if let Some(count) = clean.as_ref().map(|clean| clean.runs.len()).filter(|count| *count < LEAST_RUNS) {
        context.notice(format_args!(
            "{count} clean run{}: how much clean runs differ is not known, so small effects may be named that are none; record {} more, \
             and fit them all",
            if count == 1 { "" } else { "s" },
            LEAST_RUNS - count
        ));
    }
    checks::check_power(context, &runs)?;
    clean.as_ref().map_or(Ok(()), |clean| checks::check_power(context, clean))?;
    let mut options = Options::default();
    if let Some(file) = &arguments.effects {
        options.user = UserCandidates::add(&own, file, &mut runs, clean.as_mut())?;
        for effect in &options.user.not_testable {
            context.notice(format_args!(
                "{}: {}: not testable: {}",
                file.display(),
                effect.id,
                effect.reason
            ));
        }
    }
    let progress = StageProgress::new(context, "looking for what the model lacks");
    let report = investigate(&runs, clean.as_ref(), &base, &options)?;
    let report = match (&simulator, &fitted) {
        (None, Some(_)) => {
            let refit = refit::asked_for(context, robot, &core, &base, &clean_logs, mass, &report)?;
            report.withheld(refit)
        }
        _ => report,
    };
    let simulated = match arguments.plant {
        Some(plant) => {
            progress.at("driving the simulated robot");
            Some(simulation::simulate(plant, robot, &core, &raw, raw_clean.as_deref(), &report)?)
        }
        None => None,
    };
    if report.verdict == Verdict::Ambiguous {
        progress.at("looking for a drive that parts the rivals");
    }
    let suggestion = manoeuvre::suggest(robot, &runs, clean.as_ref(), &report, &arguments.wish())?;
    if let Some(file) = &arguments.report {
        progress.at("drawing");
        let threshold = if clean.is_some() { options.threshold } else { options.threshold_alone };
        let inputs = page::Inputs {
            robot: robot.name().to_owned(),
            coefficients: arguments.coeffs.clone(),
            logs: logs.clone(),
            clean: [clean_logs, sim.clone()].concat(),
            options: vec![
                ("mass of logs without one".to_owned(), format!("{mass} kg")),
                ("filter".to_owned(), format!("{} Hz", core.cutoff_hz)),
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
    if let (Some(out), Some((_, base))) = (&arguments.out, &fitted) {
        extension::write(context, &runs, &report, base, out)?;
    }
    drop(progress);
    let simulator = simulator.zip(clean.as_ref()).map(|(own, clean)| own.told(&runs, clean, &report));
    let changes = arguments.export.map(|language| Changes::of(&report, robot, mean_mass(&runs), language));
    if let (Some(file), Some(changes)) = (arguments.export_file(), &changes) {
        write_content(&file, changes.text(robot))?;
    }
    let asked = [("--part", arguments.part.is_some()), ("--room", arguments.room.is_some())];
    for (flag, _) in asked.iter().filter(|(_, given)| *given && suggestion.is_none()) {
        context.notice(format_args!(
            "{flag} is not used: it plans a drive that parts the rivals of a tie, and this is none"
        ));
    }
    let found = Found { report, simulated, simulator, changes, suggestion };
    if let Some(suggestion) = found.drive() {
        suggestion.write(&arguments.profile)?;
    }
    Ok(found)
}

/// The base of coefficients as `gmr fit` wrote them.
fn fitted_base<const N: usize>(
    file: &Path,
    fitted: &CoefficientsFile<N>,
) -> Result<(CoreRobot<f64, N>, Base)> {
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
    Ok((read.robot, Base { torque, covariance, drive, masses_kg, of_simulator: false }))
}

/// A base fitted to the very runs in question.
fn own_base<const N: usize>(
    context: &Context,
    robot: &Robot,
    arguments: &Arguments,
    mass_kg: f64,
) -> Result<(CoreRobot<f64, N>, Base)> {
    let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg };
    let dataset = fit::read::<N>(context, robot, &paths(&arguments.runs), &reading)?;
    let torque = physical::solve(&dataset, robot).torque;
    let masses_kg = dataset.masses;
    let base = Base { torque, covariance: None, drive: robot.drive(), masses_kg, of_simulator: false };
    Ok((dataset.robot, base))
}

/// Mean total mass of the rows, kg.
fn mean_mass<const N: usize>(runs: &Runs<N>) -> f64 {
    let masses = || runs.runs.iter().flat_map(|run| run.rows.iter().map(|row| row.mass));
    masses().sum::<f64>() / masses().count().max(1) as f64
}
