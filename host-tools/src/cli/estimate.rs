//! `gmr estimate`: replays a log through the pipeline that the board runs.

use std::path::PathBuf;

use answers::estimate::board::{self, BoardReport, BoardTrack, Delay};
use answers::estimate::plot::Track;
use answers::estimate::{
    Change, GroundAt, Instant, Payloads, Policy, PolicyKind, Recorded, Replay, Told, WindowMass,
    replay_adapting, replay_at,
};
use clap::ValueEnum;
use logs::checks::check_mass;
use logs::robot::{FOUND, Robot};
use logs::with_wheels;
use model::coefficients::{CoefficientsFile, Taking};
use report::check_extension;
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::Quality;
use support::output::{check_apart, write_whole};
use support::own::{Form, POWER};

use super::overwrite::OverwriteArgument;
use super::units::UnitArguments;
use super::weighed::Log;
use gap::words::quantity;
use support::figure::figure;

/// Arguments of `gmr estimate`.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  gmr estimate --robot robot.toml --coeffs coefficients.toml --plot run.png run.csv"
)]
pub(crate) struct Arguments {
    /// The log; a total mass behind its name is reported against, never used
    #[arg(value_name = "LOG[=KG]")]
    run: Log,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients as gmr fit writes them
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// Total mass, kg, where it is known: power and energy at this payload are given beside those at the estimated one [default: what the log
    /// tells]
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
    /// Rolling resistance and scrub adapt along the way, with a memory of a minute, beside the mass: for floors that change. What then cannot be
    /// told apart widens the mass's interval
    #[arg(long, conflicts_with_all = ["payload", "schedule", "every"])]
    adapt: bool,
    /// Do not watch for payload changes
    #[arg(long)]
    no_detection: bool,
    /// What was true, as gmr board --truth writes it: reported against, never used
    #[arg(long, value_name = "TRUTH.csv")]
    truth: Option<PathBuf>,
    /// Write power over time: measured and predicted behind the filter, W, at the mass found and at the one told, and the mass found, kg
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
    true_changes: Vec<Delay>,
}

/// What there is beside the replay.
struct Beside {
    board: Option<BoardReport>,
    true_changes: Vec<Delay>,
}

/// Errors of the windows whose true mass the log tells.
#[derive(Debug, Clone, Copy, Serialize)]
struct MassError {
    windows: usize,
    mean_percent: f64,
    worst_percent: f64,
    interval_contains_truth: f64,
}

impl MassError {
    fn of(windows: &[WindowMass]) -> Option<Self> {
        let known: Vec<(f64, bool)> = windows
            .iter()
            .filter_map(|window| {
                let (mass, truth) = (window.mass_kg?, window.truth_kg?);
                let inside = window.low_kg? <= truth + 1e-9 && truth - 1e-9 <= window.high_kg?;
                Some((100.0 * (mass / truth - 1.0).abs(), inside))
            })
            .collect();
        if known.is_empty() {
            return None;
        }
        let count = known.len() as f64;
        Some(Self {
            windows: known.len(),
            mean_percent: known.iter().map(|(error, _)| error).sum::<f64>() / count,
            worst_percent: known.iter().map(|(error, _)| *error).fold(0.0, f64::max),
            interval_contains_truth: known.iter().filter(|(_, inside)| *inside).count() as f64 / count,
        })
    }
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
    with_wheels!(robot, run_with(context, robot, arguments))
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    let taking = Taking { true_slip: true, not_usable: arguments.overwrite.force.then_some(context) };
    let coefficients = CoefficientsFile::<N>::read_taking(&arguments.coeffs, robot, taking)?.coefficients;
    let payloads = arguments.payload.unwrap_or(Payloads::default_for(&coefficients.model));
    let policy = policy(arguments)?;
    let mut track = Track::default();
    let mut board =
        BoardTrack::open(context, &arguments.run.path, arguments.truth.as_deref(), robot.mape_floor_w())?;
    let mut broken = None;
    if let Some(mass) = arguments.mass {
        check_mass(robot, mass).map_err(|error| Error::usage(format!("--mass: {}", error.message())))?;
    }
    let mut replay_to = |write: &mut dyn FnMut(&Instant) -> Result<()>| {
        let watch = |instant: &Instant| {
            let done = board.add(instant).and_then(|instant| {
                track.add(&instant);
                write(&instant)
            });
            if let Err(error) = done {
                broken.get_or_insert(error);
            }
        };
        let recorded = Recorded { file: &arguments.run.path, mass_kg: arguments.mass };
        if arguments.adapt {
            let replay = replay_adapting(context, robot, &coefficients, &recorded, &policy, watch);
            return replay.map_err(|error| {
                if error.file().is_none() { error.in_file(&arguments.coeffs) } else { error }
            });
        }
        replay_at(context, robot, &coefficients, &recorded, payloads, &policy, watch)
    };
    let replay = match &arguments.power {
        None => replay_to(&mut |_| Ok(())),
        Some(file) => write_whole(file, |out| {
            let failed = |error: std::io::Error| Error::io(file, &error);
            out.write_all(POWER.as_bytes()).map_err(failed)?;
            replay_to(&mut |instant| out.write_all(power_line(instant).as_bytes()).map_err(failed))
        }),
    }?;
    if let Some(error) = broken {
        return Err(error);
    }
    let true_changes = match &arguments.truth {
        Some(truth) => board::delays(
            context,
            truth,
            replay.start_s,
            replay.start_s + replay.duration_s,
            &replay.changes,
        )?,
        None => Vec::new(),
    };
    let beside = Beside { board: board.report(), true_changes };
    if let Some(plot) = &arguments.plot {
        track.page(&answer(robot, &replay)).save(plot)?;
    }
    if replay.exclusions.total() > 0 {
        context.notice(format_args!("{}: {}", arguments.run.path.display(), replay.exclusions));
    }
    if arguments.json {
        print_json(robot, &replay, beside)
    } else {
        print_text(robot, &replay, &beside, arguments.units.verbose)
    }
}

