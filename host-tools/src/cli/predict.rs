//! `gmr predict`: the energy of a planned drive, and whether the battery has it.

use std::path::PathBuf;

use answers::predict::{Load, Question, Request, predict};
use logs::arguments::UnitArguments;
use logs::robot::{FOUND, Robot};
use numerics::robust::NORMAL_95;
use support::context::Context;
use support::error::{Error, Result};
use support::output;

/// Arguments of `gmr predict`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr predict --robot robot.toml --coeffs coefficients.toml --plan route.csv --mass 3.2 --mass-interval 3.0,3.4\n  \
    gmr predict --robot robot.toml --coeffs coefficients.toml --plan route.csv --mass 3.2 --static-power 6.4 --charge 0.6"
)]
pub(crate) struct Arguments {
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// The coefficients
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// The plan: CSV with time_s, v_m_s, omega_rad_s (slope_rad, leg), or a leg a row with
    /// distance_m, speed_m_s (turn_rad, slope_rad, pause_s, leg), or a log, whose speeds are taken
    /// as planned and whose power is shown beside
    #[arg(long, value_name = "PLAN")]
    plan: PathBuf,
    /// Total mass, kg
    #[arg(long, value_name = "KG")]
    mass: f64,
    /// 95 % interval of the mass, kg, as gmr estimate gives it
    #[arg(long, value_name = "LOW,HIGH", value_delimiter = ',')]
    mass_interval: Option<Vec<f64>>,
    /// What the robot draws besides driving, W [default: static_power_w of robot.toml]
    #[arg(long, value_name = "W")]
    static_power: Option<f64>,
    /// Its standard deviation, W
    #[arg(long, value_name = "W", default_value_t = 0.0)]
    static_std: f64,
    /// Charge of the battery now, 0 to 1: says whether the task fits. The battery is that of
    /// [battery] in robot.toml
    #[arg(long, value_name = "SHARE")]
    charge: Option<f64>,
    /// Its standard deviation
    #[arg(long, value_name = "SHARE", default_value_t = 0.02, requires = "charge")]
    charge_std: f64,
    /// Charge that is not to be used
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, requires = "charge")]
    reserve: f64,
    /// Resistance of the pack, Ω, where it has been learned
    #[arg(long, value_name = "OHM", requires = "charge")]
    resistance: Option<f64>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, [])?;
    let request = Request {
        robot,
        coeffs: &arguments.coeffs,
        plan: &arguments.plan,
        load: load(robot, arguments)?,
        question: question(arguments)?,
    };
    let report = predict(context, &request)?;
    if arguments.json {
        return output::print_json(&report);
    }
    output::print(format_args!("{}", report.summary()));
    Ok(())
}

fn load(robot: &Robot, arguments: &Arguments) -> Result<Load> {
    let positive = |name: &str, value: f64, least: f64| {
        if value.is_finite() && value >= least && value < 1e6 {
            return Ok(value);
        }
        Err(Error::usage(format!(
            "--{name} {value}; expected {}",
            if least > 0.0 { "a mass above 0 kg" } else { "0 or more" }
        )))
    };
    let mass_kg = positive("mass", arguments.mass, f64::MIN_POSITIVE)?;
    let mass_std_kg = match arguments.mass_interval.as_deref() {
        None => 0.0,
        Some(&[low, high]) if low > 0.0 && low <= mass_kg && mass_kg <= high && high.is_finite() => {
            (high - low) / (2.0 * NORMAL_95)
        }
        Some(ends) => {
            return Err(Error::usage(format!(
                "--mass-interval {ends:?}; expected LOW,HIGH about the mass of {mass_kg} kg"
            )));
        }
    };
    let static_w = arguments.static_power.map(|watts| positive("static-power", watts, 0.0)).transpose()?;
    Ok(Load {
        mass_kg,
        mass_std_kg,
        static_w: static_w.or(robot.static_power_w()),
        static_std_w: positive("static-std", arguments.static_std, 0.0)?,
    })
}

fn question(arguments: &Arguments) -> Result<Option<Question>> {
    let Some(charge) = arguments.charge else { return Ok(None) };
    for (name, value) in
        [("charge", charge), ("charge-std", arguments.charge_std), ("reserve", arguments.reserve)]
    {
        if !(0.0..=1.0).contains(&value) {
            return Err(Error::usage(format!("--{name} {value}; expected a share of 0 to 1")));
        }
    }
    if let Some(ohm) = arguments.resistance.filter(|ohm| !(*ohm > 0.0 && *ohm < 100.0)) {
        return Err(Error::usage(format!("--resistance {ohm}; expected above 0 and below 100 Ω")));
    }
    let Arguments { charge_std, reserve, resistance, .. } = *arguments;
    Ok(Some(Question { charge, charge_std, reserve, resistance_ohm: resistance }))
}
