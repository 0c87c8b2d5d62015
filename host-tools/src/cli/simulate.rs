//! `gmr simulate`: logs from the plant.

use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use plant::encoder::SpeedSource;
use plant::experiment::{self, Drive};
use plant::log::Totals;
use plant::sensors::PowerSource;
use plant::{
    Column, Columns, Geometry, Kinematics, PayloadSchedule, PlantSet, Profile, ProfileKind, Robot, Scenario,
    Sensors, Simulation, effects, log,
};
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output::{check_apart, write_whole};
use support::overwrite::Form;

use super::drive::DriveArguments;
use super::overwrite::OverwriteArgument;

/// Arguments of `gmr simulate`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr simulate --mass 1@0,6@100 --seed 7 --out train.csv\n  gmr simulate --profile test --mass 3 --no-mass --effect grade=0.03 --out hill.csv"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drive: DriveArguments,
    /// A drive of the paper's experiment as `gmr reproduce` has it, whole: motors, floor, sensors,
    /// profile and payload
    #[arg(long, value_enum, value_name = "DRIVE", conflicts_with_all = SETTINGS)]
    experiment: Option<Drive>,
    /// The robot's lengths, and its mass without payload, from a robot.toml (or burger, turtlebot4,
    /// warthog, husky); the motors are those of --plant
    #[arg(long, value_name = "R.toml", conflicts_with_all = ["kinematics", "experiment"])]
    robot: Option<PathBuf>,
    /// Wheel layout
    #[arg(long, value_enum, default_value = "differential")]
    kinematics: Kinematics,
    /// Forward speed of the constant profile, m/s [default: 0.9 of the robot's limit]
    #[arg(long, allow_negative_numbers = true)]
    speed: Option<f64>,
    /// Turn rate of the constant profile, rad/s
    #[arg(long, allow_negative_numbers = true)]
    turn: Option<f64>,
    /// Samples per second, Hz [default: 100 exact, 200 servo, 20 paper20]
    #[arg(long, allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Measuring chain: none; encoder ticks and INA219 with 0.1 W noise; the paper's experiment
    #[arg(long, value_enum, default_value = "exact")]
    sensors: Chain,
    /// Wheel speed: true, from encoder ticks between samples, or the servo's register (overrides
    /// the chain's)
    #[arg(long, value_enum)]
    speed_source: Option<SpeedSource>,
    /// Power: true, or through an INA219 (overrides the chain's)
    #[arg(long, value_enum)]
    power_source: Option<PowerSource>,
    /// Standard deviation of the power noise, W (overrides the chain's)
    #[arg(long, allow_negative_numbers = true)]
    power_noise: Option<f64>,
    /// Power noise that grows with the power: standard deviation added for every watt, W/W
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    power_noise_per_watt: f64,
    /// Heavy tails of the power noise: degrees of freedom of Student's t, above 2 [default:
    /// Gaussian]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    power_noise_tail: Option<f64>,
    /// Correlation of the power noise from sample to sample, above -1, below 1
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    power_autocorrelation: f64,
    /// INA219 conversions averaged in a reading: 1, 2, 4, … 128 (overrides the chain's)
    #[arg(long)]
    averages: Option<u32>,
    /// Standard deviation of the sampling instants, s
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    jitter: f64,
    /// Leave the mass out of the log: unknown to the estimator
    #[arg(long)]
    no_mass: bool,
    /// Power added to the log, W: a log of total power
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    static_power: f64,
    /// List the effects with their units, ranges and options, and end
    #[arg(long)]
    effects: bool,
    /// Add columns: pitch_rad, slope_heading_rad, cmd_v_m_s …, accel_x_m_s2 …, rolling_friction and
    /// static_friction, motor1_temp_c …, bus_v, cpu_percent
    #[arg(long, value_enum, value_delimiter = ',', value_name = "NAME,…")]
    columns: Vec<Column>,
    /// Add a column true_power_w: the supply power before sensors and noise, without static power
    #[arg(long)]
    truth: bool,
    /// The log to write; `-` for standard output
    #[arg(long, value_name = "FILE", required_unless_present = "effects")]
    out: Option<PathBuf>,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

/// Arguments that a preset leaves no room for.
const SETTINGS: [&str; 23] = [
    "plant",
    "profile",
    "duration",
    "mass",
    "loop_noise",
    "drive_efficiency",
    "regeneration",
    "effect",
    "kinematics",
    "speed",
    "turn",
    "rate",
    "sensors",
    "speed_source",
    "power_source",
    "power_noise",
    "power_noise_per_watt",
    "power_noise_tail",
    "power_autocorrelation",
    "averages",
    "jitter",
    "static_power",
    "effects",
];

