//! `gmr gap`: where model and measurement disagree, and which effect is missing.

use std::path::PathBuf;

use model_core::eq18::Gate;
use model_core::model::Model;

use crate::error::{Error, Result};
use crate::fit::dataset::{Dataset, Reading};
use crate::fit::{file, physical};
use crate::gap::investigate::{Base, Options, investigate};
use crate::gap::output::Beside;
use crate::gap::runs::Runs;
use crate::gap::{manoeuvre, output, simulation, summary};
use crate::plant::PlantSet;
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
    /// Drive a simulated robot with these motors along the recorded wheel speeds as well: calibrated on the clean runs, without the
    /// named effects and with them
    #[arg(long, value_enum)]
    plant: Option<PlantSet>,
    /// Where the speed profile that parts the rivals of a tie is written
    #[arg(long, value_name = "FILE", default_value = "gap_profile.csv")]
    profile: PathBuf,
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
    let raw = Runs::<N>::raw(robot, &arguments.runs, mass)?;
    let runs = Runs::condition(&core, raw.clone())?;
    let clean_logs = match (&arguments.base[..], &arguments.coeffs) {
        ([], Some(coefficients)) => file::read_logs(coefficients)?,
        (given, _) => given.to_owned(),
    };
    let raw_clean = match &clean_logs[..] {
        [] => None,
        files => Some(Runs::<N>::raw(robot, files, mass)?),
    };
    let clean = raw_clean.clone().map(|raw| Runs::condition(&core, raw)).transpose()?;
    if clean.is_none() && arguments.coeffs.is_some() {
        eprintln!(
            "gmr: the clean runs of these coefficients are not there: what the model gets wrong without any effect is not \
             known, so only large effects are named; give the runs with --base"
        );
    }
    let report = investigate(&runs, clean.as_ref(), &base, &Options::default())?;
    let simulated = arguments
        .plant
        .map(|plant| simulation::simulate(plant, robot, &core, &raw, raw_clean.as_deref(), &report))
        .transpose()?;
    let suggestion = manoeuvre::suggest(robot, &runs, clean.as_ref(), &report)?;
    let file = arguments.profile.as_path();
    let written = suggestion.as_ref().filter(|suggestion| suggestion.knots.is_some());
    if let Some(suggestion) = written {
        suggestion.write(file)?;
    }
    if arguments.json {
        let profile = written.map(|_| file.display().to_string());
        let beside = Beside {
            simulated: simulated.as_ref(),
            suggestion: suggestion.as_ref(),
            profile: profile.as_deref(),
        };
        return super::print_json(&output::json(&report, beside));
    }
    println!("{}", summary::text(&report).trim_end());
    if let Some(simulated) = &simulated {
        println!("{}", simulated.line());
    }
    if let Some(suggestion) = &suggestion {
        println!("{}", suggestion.lines(file).trim_end());
    }
    Ok(())
}
