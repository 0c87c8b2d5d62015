//! `gmr export`: a fit in the words of other programs.

use std::path::PathBuf;

use answers::export::{Answer, Request, Target, allowed, cruise_m_s, export};
use logs::robot::{FOUND, Robot};
use support::context::Context;
use support::error::Result;
use support::output;
use support::overwrite::Form;

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
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
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

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let robot = Robot::load(context, &arguments.robot)?;
    let inputs = [&arguments.robot, &arguments.coeffs].map(PathBuf::as_path);
    output::check_apart(arguments.out.as_deref(), inputs)?;
    arguments.overwrite.check(&arguments.out, Form::Exported)?;
    let mass_kg = allowed("mass", arguments.mass.unwrap_or(robot.mass_no_load_kg()), 1e-6, 1e6)?;
    let speed_m_s = allowed("speed", arguments.speed.unwrap_or_else(|| cruise_m_s(&robot)), 1e-3, 100.0)?;
    let given = arguments.static_power.map(|watts| allowed("static-power", watts, 0.0, 1e6)).transpose()?;
    let request = Request {
        target: arguments.target,
        robot: &robot,
        coeffs: &arguments.coeffs,
        force: arguments.overwrite.force,
        mass_kg,
        speed_m_s,
        static_w: given.or(robot.static_power_w()),
        charge: arguments.charge,
    };
    let Answer { text, json } = export(context, &request)?;
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