/// Instead of a profile or a payload schedule that the preset has.
const PRESET: &str = "experiment";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
enum Chain {
    Exact,
    Servo,
    Paper20,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Summary<'a> {
    file: &'a Path,
    #[serde(skip_serializing_if = "Option::is_none")]
    experiment: Option<Drive>,
    rows: u64,
    duration_s: f64,
    rate_hz: f64,
    seed: u64,
    plant: PlantSet,
    profile: &'a str,
    sensors: Chain,
    mass: &'a str,
    effects: &'a [String],
    geometry: Geometry,
    gyration_radius_m: f64,
    supply_v: f64,
    energy_j: f64,
    mean_power_w: f64,
    peak_power_w: f64,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    if arguments.effects && arguments.json {
        return support::output::print_json(&effects::json());
    }
    if arguments.effects {
        support::output::print(format_args!("{}", effects::list()));
        return Ok(());
    }
    // clap has asked for it.
    let out = arguments.out.as_deref().unwrap_or(Path::new("-"));
    let to_stdout = out.as_os_str() == "-";
    if to_stdout && arguments.json {
        return Err(Error::usage("--out - and --json both write to standard output; allowed: one of them"));
    }
    check_apart((!to_stdout).then_some(out), [Path::new(&arguments.drive.profile)])?;
    if !to_stdout {
        arguments.overwrite.check(&arguments.out, Form::SimulatedLog)?;
    }
    check_columns(&arguments.columns)?;
    let scenario = scenario(context, arguments)?;
    let simulation = Simulation::new(&scenario)?;
    let totals = if to_stdout {
        let mut stdout = std::io::BufWriter::new(std::io::stdout().lock());
        let totals = write_rows(context, &mut stdout, out, arguments, simulation)?;
        stdout.flush().map_err(|error| Error::stdout(&error))?;
        totals
    } else {
        write_whole(out, |file| write_rows(context, file, out, arguments, simulation))?
    };
    if arguments.json {
        let preset = arguments.experiment.is_some();
        let summary = Summary {
            file: out,
            experiment: arguments.experiment,
            rows: totals.rows,
            duration_s: scenario.duration_s,
            rate_hz: scenario.rate_hz,
            seed: arguments.drive.seed,
            plant: arguments.drive.plant,
            profile: if preset { PRESET } else { &arguments.drive.profile },
            sensors: if preset { Chain::Paper20 } else { arguments.sensors },
            mass: if preset { PRESET } else { arguments.drive.mass() },
            effects: &arguments.drive.effect,
            geometry: scenario.robot.geometry,
            gyration_radius_m: scenario.robot.gyration_radius_m,
            supply_v: scenario.robot.supply_v,
            energy_j: totals.mean_w() * scenario.duration_s,
            mean_power_w: totals.mean_w(),
            peak_power_w: totals.peak_w,
        };
        support::output::print_json(&summary)?;
    } else if !to_stdout {
        eprintln!(
            "{}: {} rows, {} s at {} Hz, {:.3} W on average, {:.3} W at most",
            out.display(),
            totals.rows,
            scenario.duration_s,
            scenario.rate_hz,
            totals.mean_w(),
            totals.peak_w
        );
    }
    Ok(())
}

/// A log names every column once.
fn check_columns(columns: &[Column]) -> Result<()> {
    let repeated = (1..columns.len()).find(|&index| columns[..index].contains(&columns[index]));
    let Some(name) = repeated.and_then(|index| columns[index].to_possible_value()) else { return Ok(()) };
    Err(Error::usage(format!("--columns names {} twice; expected every name once", name.get_name())))
}

/// The scenario that the arguments ask for.
fn scenario(context: &Context, arguments: &Arguments) -> Result<Scenario> {
    let drive = &arguments.drive;
    if let Some(experiment) = arguments.experiment {
        return experiment::scenario(experiment, drive.seed);
    }
    let constant = arguments.speed.is_some() || arguments.turn.is_some();
    let mut scenario = match &arguments.robot {
        None => drive.scenario(arguments.kinematics)?,
        Some(name) => {
            let described = logs::robot::Robot::load(context, name)?;
            let mut scenario = drive.scenario_on(body_of(&described, drive.plant)?)?;
            if !drive.has_mass() {
                scenario.payload = PayloadSchedule::constant(described.mass_no_load_kg());
            }
            scenario
        }
    };
    if constant && drive.kind() != Some(ProfileKind::Constant) {
        return Err(Error::usage("--speed and --turn go with --profile constant only"));
    }
    if constant {
        scenario.profile = constant_profile(arguments, &scenario)?;
    }
    let preset_rate = match arguments.sensors {
        Chain::Exact => 100.0,
        Chain::Servo => 200.0,
        Chain::Paper20 => 20.0,
    };
    scenario.rate_hz = arguments.rate.unwrap_or(preset_rate);
    scenario.sensors = sensors(arguments, scenario.rate_hz);
    scenario.static_power_w = arguments.static_power;
    Ok(scenario)
}

