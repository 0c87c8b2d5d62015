//! `gmr gap`: where model and measurement disagree, and which effect is missing.

use std::path::PathBuf;

use model_core::eq18::Gate;
use model_core::model::Model;

use crate::error::{Error, Result};
use crate::fit::dataset::{Dataset, Reading};
use crate::fit::{file, physical};
use crate::gap::investigate::{Base, Options, investigate};
use crate::gap::runs::Runs;
use crate::gap::{extended, output, summary};
use crate::robot::Robot;
use crate::with_wheels;

/// Arguments of `gmr gap`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Logs: four runs at least, one or several a file
    #[arg(required = true, value_name = "RUN.csv")]
    runs: Vec<PathBuf>,
    /// The robot: a robot.toml, or burger, warthog, husky
    #[arg(long, default_value = "burger")]
    robot: PathBuf,
    /// Coefficients of an earlier clean fit: what is new since then? Without, base and effects are fitted together
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// The clean runs that the coefficients were fitted to, if they are no longer where they were: what the model gets wrong
    /// there as well is no effect
    #[arg(long, value_name = "RUN.csv", num_args = 1..)]
    base: Vec<PathBuf>,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Write the coefficients with the named effects, for gmr estimate, gmr flash and the board
    #[arg(long, value_name = "FILE.toml", requires = "coeffs")]
    out: Option<PathBuf>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let robot = Robot::load(&arguments.robot)?;
    with_wheels!(robot, run_with(&robot, arguments))
}

fn run_with<const N: usize>(robot: &Robot, arguments: &Arguments) -> Result<()> {
    let mass = arguments.mass.unwrap_or(robot.mass_no_load_kg());
    if !(mass > 0.0 && mass.is_finite()) {
        return Err(Error::usage(format!("--mass {mass}: expected a mass above 0 kg")));
    }
    let (core, base) = match &arguments.coeffs {
        Some(coefficients) => {
            let read = file::read::<N>(coefficients, robot)?;
            let Model::Signed { torque, drive } = read.model else {
                return Err(Error::failed("model eq18; expected signed: effects act on its torques")
                    .in_file(coefficients)
                    .in_column("model"));
            };
            if let Some(effect) = read.columns.iter().next() {
                let message = format!(
                    "they hold the effect {} already; expected the coefficients as gmr fit wrote them, from which all \
                     effects are looked for together",
                    extended::id_of(&effect.cause).0
                );
                return Err(Error::failed(message).in_file(coefficients).in_column("effects"));
            }
            let covariance = Some(file::read_covariance(coefficients)?);
            (read.robot, Base { torque, covariance, drive })
        }
        None => {
            let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg: mass };
            let dataset = Dataset::<N>::read(robot, &arguments.runs, &reading)?;
            let torque = physical::solve(&dataset, robot.drive()).torque;
            (dataset.robot, Base { torque, covariance: None, drive: robot.drive() })
        }
    };
    let runs = Runs::<N>::read(robot, &core, &arguments.runs, mass)?;
    let clean_logs = match (&arguments.base[..], &arguments.coeffs) {
        ([], Some(coefficients)) => file::read_logs(coefficients)?,
        (given, _) => given.to_owned(),
    };
    let clean = match &clean_logs[..] {
        [] => None,
        files => Some(Runs::<N>::read(robot, &core, files, mass)?),
    };
    if clean.is_none() && arguments.coeffs.is_some() {
        eprintln!(
            "gmr: the clean runs of these coefficients are not there: what the model gets wrong without any effect is not \
             known, so only large effects are named; give the runs with --base"
        );
    }
    let report = investigate(&runs, clean.as_ref(), &base, &Options::default())?;
    if let (Some(out), Some(base)) = (&arguments.out, &arguments.coeffs) {
        extended::write(&report, base, out)?;
    }
    if arguments.json {
        super::print_json(&output::json(&report, None))
    } else {
        println!("{}", summary::text(&report).trim_end());
        Ok(())
    }
}
