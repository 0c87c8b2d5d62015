//! `gmr fit`: logs to coefficients.

use std::path::PathBuf;

use board::flasher::{self, USUAL_RATE_HZ};
use firmware::control_table::Reason;
use firmware::items::check_coefficients;
use firmware::wheels::WHEELS;
use fit::entrance;
use fit::form::{Judged, TERMS, TERMS_WITH_GYRO, Term};
use fit::verdict::{Parameter, Verdict};
use fit::warning::Warning;
use fit::{Fit, linear::Certificate, pgd, physical::Restarts};
use logs::robot::{FOUND, Robot};
use logs::with_wheels;
use model::coefficients::{Method, ModelKind};
use model_core::coefficients::Coefficients;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::Quality;
use support::output::check_apart;
use support::own::Form;

use super::fit_grams;
use super::overwrite::OverwriteArgument;
use super::units::UnitArguments;
use super::weighed::{Log, paths};
use answers::inspect::{self, Severity};
use fit::usable::Defect;
use gap::words::quantity;
use logs::checks;
use support::figure::figure;

/// Arguments of `gmr fit`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr fit --robot robot.toml --out coefficients.toml empty.mcap=1.0 full.mcap=6.0\n  gmr fit --robot husky --mass 75 --json floor_*.csv"
)]
pub(crate) struct Arguments {
    /// Logs of drives with known payload: two of them, empty and fully loaded, at least. Where a log does not hold the robot's total mass
    /// (mass_kg), write it behind the name: empty.mcap=1.0 full.mcap=6.0
    #[arg(required_unless_present = "grams", value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// Sums of gmr gram instead of logs: Eq. 18 as from the rows, the signed model from those that its clamp leaves alone. Without what
    /// needs rows: errors in percent, delay and slip memory, robust weights, and --out but with --coeffs
    #[arg(long, value_name = "GRAMS.jsonl", num_args = 1.., conflicts_with_all = ["runs", "mass"])]
    grams: Vec<PathBuf>,
    /// With --grams: the coefficients that gmr gram --coeffs took the sums near. The next ones, a step of Gauss and Newton on, clamped wheels
    /// included; --out writes them
    #[arg(long, value_name = "C.toml", requires = "grams", conflicts_with_all = ["leave_one_out", "method"])]
    coeffs: Option<PathBuf>,
    /// With --grams: also how well each run is predicted by the others
    #[arg(long, requires = "grams")]
    leave_one_out: bool,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Where the coefficients go. A fit that cannot be used is not written but with --force, which marks it
    #[arg(long, value_name = "C.toml")]
    out: Option<PathBuf>,
    /// Which model
    #[arg(long, value_enum, default_value = "signed")]
    model: ModelKind,
    /// How to fit it [default: physical for signed, nnls for eq18, pgd for eq18-published]
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Leave a gyro's yaw_rate_rad_s alone: for boards, plans and whatever else has none
    #[arg(long)]
    no_gyro: bool,
    /// Learning rate α of pgd, on columns scaled to unit root mean square
    #[arg(long, default_value_t = 0.001)]
    learning_rate: f64,
    /// Momentum coefficient c of pgd
    #[arg(long, default_value_t = 0.9)]
    momentum: f64,
    /// Most iterations of pgd
    #[arg(long, default_value_t = pgd::Settings::default().most_iterations)]
    iterations: u64,
    /// Search again from so many random starts, and say how far below the fit's cost the best of them ends: of the signed model
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "grams")]
    starts: u32,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

