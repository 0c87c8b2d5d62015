//! `gmr estimate`: replays a log through the pipeline that the board runs.

use std::path::PathBuf;

use answers::estimate::board::{BoardReport, Delay};
use answers::estimate::{
    Answer, Change, GroundAt, MassError, Payloads, Policy, PolicyKind, Recorded, Replay, Request, Told,
    WindowMass, estimate,
};
use clap::ValueEnum;
use gap::words::quantity;
use logs::arguments::{Log, UnitArguments};
use logs::checks::check_mass;
use logs::robot::{FOUND, Robot};
use report::check_extension;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::figure::figure;
use support::metrics::Quality;
use support::output::check_apart;
use support::overwrite::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr estimate`.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  gmr estimate --robot robot.toml --coeffs coefficients.toml --plot run.png run.csv"
)]
pub(crate) struct Arguments {
    /// The log; a total mass behind its name is reported against, never used
    #[arg(value_name = "LOG[=KG]")]
    run: Log,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients as gmr fit writes them
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// Total mass, kg, where it is known: power and energy at this payload are given beside those
    /// at the estimated one [default: what the log tells]
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass: Option<f64>,
    /// Length of the window, s
    #[arg(long, default_value_t = 25.0, value_name = "S")]
    window: f64,
    /// How the mass is found [default: window for the signed model, roots for eq18]
    #[arg(long, value_enum)]
    payload: Option<Payloads>,
    /// When the mass is found (Algorithm 2)
    #[arg(long, value_enum, default_value = "moving")]
    schedule: ScheduleName,
    /// Length of a round of the periodic schedule, s
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    every: f64,
    /// Known times of payload changes since the start of the log, s
    #[arg(long, value_name = "S,…", value_delimiter = ',')]
    changes: Vec<f64>,
    /// Rolling resistance and scrub adapt along the way, with a memory of a minute, beside the
    /// mass: for floors that change. What then cannot be told apart widens the mass's interval
    #[arg(long, conflicts_with_all = ["payload", "schedule", "every"])]
    adapt: bool,
    /// Do not watch for payload changes
    #[arg(long)]
    no_detection: bool,
    /// What was true, as gmr board --truth writes it: reported against, never used
    #[arg(long, value_name = "TRUTH.csv")]
    truth: Option<PathBuf>,
    /// Write power over time: measured and predicted behind the filter, W, at the mass found and at
    /// the one told, and the mass found, kg
    #[arg(long, value_name = "POWER.csv")]
    power: Option<PathBuf>,
    /// Draw power and mass over time
    #[arg(long, value_name = "FILE.svg|png")]
    plot: Option<PathBuf>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ScheduleName {
    /// The latest window, every second
    Moving,
    /// Everything since the last known change
    Cumulative,
    /// The first window after each known change
    Known,
    /// The first window of every round
    Periodic,
}

#[derive(Serialize)]
struct Report<'a> {
    r2: Option<f64>,
    mape_percent: Option<f64>,
    mape_floor_w: f64,
    mape_share: Option<f64>,
    rmse_w: Option<f64>,
    known_share: f64,
    energy_j: f64,
    predicted_actuation_j: f64,
    rows: u64,
    /// Power and energy at the mass that the log tells, or that was given.
    told: Option<&'a Told>,
    changes: &'a [Change],
    /// The floor second by second, of --adapt.
    ground: &'a [GroundAt],
    windows: &'a [WindowMass],
    mass_error: Option<MassError>,
    /// The estimates that the board made of the same samples, where the log holds them.
    board: Option<BoardReport>,
    /// Changes of the true mass, where the truth is given.
    true_changes: &'a [Delay],
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, [&arguments.run])?;
    if let Some(plot) = &arguments.plot {
        check_extension(plot)?;
    }
    let inputs = [&arguments.run.path, &arguments.robot, &arguments.coeffs];
    let outputs = arguments.plot.iter().chain(&arguments.power);
    check_apart(
        outputs.map(PathBuf::as_path),
        inputs.into_iter().chain(&arguments.truth).map(PathBuf::as_path),
    )?;
    arguments.overwrite.check(&arguments.plot, Form::Drawing)?;
    arguments.overwrite.check(&arguments.power, Form::Power)?;
    let policy = policy(arguments)?;
    if let Some(mass) = arguments.mass {
        check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    }
    let request = Request {
        robot,
        recorded: Recorded { file: &arguments.run.path, mass_kg: arguments.mass },
        coeffs: &arguments.coeffs,
        force: arguments.overwrite.force,
        payloads: arguments.payload,
        policy,
        adapt: arguments.adapt,
        truth: arguments.truth.as_deref(),
        power: arguments.power.as_deref(),
        plot: arguments.plot.as_deref(),
    };
    let answer = estimate(context, &request)?;
    if arguments.json {
        return print_json(robot, &answer);
    }
    print_text(robot, &answer, arguments.units.verbose);
    Ok(())
}

fn policy(arguments: &Arguments) -> Result<Policy> {
    let kind = match arguments.schedule {
        ScheduleName::Moving => PolicyKind::Moving,
        ScheduleName::Cumulative => PolicyKind::Cumulative,
        ScheduleName::Known => PolicyKind::Known,
        ScheduleName::Periodic => PolicyKind::Periodic(arguments.every),
    };
    if let Some(wrong) = arguments.changes.iter().find(|change| !(change.is_finite() && **change >= 0.0)) {
        return Err(Error::usage(format!(
            "--changes {wrong}: expected times in s since the start of the log"
        )));
    }
    // The paper's fixed policies run as the paper has them.
    let detect = !arguments.no_detection && kind == PolicyKind::Moving;
    Ok(Policy { window_s: arguments.window, kind, changes_s: arguments.changes.clone(), detect })
}

fn print_json(robot: &Robot, answer: &Answer) -> Result<()> {
    let replay = &answer.replay;
    let quality = replay.quality;
    support::output::print_json(&Report {
        r2: quality.and_then(|q| q.r2),
        mape_percent: quality.and_then(|q| q.mape_percent),
        mape_floor_w: robot.mape_floor_w(),
        mape_share: quality.map(|q| q.mape_share),
        rmse_w: quality.map(|q| q.rmse_w),
        known_share: replay.known_share,
        energy_j: replay.energy_j,
        predicted_actuation_j: replay.predicted_j,
        rows: replay.rows,
        told: replay.told.as_ref(),
        changes: &replay.changes,
        ground: &replay.ground,
        windows: &replay.windows,
        mass_error: answer.mass_error,
        board: answer.board,
        true_changes: &answer.true_changes,
    })
}

fn print_text(robot: &Robot, answer: &Answer, verbose: bool) {
    let Answer { replay, headline, .. } = answer;
    println!("{headline}");
    println!("energy: {:.1} J, of actuation {:.1} J by the model", replay.energy_j, replay.predicted_j);
    if let Some(told) = &replay.told {
        print_told(told);
    }
    for change in &replay.changes {
        println!("payload changed at {:.1} s, noticed at {:.1} s", change.time_s, change.noticed_s);
    }
    if let (Some(first), Some(last)) = (replay.ground.first(), replay.ground.last()) {
        println!(
            "ground: rolling {} N·m/kg at {:.0} s, {} at {:.0} s",
            figure(first.rolling_nm_kg),
            first.time_s,
            quantity(last.rolling_nm_kg, last.rolling_std_nm_kg, "N·m/kg"),
            last.time_s
        );
        if last.scrub_std_nm_kg > 0.0 {
            println!(
                "        scrub {} N·m/kg, {}",
                figure(first.scrub_nm_kg),
                quantity(last.scrub_nm_kg, last.scrub_std_nm_kg, "N·m/kg")
            );
        }
    }
    if let Some(error) = answer.mass_error {
        println!(
            "against the logged mass, {} windows: mean error {:.1} %, worst {:.1} %, interval contains it in {:.0} %",
            error.windows,
            error.mean_percent,
            error.worst_percent,
            100.0 * error.interval_contains_truth
        );
    }
    print_beside(answer);
    if verbose {
        print_details(robot, replay);
    }
}

/// How well the power is predicted, and the mass window by window.
fn print_details(robot: &Robot, replay: &Replay) {
    println!("{}: {} rows, {:.1} s", robot.name(), replay.rows, replay.duration_s);
    match replay.quality {
        Some(Quality { r2, mape_percent, mape_share, rmse_w, .. }) => println!(
            "power: R² {}, MAPE {} (of {:.0} % of the samples, above {} W), RMSE {rmse_w:.4} W; mass known for {:.0} % of the time",
            r2.map_or("–".to_owned(), |r2| format!("{r2:.5}")),
            mape_percent.map_or("–".to_owned(), |mape| format!("{mape:.2} %")),
            100.0 * mape_share,
            robot.mape_floor_w(),
            100.0 * replay.known_share
        ),
        None => println!(
            "power: unknown, because the mass never was known{}",
            if replay.told.is_none() { "; --mass gives it at a known payload" } else { "" }
        ),
    }
    let known: Vec<&WindowMass> = replay.windows.iter().filter(|window| window.mass_kg.is_some()).collect();
    println!("mass: known in {} of {} windows", known.len(), replay.windows.len());
    // About ten lines, evenly spread.
    for window in replay.windows.iter().step_by(replay.windows.len().div_ceil(10).max(1)) {
        match (window.mass_kg, window.low_kg, window.high_kg) {
            (Some(mass), Some(low), Some(high)) => println!(
                "  {:>7.1} … {:>7.1} s  {mass:.3} kg  (95 %: {low:.3} … {high:.3}){}",
                window.t0_s,
                window.t1_s,
                match window.range {
                    Some("below") => ", lighter than the robot without payload",
                    Some("above") => ", heavier than the robot with its full payload",
                    _ => "",
                }
            ),
            _ => println!(
                "  {:>7.1} … {:>7.1} s  unknown: {}",
                window.t0_s,
                window.t1_s,
                window.unknown.unwrap_or("no reason")
            ),
        }
    }
}

/// Power and energy at the payload that somebody knows.
fn print_told(told: &Told) {
    let at = told.mass_kg.map_or("the masses of the log".to_owned(), |mass| format!("{mass} kg"));
    let Quality { r2, mape_percent, mape_share, rmse_w, mape_floor_w, .. } = told.quality;
    println!(
        "at {at}: R² {}, MAPE {} (of {:.0} % of the samples, above {mape_floor_w} W), RMSE {rmse_w:.4} W; actuation {:.1} J by the model",
        r2.map_or("–".to_owned(), |r2| format!("{r2:.5}")),
        mape_percent.map_or("–".to_owned(), |mape| format!("{mape:.2} %")),
        100.0 * mape_share,
        told.predicted_j
    );
}

fn print_beside(beside: &Answer) {
    if let Some(board) = &beside.board {
        print!("the board's own estimates: ");
        match board.quality {
            Some(Quality { mape_percent: Some(mape), .. }) => print!("power MAPE {mape:.2} %, "),
            _ => print!("power unknown, "),
        }
        println!(
            "the replay differs by at most {:.2} % in mass and {:.2} mW in power ({} samples)",
            100.0 * board.mass_difference,
            1e3 * board.power_difference_w,
            board.samples
        );
        if board.disagreements > 0 {
            println!("  in {} samples only one of the two knew the mass", board.disagreements);
        }
        if let Some(mass) = board.mass {
            println!(
                "  against the true mass, 25 s after each change: mean error {:.2} %, worst {:.2} %, interval contains it in {:.1} %",
                mass.mean_percent,
                mass.worst_percent,
                100.0 * mass.interval_contains_truth
            );
        }
    }
    for change in &beside.true_changes {
        match change.delay_s {
            Some(delay) => println!("true change at {:.1} s: noticed after {delay:.1} s", change.time_s),
            None => println!("true change at {:.1} s: not noticed", change.time_s),
        }
    }
}
