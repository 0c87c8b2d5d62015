//! `gmr export`: a fit in the words of other programs.

use std::path::PathBuf;

use answers::export::joints::{self, Language};
use answers::export::{cruise_m_s, rmf, vda5050};
use logs::robot::{FOUND, Robot};
use logs::with_wheels;
use model::coefficients::{CoefficientsFile, Taking};
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::own::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr export`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr export rmf --robot robot.toml --coeffs coefficients.toml --mass 3.2 --static-power 6.4\n  \
    gmr export vda5050 --robot burger --coeffs coefficients.toml --mass 3.2 --static-power 6.4 --charge 0.7\n  \
    gmr export mjcf --robot robot.toml --coeffs coefficients.toml --out wheel.xml"
)]
pub(crate) struct Arguments {
    /// In whose words
    #[arg(value_enum)]
    target: Target,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// The coefficients
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// Total mass, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Speed for friction and reach, m/s [default: 0.8 of max_speed_m_s, else 0.2]
    #[arg(long, value_name = "M_S")]
    speed: Option<f64>,
    /// What the robot draws besides driving, W [default: static_power_w of robot.toml]
    #[arg(long, value_name = "W")]
    static_power: Option<f64>,
    /// vda5050: charge now, 0 to 1
    #[arg(long, value_name = "SHARE")]
    charge: Option<f64>,
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Figures as JSON on standard output (vda5050 is JSON anyway)
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Target {
    /// Open-RMF: mass, friction, inertia, ambient and tool power, as YAML
    Rmf,
    /// VDA 5050: battery and load fields of a state
    Vda5050,
    /// Gazebo: friction and damping of a wheel's joint
    Sdf,
    /// MuJoCo: friction, damping and armature of a wheel's joint
    Mjcf,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let robot = Robot::load(context, &arguments.robot)?;
    with_wheels!(robot, run_with(context, &robot, arguments))
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    let inputs = [&arguments.robot, &arguments.coeffs].map(PathBuf::as_path);
    output::check_apart(arguments.out.as_deref(), inputs)?;
    arguments.overwrite.check(&arguments.out, Form::Exported)?;
    let allowed = |name: &str, value: f64, least: f64, most: f64| {
        if value >= least && value <= most {
            return Ok(value);
        }
        Err(Error::usage(format!("--{name} {value}; expected {least} to {most}")))
    };
    let mass = allowed("mass", arguments.mass.unwrap_or(robot.mass_no_load_kg()), 1e-6, 1e6)?;
    let speed = allowed("speed", arguments.speed.unwrap_or_else(|| cruise_m_s(robot)), 1e-3, 100.0)?;
    let given = arguments.static_power.map(|watts| allowed("static-power", watts, 0.0, 1e6)).transpose()?;
    let static_w = given.or(robot.static_power_w());
    let taking = Taking { not_usable: arguments.overwrite.force.then_some(context), ..Taking::default() };
    let file = CoefficientsFile::<N>::read_taking(&arguments.coeffs, robot, taking)?;
    let coefficients = &file.coefficients;
    let (text, json) = match arguments.target {
        Target::Rmf => {
            let export = rmf::export(robot, coefficients, mass, speed, static_w)?;
            (export.yaml(robot), pretty(&export))
        }
        Target::Sdf | Target::Mjcf => {
            let export = joints::export(robot, coefficients, mass)?;
            let language = if arguments.target == Target::Sdf { Language::Sdf } else { Language::Mjcf };
            (export.text(language), pretty(&export))
        }
        Target::Vda5050 => {
            let missing = |what: &str| Error::usage(format!("vda5050 needs {what}"));
            let charge = arguments.charge.ok_or_else(|| missing("--charge, 0 to 1"))?;
            let now = vda5050::Now {
                charge: allowed("charge", charge, 0.0, 1.0)?,
                mass_kg: mass,
                static_w: static_w
                    .ok_or_else(|| missing("--static-power W, or static_power_w in robot.toml"))?,
                speed_m_s: speed,
            };
            let pack = robot.battery().ok_or_else(|| missing("[battery] in robot.toml"))?;
            let state = pretty(&vda5050::state(robot, coefficients, pack, &now)?);
            (state.clone(), state)
        }
    };
    match &arguments.out {
        Some(file) => output::write_content(file, text)?,
        None if !arguments.json => output::print(format_args!("{text}")),
        None => {}
    }
    if arguments.json {
        output::print(format_args!("{json}"));
    }
    Ok(())
}

fn pretty(value: &impl serde::Serialize) -> String {
    // Numbers and strings only: there is nothing to refuse.
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}