/// A row of [`POWER`]; empty where a figure is not known.
fn power_line(instant: &Instant) -> String {
    let (low, high) = instant.interval_kg.unzip();
    let fields = [Some(instant.measured_w), instant.predicted_w, instant.told_w, instant.mass_kg, low, high];
    let mut line = instant.time_s.to_string();
    for field in fields {
        line.push(',');
        line += &field.map_or_else(String::new, |number| number.to_string());
    }
    line + "\n"
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

fn print_json(robot: &Robot, replay: &Replay, beside: Beside) -> Result<()> {
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
        mass_error: MassError::of(&replay.windows),
        board: beside.board,
        true_changes: beside.true_changes,
    })
}

/// The payload now, and since when it is the same.
pub(super) fn answer(robot: &Robot, replay: &Replay) -> String {
    let since = match replay.changes.last() {
        Some(change) => format!("changed at {:.0} s", change.time_s),
        None => format!("no change in {:.0} s", replay.duration_s),
    };
    let known = |window: &&WindowMass| window.mass_kg.is_some();
    let Some(window) = replay.windows.iter().rev().find(known) else {
        let why = replay.windows.last().and_then(|window| window.unknown);
        let why = why.unwrap_or("the log is shorter than the window (--window)");
        return format!("Payload unknown: {why}");
    };
    let empty = robot.mass_no_load_kg();
    let (total, low, high) = match (window.mass_kg, window.low_kg, window.high_kg) {
        (Some(total), Some(low), Some(high)) => (total, low, high),
        (total, ..) => {
            return format!("Payload about {} kg, {since}", figure(total.unwrap_or(empty) - empty));
        }
    };
    let beyond = match window.range {
        Some("below") => " or less: lighter than the robot without payload",
        Some("above") => " or more: heavier than the robot with its full payload",
        _ => "",
    };
    // As many digits as the interval has.
    let digits = (1.0 - (high - low).max(1e-3).log10().floor()).clamp(0.0, 3.0) as usize;
    let payload = |mass: f64| format!("{:.digits$}", (mass - empty).max(0.0));
    format!(
        "Payload {} kg{beyond} ({} to {}, 95 %); total {total:.digits$} kg, {since}",
        payload(total),
        payload(low),
        payload(high)
    )
}

fn print_text(robot: &Robot, replay: &Replay, beside: &Beside, verbose: bool) -> Result<()> {
    println!("{}", answer(robot, replay));
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
    if let Some(error) = MassError::of(&replay.windows) {
        println!(
            "against the logged mass, {} windows: mean error {:.1} %, worst {:.1} %, interval contains it in {:.0} %",
            error.windows,
            error.mean_percent,
            error.worst_percent,
            100.0 * error.interval_contains_truth
        );
    }
    print_beside(beside);
    if verbose {
        print_details(robot, replay);
    }
    Ok(())
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

fn print_beside(beside: &Beside) {
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