#[derive(Serialize)]
struct Report<'a> {
    /// `usable`, `usable-for-power` (no payload can be found with it) or `not-usable`.
    verdict: &'static str,
    /// Why it cannot be used, and the one thing to do.
    why: Option<&'a str>,
    remedy: Option<&'a str>,
    robot: &'a str,
    model: ModelKind,
    method: Method,
    #[serde(flatten)]
    quality: Quality,
    rows: u64,
    masses_kg: &'a [f64],
    filter_cutoff_hz: f64,
    idle_share: f64,
    condition: Option<f64>,
    ending: &'a str,
    huber_threshold_std: Option<f64>,
    iterations: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    restarts: Option<Restarts>,
    fit_s: f64,
    pgd: Option<Certificate>,
    noise_density_w2_s: f64,
    prediction_std_w: f64,
    parameters: &'a [Parameter],
    /// s; 0 where the power is not late.
    power_delay_s: f64,
    half_slip: f64,
    slip_relaxation_rad: f64,
    true_slip_s_rad: f64,
    terms: &'a [Judged],
    warnings: &'a [Warning],
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    with_wheels!(robot, run_with(context, robot, arguments))
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    if !arguments.grams.is_empty() {
        let Arguments { grams, model, method, leave_one_out, json, .. } = arguments;
        if let Some(near) = &arguments.coeffs {
            let outputs = arguments.out.as_deref();
            check_apart(outputs, grams.iter().chain([near, &arguments.robot]).map(PathBuf::as_path))?;
            arguments.overwrite.check(&arguments.out, Form::Coefficients)?;
            return fit_grams::step::<N>(
                context,
                robot,
                grams,
                near,
                *model,
                arguments.out.as_deref(),
                *json,
            );
        }
        if arguments.out.is_some() {
            let message = "--out with --grams: expected --coeffs as well, the coefficients that gmr gram --coeffs took the sums near";
            return Err(Error::usage(message));
        }
        if let Some(method @ (Method::Pgd | Method::Physical)) = method
            && *model != ModelKind::Signed
        {
            let message = format!("--method {method:?} with --grams: expected nnls, the exact optimum");
            return Err(Error::usage(message.to_lowercase()));
        }
        return fit_grams::run::<N>(context, robot, grams, *model, *leave_one_out, *json);
    }
    let logs = paths(&arguments.runs);
    check_apart(arguments.out.as_deref(), logs.iter().chain([&arguments.robot]).map(PathBuf::as_path))?;
    checks::each_once(&logs, &[])?;
    arguments.overwrite.check(&arguments.out, Form::Coefficients)?;
    let method = arguments.method.unwrap_or(Method::default_for(arguments.model)).check(arguments.model)?;
    let mass = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    if !(mass > 0.0 && mass.is_finite()) {
        return Err(Error::usage(format!("--mass {mass}: expected a mass above 0 kg")));
    }
    if arguments.starts > 0 && arguments.model != ModelKind::Signed {
        return Err(Error::usage("--starts: expected model signed; the cost of the others has one minimum"));
    }
    let settings = settings(arguments)?;
    if arguments.mass.is_none() {
        entrance::check_masses(context, robot, &logs)?;
    }
    let mut suspicions = entrance::look::<N>(context, robot, &logs, mass)?;
    let doubted = suspicions.first().map(|suspicion| suspicion.text.clone());
    let terms: &[Term] = if arguments.no_gyro { &TERMS } else { &TERMS_WITH_GYRO };
    let request = fit::Request {
        files: &logs,
        mass_kg: mass,
        kind: arguments.model,
        terms,
        method,
        pgd: &settings,
        random_starts: arguments.starts,
    };
    let mut fit = fit::fit_logs::<N>(context, robot, &request)?;
    if let Some(defect) = fit.defect.take() {
        let defect = explained(context, robot, &logs, defect)?;
        if !arguments.overwrite.force {
            let Defect { why, remedy } = defect;
            return Err(Error::failed(format!("NOT USABLE ({why}): {remedy}. Nothing written")));
        }
        fit.defect = Some(defect);
    }
    // What the logs look like explains what the fit says of itself.
    suspicions.append(&mut fit.warnings);
    fit.warnings = suspicions;
    fit.shortcoming.iter().for_each(|shortcoming| context.notice(shortcoming));
    fit.warnings.iter().for_each(|warning| context.notice(&warning.text));
    if let Some(out) = &arguments.out {
        let mut file = fit.to_file()?;
        for log in &mut file.origin.logs {
            log.weighed_kg = robot.log_units().mass_of(&log.path);
        }
        check_for_boards(context, robot, &file.coefficients).map_err(|error| {
            // Absurd coefficients may come from a log that is in another unit.
            doubted.iter().fold(error.in_file(out), |error, text| error.after(text))
        })?;
        file.write(out)?;
    }
    if arguments.json { print_json(robot, &fit) } else { print_text(robot, &fit, arguments) }
}

