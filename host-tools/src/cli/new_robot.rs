//! `gmr new-robot`: a robot.toml from flags, or from answers to questions.

use std::fmt::Write as _;
use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::path::PathBuf;

use logs::robot::Robot;
use support::error::{Error, Result};
use support::output;

/// Arguments of `gmr new-robot`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr new-robot                    # asks\n  gmr new-robot --name Rosbot --kinematics skid-steer \
    --wheel-radius 0.0425 --track 0.22 --empty 2.9 --full 12.9 --static-power 7"
)]
pub(crate) struct Arguments {
    /// Its name
    #[arg(long)]
    name: Option<String>,
    /// differential or skid-steer, two log columns: left and right; other layouts are in the README
    #[arg(long, value_parser = ["differential", "skid-steer"])]
    kinematics: Option<String>,
    /// Radius of the driven wheels, m
    #[arg(long, value_name = "M")]
    wheel_radius: Option<f64>,
    /// Distance of the left and right wheels, m; for skid-steer the effective one, 1.5 to 2 times that
    #[arg(long, value_name = "M")]
    track: Option<f64>,
    /// Total mass without payload, kg
    #[arg(long, value_name = "KG")]
    empty: Option<f64>,
    /// Total mass with the greatest payload, kg
    #[arg(long, value_name = "KG")]
    full: Option<f64>,
    /// What it draws standing, W, where logs hold the total power
    #[arg(long, value_name = "W")]
    static_power: Option<f64>,
    /// Greatest speed, m/s
    #[arg(long, value_name = "M_S")]
    max_speed: Option<f64>,
    /// Capacity of the battery, A·h; with --cells
    #[arg(long, value_name = "AH", requires = "cells")]
    capacity: Option<f64>,
    /// Its lithium cells in series
    #[arg(long, requires = "capacity")]
    cells: Option<u32>,
    /// The file to write; one that is there is left alone
    #[arg(long, value_name = "FILE", default_value = "robot.toml")]
    out: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    output::folder_of(&arguments.out)?;
    if arguments.out.exists() {
        let message = "exists already; expected another name with --out";
        return Err(Error::failed(message).in_file(&arguments.out));
    }
    let text = text(arguments)?;
    let robot = Robot::parse(&text).map_err(|error| error.in_file(&arguments.out))?;
    output::write_content(&arguments.out, &text)?;
    println!("{}: {}", arguments.out.display(), robot.name());
    Ok(())
}

fn text(arguments: &Arguments) -> Result<String> {
    let number = |flag: &str, question: &str, given: Option<f64>| -> Result<f64> {
        let answer = given.map_or_else(|| ask(flag, question), |value| Ok(value.to_string()))?;
        let value = answer.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| Error::usage(format!("--{flag} {answer:?}; expected a number")))
    };
    let words = |flag: &str, question: &str, given: &Option<String>| {
        given.clone().map_or_else(|| ask(flag, question), Ok)
    };
    let name = words("name", "Name", &arguments.name)?;
    let kinematics = words("kinematics", "Kinematics (differential or skid-steer)", &arguments.kinematics)?;
    let lengths = [
        ("wheel_radius_m", number("wheel-radius", "Radius of the driven wheels, m", arguments.wheel_radius)?),
        ("track_m", number("track", "Distance of left and right wheels, m", arguments.track)?),
        ("mass_no_load_kg", number("empty", "Total mass without payload, kg", arguments.empty)?),
        ("mass_full_load_kg", number("full", "Total mass with the greatest payload, kg", arguments.full)?),
    ];
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(text, "name = {}", toml::Value::String(name));
    let _ = writeln!(text, "kinematics = {}", toml::Value::String(kinematics));
    for (key, value) in lengths {
        let _ = writeln!(text, "{key} = {value}");
    }
    match arguments.static_power {
        Some(watts) => {
            let _ = writeln!(text, "static_power_w = {watts}");
        }
        None => text.push_str(
            "# static_power_w = 6.4        # where logs hold the total power: gmr inspect finds it\n",
        ),
    }
    if let Some(speed) = arguments.max_speed {
        let _ = writeln!(text, "max_speed_m_s = {speed}");
    }
    if let Some((capacity, cells)) = arguments.capacity.zip(arguments.cells) {
        let _ = write!(text, "\n[battery]\ncapacity_ah = {capacity}\ncells = {cells}\n");
    }
    Ok(text)
}

/// Asks on a terminal; elsewhere the flag is missing.
fn ask(flag: &str, question: &str) -> Result<String> {
    let missing = || Error::usage(format!("--{flag} is missing; expected it, or a terminal to ask on"));
    if !std::io::stdin().is_terminal() {
        return Err(missing());
    }
    eprint(question);
    let mut line = String::new();
    let read = std::io::stdin().lock().read_line(&mut line);
    match read {
        Ok(count) if count > 0 && !line.trim().is_empty() => Ok(line.trim().to_owned()),
        _ => Err(missing()),
    }
}

fn eprint(question: &str) {
    let mut to = std::io::stderr().lock();
    // Nobody there to read it is nobody to answer.
    let _ = write!(to, "{question}: ");
    let _ = to.flush();
}
