//! `gmr fit`: logs to coefficients.

use std::path::PathBuf;

use answers::inspect;
use board::flasher;
use fit::entrance;
use fit::form::{TERMS, TERMS_WITH_GYRO, Term};
use fit::from_logs::{Answer, Request, Use, from_logs};
use fit::pgd;
use fit::usable::Defect;
use fit::verdict::{Parameter, Verdict};
use fit::warning::Kind;
use gap::words::quantity;
use logs::arguments::{Log, UnitArguments, paths};
use logs::checks;
use logs::robot::{FOUND, Robot};
use model::coefficients::{Method, ModelKind};
use support::context::Context;
use support::error::{Error, Result};
use support::figure::figure;
use support::output::{self, check_apart, write_content};
use support::overwrite::Form;

use super::fit_grams;
use super::overwrite::OverwriteArgument;

/// Arguments of `gmr fit`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr fit --robot robot.toml --out coefficients.toml empty.mcap=1.0 full.mcap=6.0\n  gmr fit --robot husky --mass 75 --json floor_*.csv"
)]
pub(crate) struct Arguments {
    /// Logs of drives with known payload: two of them, empty and fully loaded, at least. Where a
    /// log does not hold the robot's total mass (mass_kg), write it behind the name: empty.mcap=1.0
    /// full.mcap=6.0
    #[arg(required_unless_present = "grams", value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// Sums of gmr gram instead of logs: Eq. 18 as from the rows, the signed model from those that
    /// its clamp leaves alone. Without what needs rows: errors in percent, delay and slip memory,
    /// robust weights, and --out but with --coeffs
    #[arg(long, value_name = "GRAMS.jsonl", num_args = 1.., conflicts_with_all = ["runs", "mass"])]
    grams: Vec<PathBuf>,
    /// With --grams: the coefficients that gmr gram --coeffs took the sums near. The next ones, a
    /// step of Gauss and Newton on, clamped wheels included; --out writes them
    #[arg(long, value_name = "C.toml", requires = "grams", conflicts_with_all = ["leave_one_out", "method"])]
    coeffs: Option<PathBuf>,
    /// With --grams: also how well each run is predicted by the others
    #[arg(long, requires = "grams")]
    leave_one_out: bool,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Where the coefficients go. A fit that cannot be used is not written but with --force, which
    /// marks it
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
    /// Search again from so many random starts, and say how far below the fit's cost the best of
    /// them ends: of the signed model
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

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    if !arguments.grams.is_empty() {
        return run_grams(context, robot, arguments);
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
    let problem = inspect::first_problem(context, robot, &logs)?;
    let defect = problem.map(|(log, problem)| Defect {
        why: format!("{}: {}", log.display(), problem.text),
        remedy: problem.advice,
    });
    let refuse = |why: &str, remedy: &str| match arguments.overwrite.force {
        true => Ok(()),
        false => Err(Error::failed(format!("NOT USABLE ({why}): {remedy}. Nothing written"))),
    };
    let mut fit = from_logs(
        context,
        &Request {
            robot,
            files: &logs,
            mass_kg: mass,
            kind: arguments.model,
            terms: if arguments.no_gyro { &TERMS } else { &TERMS_WITH_GYRO },
            method,
            pgd: &settings,
            random_starts: arguments.starts,
            out: arguments.out.as_deref(),
            defect: defect.as_ref(),
            force: arguments.overwrite.force,
        },
    )?;
    if let (Some(why), Some(remedy)) = (&fit.why, &fit.remedy) {
        refuse(why, remedy)?;
    }
    fit.shortcoming.iter().for_each(|shortcoming| context.notice(shortcoming));
    fit.warnings.iter().for_each(|warning| context.notice(&warning.text));
    if let (Some(out), Some(written)) = (&arguments.out, fit.written.take()) {
        flasher::check_fitted(context, robot, fit.image.as_ref()).map_err(|error| {
            // Absurd coefficients may come from a log that is in another unit.
            let doubted = fit.warnings.iter().find(|warning| warning.kind == Kind::SuspectLog);
            doubted.iter().fold(error.in_file(out), |error, warning| error.after(&warning.text))
        })?;
        write_content(out, written)?;
    }
    if arguments.json {
        return output::print_json(&fit);
    }
    print_text(&fit, arguments);
    Ok(())
}

fn run_grams(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    let Arguments { grams, model, method, leave_one_out, json, .. } = arguments;
    if let Some(near) = &arguments.coeffs {
        let outputs = arguments.out.as_deref();
        check_apart(outputs, grams.iter().chain([near, &arguments.robot]).map(PathBuf::as_path))?;
        arguments.overwrite.check(&arguments.out, Form::Coefficients)?;
        return fit_grams::step(context, robot, grams, near, *model, arguments.out.as_deref(), *json);
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
    fit_grams::run(context, robot, grams, *model, *leave_one_out, *json)
}

/// Of the parameters' information; none where it is singular.
fn condition_text(condition: Option<f64>) -> String {
    condition.map_or_else(
        || "no condition, for these rows leave some parameter open".to_owned(),
        |condition| format!("condition {condition:.1e}"),
    )
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

/// The further terms that were taken, and what the others would have gained.
fn print_terms(fit: &Answer) {
    for judged in &fit.terms {
        let what = match (judged.term, judged.taken) {
            (Term::Delay, true) => format!("power {:.3} s behind the speeds", fit.power_delay_s),
            (Term::SlipMemory, true) => {
                format!(
                    "scrub builds up: half at a slip of {:.3}, over {:.2} rad",
                    fit.half_slip, fit.slip_relaxation_rad
                )
            }
            (Term::UnequalSides, true) => "unequal sides".to_owned(),
            (Term::GearLoss, true) if fit.wheel_friction_share > 0.0 => {
                "the gear takes a share of what passes it, friction included".to_owned()
            }
            (Term::GearLoss, true) => "the gear takes a share of what passes it, friction apart".to_owned(),
            (Term::BridgeDrop, true) => "the bridge takes a voltage of its own".to_owned(),
            (Term::TrueSlip, true) => {
                format!("true slip by the gyro: {:.3} of the scrub per rad/s", fit.true_slip_s_rad)
            }
            (Term::TrueSlip, false) => "no true slip by the gyro".to_owned(),
            (Term::Delay, false) => "no delay".to_owned(),
            (Term::SlipMemory, false) => "no slip memory".to_owned(),
            (Term::UnequalSides, false) => "equal sides".to_owned(),
            (Term::GearLoss, false) => "no loss of the gear by what passes it".to_owned(),
            (Term::BridgeDrop, false) => "no drop of the bridge".to_owned(),
        };
        let error = judged.std_err.map_or("–".to_owned(), |error| format!("{:.1}", 100.0 * error));
        let moves = if judged.gain < 0.0 { "grows" } else { "falls" };
        println!(
            "{what}: on unseen blocks the error {moves} by {:.1} ± {error} % with the term",
            100.0 * judged.gain.abs()
        );
    }
}

fn print_text(fit: &Answer, arguments: &Arguments) {
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
        print_details(fit);
    }
    if let Some(out) = &arguments.out {
        println!("wrote {}", out.display());
    }
}

/// What the fit is worth, in one line.
fn answer(fit: &Answer) -> String {
    if let (Some(why), Some(remedy)) = (&fit.why, &fit.remedy) {
        return format!("NOT USABLE ({why}): {remedy}. Marked so");
    }
    let explained = fit.quality.r2.map_or("the power never changes".to_owned(), |r2| {
        // What is not all of it is not rounded to all of it.
        format!("explains {:.1} % of the power", (1000.0 * r2).floor() / 10.0)
    });
    let mut masses: Vec<f64> = fit.masses_kg.clone();
    masses.sort_by(f64::total_cmp);
    let kg = match &masses[..] {
        [few @ .., last] if few.len() < 3 => {
            let few: Vec<String> = few.iter().map(f64::to_string).collect();
            if few.is_empty() { format!("{last} kg") } else { format!("{} and {last} kg", few.join(", ")) }
        }
        many => format!("{} masses of {} to {} kg", many.len(), masses[0], masses[many.len() - 1]),
    };
    let error = figure(fit.quality.rmse_w);
    let usable =
        if fit.verdict == Use::UsableForPower { "Usable for power, not for payload" } else { "Usable" };
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
fn print_details(fit: &Answer) {
    let quality = &fit.quality;
    println!("{}: {} rows", fit.robot, fit.rows);
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
        fit.filter_cutoff_hz,
        100.0 * fit.idle_share,
        condition_text(fit.condition),
        fit.ending,
        fit.iterations,
        fit.fit_s
    );
    if fit.model == ModelKind::Signed {
        match fit.huber_threshold_std {
            Some(threshold) => {
                println!("residuals beyond {threshold} standard deviations count linearly (Huber)")
            }
            None => println!("all residuals count squared: weights would cost what the model explains"),
        }
        if let Some(restarts) = &fit.restarts {
            let above = 100.0 * restarts.cost_above_share;
            println!(
                "the lowest end of {} random starts: {}",
                restarts.starts,
                match above {
                    above if above > 0.0 => format!("the fit's cost is {above:.4} % above it"),
                    above => format!("{:.4} % above the fit's cost", -above),
                }
            );
        }
    }
    if let Some(pgd) = &fit.pgd {
        println!("pgd: {:.4} % above the exact optimum's cost", 100.0 * pgd.excess_cost);
    }
    print_terms(fit);
    for parameter in &fit.parameters {
        if let Some(advice) = &parameter.advice {
            println!("{}: {advice}", parameter.name);
        }
    }
}