/// A defect with the first problem of the logs as the reason for it: that one can be mended.
fn explained(context: &Context, robot: &Robot, logs: &[PathBuf], defect: Defect) -> Result<Defect> {
    for log in logs {
        let report = inspect::Report::of(context, log, robot, |_, _| {})?;
        if let Some(problem) = report.findings.iter().find(|found| found.severity == Severity::Problem) {
            let remedy = format!("{}: {}; {}", log.display(), problem.text, problem.advice);
            return Ok(Defect { remedy, ..defect });
        }
    }
    Ok(defect)
}

/// Coefficients that no board would take are not written. Whoever wants the figures of such a fit asks without `--out`.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct NotForBoards(String);

/// What is written, `gmr flash` takes: a file that no board would use would be found out too late.
fn check_for_boards<const N: usize>(
    context: &Context,
    robot: &Robot,
    coefficients: &Coefficients<f64, N>,
) -> Result<()> {
    // A robot that no board drives has nothing to ask one for.
    if N != WHEELS {
        return Ok(());
    }
    let refused = |why: &str| {
        let message = format!(
            "not written: no board would take these coefficients ({why}); drive at more speeds, turns and payloads, and look at the logs \
             with gmr inspect"
        );
        Error::of(NotForBoards(message))
    };
    let mut coefficients = *coefficients;
    // That a gyro is needed has been said; what else they hold can still be absurd.
    coefficients.robot.conditioning.true_slip = 0.0;
    let image = coefficients.encode().ok_or_else(|| refused("boards have no such model"))?;
    let identity = flasher::robot_identity(robot)?;
    match check_coefficients(image.as_bytes(), &identity, USUAL_RATE_HZ) {
        // How long a delay a board can keep, and how fast a filter, depends on its sample rate: another
        // may take them. Without a mass they still say what a drive takes.
        Err(reason @ (Reason::Delay | Reason::Cutoff | Reason::Slow | Reason::Mass)) => {
            context.notice(format_args!(
                "a board at {USUAL_RATE_HZ} Hz would not take these coefficients: {}",
                reason.text()
            ));
        }
        Err(reason) => return Err(refused(reason.text())),
        Ok(_) => {}
    }
    Ok(())
}

/// Of the parameters' information; none where it is singular.
fn condition_text(condition: f64) -> String {
    if condition.is_finite() {
        format!("condition {condition:.1e}")
    } else {
        "no condition, for these rows leave some parameter open".to_owned()
    }
}

fn settings(arguments: &Arguments) -> Result<pgd::Settings> {
    let positive = |name: &str, value: f64| {
        if value > 0.0 && value.is_finite() {
            Ok(value)
        } else {
            Err(Error::usage(format!("--{name} {value}: expected a number above 0")))
        }
    };
    if !(0.0..1.0).contains(&arguments.momentum) {
        return Err(Error::usage(format!("--momentum {}: expected 0 to below 1", arguments.momentum)));
    }
    Ok(pgd::Settings {
        learning_rate: pgd::Vector::repeat(positive("learning-rate", arguments.learning_rate)?),
        momentum: arguments.momentum,
        most_iterations: arguments.iterations,
        ..pgd::Settings::default()
    })
}

