//! `gmr gap`: where model and measurement disagree, and which effect is missing.

use std::path::PathBuf;

use answers::export::joints::Language;
use gap::likelihood::LEVEL;
use gap::manoeuvre::Wish;
use gap::manoeuvre::room::Room;
use gap::report::{json, summary};
use gap::workflow::{Answer, Request, gap};
use logs::arguments::{Log, UnitArguments, paths};
use logs::robot::FOUND;
use plant::PlantSet;
use support::context::Context;
use support::error::Result;
use support::output;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr gap`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr gap --robot robot.toml --coeffs coefficients.toml --report gap.html --out extended.toml monday/*.csv", after_long_help = format!("{}\n\n{}", "Example:\n  gmr gap --robot robot.toml --coeffs coefficients.toml --report gap.html --out extended.toml monday/*.csv", json::KEYS))]
pub(crate) struct Arguments {
    /// Logs: four runs at least, one or several a file; the total mass behind the name where they
    /// do not hold it
    #[arg(required = true, value_name = "LOG[=KG]")]
    runs: Vec<Log>,
    /// The robot: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml
    /// upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients of an earlier clean fit: what is new since then? Without, base and effects are
    /// fitted together
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// The clean runs that the coefficients were fitted to, if they are no longer where they were:
    /// what the model gets wrong there as well is no effect
    #[arg(long, value_name = "LOG[=KG]", num_args = 1..)]
    base: Vec<Log>,
    /// Logs of your simulator in place of a clean fit: what does the robot have that it lacks?
    /// Columns as in a measured log, the power in power_w or sim_power_w, or the wheels' torques in
    /// sim_torque1_nm and so on. Without this, measured logs that have such sim_ columns are held
    /// against them, row by row
    #[arg(long, value_name = "SIM.csv", num_args = 1.., conflicts_with_all = ["coeffs", "base", "plant"])]
    sim: Vec<Log>,
    /// Write what the simulator's model of the robot needs for what is named: elements, sizes,
    /// intervals
    #[arg(long, value_enum)]
    export: Option<Language>,
    /// Where that is written [default: gap_changes.xml, or .sdf]
    #[arg(long, value_name = "FILE", requires = "export")]
    export_file: Option<PathBuf>,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Effects of your own beside those of the dictionary, as formulas over the logs' columns:
    /// [[effect]] entries with id, formula, unit, sign, range = [least, greatest] and meaning
    #[arg(long, value_name = "MINE.toml")]
    effects: Option<PathBuf>,
    /// Everything that was found, with plots, as one HTML page that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Write the coefficients with the named effects, for gmr estimate, gmr flash and the board
    #[arg(long, value_name = "FILE.toml", requires = "coeffs")]
    out: Option<PathBuf>,
    /// Drive a simulated robot with these motors along the recorded wheel speeds as well:
    /// calibrated on the clean runs, without the named effects and with them
    #[arg(long, value_enum)]
    plant: Option<PlantSet>,
    /// Where the speed profile that parts the rivals of a tie is written
    #[arg(long, value_name = "FILE", default_value = "gap_profile.csv")]
    profile: PathBuf,
    /// On a tie: a drive that parts the rivals with this probability (0.5 to 0.99), and how long
    /// that takes
    #[arg(long = "part", value_name = "PROBABILITY", value_parser = probability)]
    probability: Option<f64>,
    /// On a tie: a drive that stays in a room of this length and width, m
    #[arg(long, value_name = "LENGTHxWIDTH", value_parser = room)]
    room: Option<Room>,
    /// How often a gap may be said of runs that have nothing new, where it has no name or one that
    /// does not stand out: what is seen when other runs are called the field may reach as much in
    /// this share of cases
    #[arg(long, value_name = "SHARE", default_value_t = LEVEL, value_parser = level)]
    level: f64,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let given = arguments.runs.iter().chain(&arguments.base).chain(&arguments.sim);
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, given)?;
    let export_file = arguments.export_file();
    let request = Request {
        robot,
        robot_file: &arguments.robot,
        logs: &paths(&arguments.runs),
        coeffs: arguments.coeffs.as_deref(),
        base: &paths(&arguments.base),
        sim: &paths(&arguments.sim),
        export: arguments.export.zip(export_file.as_deref()),
        mass_kg: arguments.mass.unwrap_or(robot.mass_no_load_kg()),
        effects: arguments.effects.as_deref(),
        report: arguments.report.as_deref(),
        out: arguments.out.as_deref(),
        plant: arguments.plant,
        profile: &arguments.profile,
        wish: Wish { probability: arguments.probability, room: arguments.room },
        force: arguments.overwrite.force,
        level: arguments.level,
    };
    show(&gap(context, &request)?, arguments)
}

/// A share of relabelled sets.
fn level(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number from 0.02 to 0.5")?;
    if (0.02..=0.5).contains(&value) { Ok(value) } else { Err("expected 0.02 to 0.5".to_owned()) }
}

/// A probability that somebody may ask for.
fn probability(text: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number from 0.5 to 0.99")?;
    if (0.5..=0.99).contains(&value) { Ok(value) } else { Err("expected 0.5 to 0.99".to_owned()) }
}

/// `4x3`: a room's sides, m.
fn room(text: &str) -> std::result::Result<Room, String> {
    let expected = || "expected length x width in m, each from 0.1 to 1000, as 4x3".to_owned();
    let (length, width) = text.split_once('x').ok_or_else(expected)?;
    let side = |text: &str| text.trim().parse().ok().filter(|side: &f64| (0.1..=1000.0).contains(side));
    let (length_m, width_m) = side(length).zip(side(width)).ok_or_else(expected)?;
    Ok(Room { length_m, width_m })
}

impl Arguments {
    /// Where what a simulator's model needs is written.
    fn export_file(&self) -> Option<PathBuf> {
        let language = self.export?;
        let default = match language {
            Language::Mjcf => "gap_changes.xml",
            Language::Sdf => "gap_changes.sdf",
        };
        Some(self.export_file.clone().unwrap_or_else(|| PathBuf::from(default)))
    }
}

fn show(answer: &Answer, arguments: &Arguments) -> Result<()> {
    if arguments.json {
        return output::print_json(&answer.json(&arguments.profile));
    }
    println!("{}", summary::text(&answer.report).trim_end());
    if let Some(simulated) = &answer.simulated {
        println!("{}", simulated.line());
    }
    if let Some(told) = &answer.simulator {
        println!("{}", told.line());
    }
    if let Some(file) = arguments.export_file() {
        println!("What its model needs: {}", file.display());
    }
    if let Some(suggestion) = &answer.suggestion {
        println!("{}", suggestion.lines(&arguments.profile).trim_end());
    }
    Ok(())
}
