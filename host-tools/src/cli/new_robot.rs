//! `gmr new-robot`: a robot.toml from flags, or from answers to questions.

use std::fmt::Write as _;
use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::path::PathBuf;

use logs::robot::{MassUnit, Robot};
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
    /// differential or skid-steer, two log columns: left and right; other layouts are in docs/robot-toml.md
    #[arg(long, value_parser = ["differential", "skid-steer"])]
    kinematics: Option<String>,
    /// Radius of the driven wheels: 0.033, 33mm, 1.3in
    #[arg(long, value_parser = length, value_name = "M")]
    wheel_radius: Option<f64>,
    /// Distance of the left and right wheels: 0.16, 160mm; for skid-steer the effective one, 1.5 to
    /// 2 times that
    #[arg(long, value_parser = length, value_name = "M")]
    track: Option<f64>,
    /// Total mass without payload: 1.0, 1000g, 2.2lb
    #[arg(long, value_parser = mass, value_name = "KG")]
    empty: Option<f64>,
    /// Total mass with the greatest payload: 6.0, 6000g
    #[arg(long, value_parser = mass, value_name = "KG")]
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
    let words = |flag: &str, question: &str, given: &Option<String>, allowed: &[&str]| match given {
        Some(given) => Ok(given.clone()),
        None => ask(flag, question, |answer| {
            let is_allowed = allowed.is_empty() || allowed.contains(&answer);
            if is_allowed { Ok(answer.to_owned()) } else { Err(format!("expected {}", allowed.join(" or "))) }
        }),
    };
    let number = |flag: &str, question: &str, given: Option<f64>, parse: fn(&str) -> Parsed| match given {
        Some(given) => Ok(given),
        None => ask(flag, question, parse),
    };
    let name = words("name", "Name", &arguments.name, &[])?;
    let kinds = ["differential", "skid-steer"];
    let question = "Kinematics (differential or skid-steer)";
    let kinematics = words("kinematics", question, &arguments.kinematics, &kinds)?;
    let radius = "Radius of the driven wheels (0.033, 33 mm)";
    let track = "Distance of left and right wheels (0.16, 160 mm)";
    let empty = number("empty", "Total mass without payload (1.0, 1000 g)", arguments.empty, mass)?;
    let full = match arguments.full {
        Some(full) => full,
        None => ask("full", "Total mass with the greatest payload (6.0, 6 kg)", |answer| {
            let full = mass(answer)?;
            if full > empty { Ok(full) } else { Err(format!("expected more than the {empty} kg without")) }
        })?,
    };
    let lengths = [
        ("wheel_radius_m", number("wheel-radius", radius, arguments.wheel_radius, length)?),
        ("track_m", number("track", track, arguments.track, length)?),
        ("mass_no_load_kg", empty),
        ("mass_full_load_kg", full),
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

/// A number, or why it is none.
type Parsed = std::result::Result<f64, String>;

/// A length in m, from a number with a unit or without.
fn length(text: &str) -> Parsed {
    measured(text, &[("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254)])
}

/// A mass in kg, from a number with a unit or without.
fn mass(text: &str) -> Parsed {
    measured(text, &[("kg", 1.0), ("g", 1e-3), ("lb", MassUnit::Pound.in_kg())])
}

/// A number above 0 in one of these units; without one it is in SI.
fn measured(text: &str, units: &[(&str, f64)]) -> Parsed {
    let text = text.trim();
    let digits = text.trim_end_matches(|letter: char| letter.is_alphabetic());
    let unit = &text[digits.len()..];
    let scale = if unit.is_empty() {
        Some(1.0)
    } else {
        units.iter().find(|(name, _)| *name == unit).map(|(_, scale)| *scale)
    };
    let value = digits.trim_end().parse::<f64>().ok().filter(|value| *value > 0.0 && value.is_finite());
    match (value, scale) {
        // In decimal, as people wrote it: 33 mm are 0.033 m.
        (Some(value), Some(scale)) => Ok((value * scale * 1e9).round() / 1e9),
        _ => {
            let names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
            Err(format!("expected a number above 0, with {} or no unit", names.join(", ")))
        }
    }
}

/// Asks on a terminal until the answer is one; elsewhere the flag is missing.
fn ask<T>(flag: &str, question: &str, parse: impl Fn(&str) -> std::result::Result<T, String>) -> Result<T> {
    let missing = || Error::usage(format!("--{flag} is missing; expected it, or a terminal to ask on"));
    if !std::io::stdin().is_terminal() {
        return Err(missing());
    }
    loop {
        eprint(question);
        let mut line = String::new();
        let read = std::io::stdin().lock().read_line(&mut line);
        let answer = match read {
            Ok(count) if count > 0 => line.trim(),
            _ => return Err(missing()),
        };
        match parse(answer) {
            _ if answer.is_empty() => {}
            Ok(value) => return Ok(value),
            Err(why) => eprintln!("{answer:?}: {why}"),
        }
    }
}

fn eprint(question: &str) {
    let mut to = std::io::stderr().lock();
    // Nobody there to read it is nobody to answer.
    let _ = write!(to, "{question}: ");
    let _ = to.flush();
}