fn print_json<const N: usize>(robot: &Robot, fit: &Fit<N>) -> Result<()> {
    support::output::print_json(&Report {
        verdict: match (&fit.defect, &fit.shortcoming) {
            (Some(_), _) => "not-usable",
            (None, Some(_)) => "usable-for-power",
            (None, None) => "usable",
        },
        why: fit.defect.as_ref().map(|defect| defect.why.as_str()),
        remedy: fit.defect.as_ref().map(|defect| defect.remedy.as_str()),
        robot: robot.name(),
        model: fit.kind,
        method: fit.method,
        quality: fit.quality,
        rows: fit.rows,
        masses_kg: &fit.masses,
        filter_cutoff_hz: fit.coefficients.robot.cutoff_hz,
        idle_share: fit.idle_share,
        condition: fit.uncertainty.condition.is_finite().then_some(fit.uncertainty.condition),
        ending: &fit.ending,
        huber_threshold_std: fit.huber.map(|huber| huber.threshold_std),
        iterations: fit.iterations,
        restarts: fit.restarts,
        fit_s: fit.solve_s,
        pgd: fit.certificate,
        noise_density_w2_s: fit.coefficients.noise.density,
        prediction_std_w: fit.uncertainty.prediction_std_w,
        parameters: &fit.parameters,
        power_delay_s: fit.coefficients.robot.conditioning.delay,
        half_slip: fit.coefficients.robot.conditioning.slip.half_slip,
        slip_relaxation_rad: fit.coefficients.robot.conditioning.slip.relaxation,
        true_slip_s_rad: fit.coefficients.robot.conditioning.true_slip,
        terms: &fit.judged,
        warnings: &fit.warnings,
    })
}

/// The further terms that were taken, and what the others would have gained.
fn print_terms<const N: usize>(fit: &Fit<N>) {
    let conditioning = &fit.coefficients.robot.conditioning;
    for judged in &fit.judged {
        let what = match (judged.term, judged.taken) {
            (Term::Delay, true) => format!("power {:.3} s behind the speeds", conditioning.delay),
            (Term::SlipMemory, true) => {
                let slip = &conditioning.slip;
                format!(
                    "scrub builds up: half at a slip of {:.3}, over {:.2} rad",
                    slip.half_slip, slip.relaxation
                )
            }
            (Term::UnequalSides, true) => "unequal sides".to_owned(),
            (Term::TrueSlip, true) => {
                format!("true slip by the gyro: {:.3} of the scrub per rad/s", conditioning.true_slip)
            }
            (Term::TrueSlip, false) => "no true slip by the gyro".to_owned(),
            (Term::Delay, false) => "no delay".to_owned(),
            (Term::SlipMemory, false) => "no slip memory".to_owned(),
            (Term::UnequalSides, false) => "equal sides".to_owned(),
        };
        let error = judged.std_err.map_or("–".to_owned(), |error| format!("{:.1}", 100.0 * error));
        let moves = if judged.gain < 0.0 { "grows" } else { "falls" };
        println!(
            "{what}: on unseen blocks the error {moves} by {:.1} ± {error} % with the term",
            100.0 * judged.gain.abs()
        );
    }
}

fn print_text<const N: usize>(robot: &Robot, fit: &Fit<N>, arguments: &Arguments) -> Result<()> {
    println!("{}", answer(fit));
    for parameter in &fit.parameters {
        let value = quantity(parameter.value, parameter.std_err.unwrap_or(f64::INFINITY), &parameter.unit);
        let value = if parameter.std_err.is_some() {
            value
        } else {
            format!("{} {}", figure(parameter.value), parameter.unit)
        };
        println!("  {:<14} {value:<36} {}", parameter.name, verdict_word(parameter.verdict));
    }
    if arguments.units.verbose {
        print_details(robot, fit);
    }
    if let Some(out) = &arguments.out {
        println!("wrote {}", out.display());
    }
    Ok(())
}