/// A robot with the lengths of a robot.toml, and motors of a set.
fn body_of(described: &logs::robot::Robot, set: PlantSet) -> Result<Robot> {
    use logs::robot::Geometry as Described;
    let (kinematics, wheel_radius_m, track_m, wheelbase_m) = match *described.geometry() {
        Described::DifferentialDrive { wheel_radius_m, track_m } => {
            (Kinematics::Differential, wheel_radius_m, track_m, track_m)
        }
        // Two columns a side are those of two wheels: the plant's four would be four columns.
        Described::SkidSteer { wheel_radius_m, track_m, wheels: 2 } => {
            (Kinematics::Differential, wheel_radius_m, track_m, track_m)
        }
        Described::SkidSteer { wheel_radius_m, track_m, .. } => {
            (Kinematics::Skid, wheel_radius_m, track_m, track_m)
        }
        Described::ThreeWheelOmni { wheel_radius_m, arm_m } => {
            (Kinematics::Omni, wheel_radius_m, 2.0 * arm_m, 2.0 * arm_m)
        }
        Described::FourMecanum { wheel_radius_m, half_length_m, half_width_m } => {
            (Kinematics::Mecanum, wheel_radius_m, 2.0 * half_width_m, 2.0 * half_length_m)
        }
        Described::Matrix { .. } => {
            let message =
                "--robot with kinematics = \"matrix\": expected differential, skid-steer, omni3 or mecanum4";
            return Err(Error::usage(message));
        }
    };
    let mut body = Robot::new(set, kinematics);
    // The motors turn as fast as on the wheels that they were made for.
    let scale = wheel_radius_m / body.geometry.wheel_radius_m;
    let speed = body.limits.speed_m_s * scale;
    body.limits.speed_m_s = described.limits().speed_m_s.map_or(speed, |given| given.min(speed));
    body.limits.turn_rad_s = body.limits.turn_rad_s.min(2.0 * body.limits.speed_m_s / track_m);
    body.geometry = Geometry { kinematics, wheel_radius_m, track_m, wheelbase_m };
    body.gyration_radius_m = described.gyration_radius_m();
    Ok(body)
}

fn sensors(arguments: &Arguments, rate_hz: f64) -> Sensors {
    let mut sensors = match arguments.sensors {
        Chain::Exact => Sensors::exact(),
        Chain::Servo => Sensors::servo(rate_hz),
        Chain::Paper20 => Sensors::paper20(),
    };
    sensors.speed = arguments.speed_source.unwrap_or(sensors.speed);
    sensors.power = arguments.power_source.unwrap_or(sensors.power);
    sensors.power_noise_w = arguments.power_noise.unwrap_or(sensors.power_noise_w);
    sensors.ina219.averages = arguments.averages.unwrap_or(sensors.ina219.averages);
    sensors.power_noise_per_w = arguments.power_noise_per_watt;
    sensors.power_noise_tail = arguments.power_noise_tail;
    sensors.power_autocorrelation = arguments.power_autocorrelation;
    sensors.jitter_s = arguments.jitter;
    sensors
}

fn constant_profile(arguments: &Arguments, scenario: &Scenario) -> Result<Profile> {
    let (robot, limits) = (&scenario.robot, &scenario.robot.limits);
    let twist = [arguments.speed.unwrap_or(0.0), 0.0, arguments.turn.unwrap_or(0.0)];
    if !limits.allow(twist, &robot.geometry) {
        let (speed, turn) = (limits.speed_m_s, limits.turn_rad_s);
        return Err(Error::usage(format!(
            "speed {} m/s with turn {} rad/s; allowed: up to {speed} m/s (at every wheel) and {turn} rad/s",
            twist[0], twist[2]
        )));
    }
    Ok(Profile::constant(&robot.geometry, limits, twist))
}

fn write_rows(
    context: &Context,
    log: &mut dyn Write,
    out: &Path,
    arguments: &Arguments,
    run: Simulation<'_>,
) -> Result<Totals> {
    let failed = |error: std::io::Error| {
        if out.as_os_str() == "-" { Error::stdout(&error) } else { Error::io(out, &error) }
    };
    let columns =
        Columns { mass: !arguments.no_mass, truth: arguments.truth, further: arguments.columns.clone() };
    let (bar, begun) = (progress(run.rows()), Instant::now());
    let totals = log::write_rows(log, failed, run, &columns, |rows| {
        if rows.is_multiple_of(1000) {
            context.point();
        }
        if rows.is_multiple_of(1000) && begun.elapsed() > Duration::from_secs(1) {
            bar.set_position(rows);
        }
    })?;
    bar.finish_and_clear();
    Ok(totals)
}

/// A bar on standard error, not yet drawn; none when that is no terminal.
fn progress(rows: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("simulating {wide_bar} {percent} % {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let target = indicatif::ProgressDrawTarget::stderr();
    ProgressBar::with_draw_target(Some(rows), target).with_style(style)
}