/// What the fit is worth, in one line.
fn answer<const N: usize>(fit: &Fit<N>) -> String {
    if let Some(Defect { why, remedy }) = &fit.defect {
        return format!("NOT USABLE ({why}): {remedy}. Marked so");
    }
    let explained = fit.quality.r2.map_or("the power never changes".to_owned(), |r2| {
        // What is not all of it is not rounded to all of it.
        format!("explains {:.1} % of the power", (1000.0 * r2).floor() / 10.0)
    });
    let mut masses: Vec<f64> = fit.masses.clone();
    masses.sort_by(f64::total_cmp);
    let kg = match &masses[..] {
        [few @ .., last] if few.len() < 3 => {
            let few: Vec<String> = few.iter().map(f64::to_string).collect();
            if few.is_empty() { format!("{last} kg") } else { format!("{} and {last} kg", few.join(", ")) }
        }
        many => format!("{} masses of {} to {} kg", many.len(), masses[0], masses[many.len() - 1]),
    };
    let error = figure(fit.quality.rmse_w);
    let usable = if fit.shortcoming.is_some() { "Usable for power, not for payload" } else { "Usable" };
    let unsure: Vec<&Parameter> =
        fit.parameters.iter().filter(|parameter| parameter.verdict != Verdict::Determined).collect();
    let weak = unsure.first().map_or(String::new(), |first| {
        let names: Vec<&str> = unsure.iter().take(3).map(|parameter| parameter.name.as_str()).collect();
        let more = if unsure.len() > names.len() { ", …" } else { "" };
        format!(". Weak: {}{more}: {}", names.join(", "), first.remedy)
    });
    format!("{usable}: {explained} at {kg} (error {error} W){weak}")
}

fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Determined => "determined",
        Verdict::Weak => "weak",
        Verdict::Undetermined => "undetermined",
    }
}

/// How the fit was found, and all that it says of its errors.
fn print_details<const N: usize>(robot: &Robot, fit: &Fit<N>) {
    let quality = &fit.quality;
    println!("{}: {} rows", robot.name(), fit.rows);
    println!(
        "R² {}, MAPE {} (of {:.0} % of the samples, above {} W), RMSE {:.4} W",
        quality.r2.map_or("–".to_owned(), |r2| format!("{r2:.5}")),
        quality.mape_percent.map_or("–".to_owned(), |mape| format!("{mape:.2} %")),
        100.0 * quality.mape_share,
        quality.mape_floor_w,
        quality.rmse_w
    );
    println!(
        "filter {:.2} Hz; at rest or clamped in {:.1} % of the rows; {}; {} after {} steps in {:.3} s",
        fit.coefficients.robot.cutoff_hz,
        100.0 * fit.idle_share,
        condition_text(fit.uncertainty.condition),
        fit.ending,
        fit.iterations,
        fit.solve_s
    );
    if fit.kind == ModelKind::Signed {
        match fit.huber {
            Some(huber) => {
                let threshold = huber.threshold_std;
                println!("residuals beyond {threshold} standard deviations count linearly (Huber)")
            }
            None => println!("all residuals count squared: weights would cost what the model explains"),
        }
        if let Some(found) = &fit.restarts {
            let above = 100.0 * found.cost_above_share;
            println!(
                "the lowest end of {} random starts: {}",
                found.starts,
                match above {
                    above if above > 0.0 => format!("the fit's cost is {above:.4} % above it"),
                    above => format!("{:.4} % above the fit's cost", -above),
                }
            );
        }
    }
    if let Some(found) = &fit.certificate {
        println!("pgd: {:.4} % above the exact optimum's cost", 100.0 * found.excess_cost);
    }
    print_terms(fit);
    for parameter in &fit.parameters {
        if let Some(advice) = &parameter.advice {
            println!("{}: {advice}", parameter.name);
        }
    }
}
