//! `gmr flash`: coefficients, calibration and robot to a board, checked, read back and compared.

use std::path::{Path, PathBuf};
use std::time::Duration;

use board::flasher::{self, Outcome, Request};
use board::rail_names;
use board::signing::SecretKey;
use board::store_image::StoreImage;
use board::store_task::{Done, Held, HeldCoefficients, Place, Task, carry_out};
use firmware::power_sensors::RAIL_COUNT;
use logs::robot::{FOUND, Robot};
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output::check_apart;
use support::overwrite::Form;

use super::overwrite::OverwriteArgument;

/// Arguments of `gmr flash`.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  gmr flash --robot robot.toml --coeffs coefficients.toml --port /dev/ttyACM1"
)]
#[command(group = clap::ArgGroup::new("target").required(true).multiple(false))]
pub(crate) struct Arguments {
    /// The robot: a robot.toml, or burger; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients as gmr fit writes them
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// The board lets rolling resistance and scrub adapt along the way, with a memory of a minute,
    /// beside the mass: for floors that change. It notices no change of the payload then, and
    /// follows it within a window or two
    #[arg(long, requires = "coeffs")]
    adapt: bool,
    /// To a running board, by its serial port, for example /dev/ttyACM1
    #[arg(long, group = "target")]
    port: Option<PathBuf>,
    /// To a board on a debug probe (SWD)
    #[arg(long, group = "target")]
    probe: bool,
    /// To a board in its chip's bootloader, through dfu-util
    #[arg(long, group = "target")]
    dfu: bool,
    /// To a file for any programmer: the whole store
    #[arg(long, value_name = "FILE.bin|hex", group = "target")]
    out: Option<PathBuf>,
    /// Sign the coefficients with this key, as gmr key new has made it: for boards that ask for it
    #[arg(long, value_name = "FILE", requires = "coeffs")]
    sign: Option<PathBuf>,
    /// True power over measured power of rails, for example battery=1.002,motors=0.998
    #[arg(long, value_name = "RAIL=FACTOR,…", value_delimiter = ',')]
    calibrate: Vec<String>,
    /// Set the board up for this robot: coefficients for another are refused from then on
    #[arg(long)]
    set_robot: bool,
    /// Show what the board holds, and write nothing
    #[arg(long, conflicts_with_all = ["coeffs", "calibrate", "set_robot", "out"])]
    read: bool,
    /// Take the coefficients before those on the board into use again; once more, and the two have
    /// changed places twice
    #[arg(long, conflicts_with_all = ["coeffs", "calibrate", "set_robot", "out", "read"])]
    rollback: bool,
    /// How long the wheels may take to stand still, s: a running board writes its flash only then
    #[arg(long, value_name = "S", default_value_t = 60.0, allow_negative_numbers = true)]
    timeout: f64,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

#[derive(Serialize)]
struct Report<'a> {
    target: &'static str,
    robot: &'a str,
    items: &'a [Outcome],
    verified: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<&'a Path>,
    #[serde(skip_serializing_if = "Option::is_none")]
    address: Option<u32>,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let inputs = [&arguments.robot].into_iter().chain(&arguments.coeffs).chain(&arguments.sign);
    check_apart(arguments.out.as_deref(), inputs.map(PathBuf::as_path))?;
    arguments.overwrite.check(&arguments.out, Form::Store)?;
    let task = match (arguments.read, arguments.rollback) {
        (true, _) => Task::Read,
        (_, true) => Task::RollBack,
        _ => Task::Store(request(context, arguments)?),
    };
    let place = if let Some(port) = &arguments.port {
        let timeout = Duration::try_from_secs_f64(arguments.timeout)
            .map_err(|_| Error::usage(format!("--timeout {}: expected s, 0 or more", arguments.timeout)))?;
        Place::Port(port, timeout)
    } else if let Some(file) = &arguments.out {
        Place::File(file)
    } else if arguments.dfu {
        Place::Dfu
    } else {
        Place::Probe
    };
    match carry_out(place, &task)? {
        Done::Stored { robot, items } => report(arguments, &robot, &items),
        Done::Held(held) => show(&held, arguments.json),
    }
}

/// What is asked for, checked as far as that goes without a board.
fn request(context: &Context, arguments: &Arguments) -> Result<Request> {
    let robot = Robot::load(context, &arguments.robot)?;
    // A file replaces the whole store: it says itself for which robot.
    let sets_robot = arguments.set_robot || arguments.out.is_some();
    let image = |file: &PathBuf| {
        flasher::coefficients_image(
            &robot,
            file,
            arguments.adapt,
            arguments.overwrite.force.then_some(context),
        )
    };
    let mut coefficients = arguments.coeffs.as_ref().map(image).transpose()?;
    if let (Some(image), Some(file)) = (&mut coefficients, &arguments.sign) {
        *image = SecretKey::read(file)?.sign(image);
    }
    let calibration = (!arguments.calibrate.is_empty()).then(|| factors(&arguments.calibrate)).transpose()?;
    let is_nothing = coefficients.is_none() && calibration.is_none() && !arguments.set_robot;
    let identity = sets_robot.then(|| flasher::robot_identity(&robot)).transpose()?;
    if is_nothing {
        return Err(Error::usage(
            "nothing to flash; expected --coeffs, --calibrate, --set-robot, --rollback or --read",
        ));
    }
    Ok(Request { identity, coefficients, calibration })
}

/// `battery=1.002` and so on.
fn factors(texts: &[String]) -> Result<[Option<f32>; RAIL_COUNT]> {
    let mut factors = [None; RAIL_COUNT];
    for text in texts {
        let wrong = || {
            let rails = rail_names().join(", ");
            Error::usage(format!("--calibrate {text}: expected RAIL=FACTOR with a rail of {rails}"))
        };
        let (rail, factor) = text.split_once('=').ok_or_else(wrong)?;
        let place = rail_names().iter().position(|name| *name == rail.trim()).ok_or_else(wrong)?;
        let place = factors.get_mut(place).ok_or_else(wrong)?;
        if place.replace(factor.trim().parse().map_err(|_| wrong())?).is_some() {
            return Err(Error::usage(format!("--calibrate {text}: {rail} is given twice")));
        }
    }
    Ok(factors)
}

fn show(held: &Held, json: bool) -> Result<()> {
    if json {
        return support::output::print_json(held);
    }
    println!("robot: {}", held.robot);
    match &held.coefficients {
        None => println!("coefficients: none"),
        Some(HeldCoefficients { model, robot, effects, crc, refused }) => println!(
            "coefficients: {}{} for {}, CRC {crc:08x}{}",
            model.unwrap_or("unreadable"),
            effects.iter().map(|id| format!(" + {id}")).collect::<String>(),
            robot.as_deref().unwrap_or("no known robot"),
            refused.map_or(String::new(), |why| format!("; not in use: {why}"))
        ),
    }
    for (rail, factor) in &held.calibration {
        println!("calibration of {rail}: {factor}");
    }
    Ok(())
}

fn report(arguments: &Arguments, robot: &str, items: &[Outcome]) -> Result<()> {
    let target = match (&arguments.port, &arguments.out, arguments.dfu) {
        (Some(_), _, _) => "port",
        (_, Some(_), _) => "file",
        (_, _, true) => "dfu",
        _ => "probe",
    };
    let file = arguments.out.as_deref();
    if arguments.json {
        let address = file.map(|_| StoreImage::ADDRESS);
        return support::output::print_json(&Report { target, robot, items, verified: true, file, address });
    }
    for Outcome { item, bytes, crc, signed, unchanged } in items {
        let what = match (unchanged, arguments.rollback) {
            (true, _) => "was there already",
            (_, true) => "in use again, read back",
            _ => "stored, read back and compared",
        };
        let signed = if *signed { ", signed" } else { "" };
        println!("{item} ({robot}): {bytes} bytes, CRC {crc:08x}{signed}: {what}");
    }
    if let Some(file) = file {
        let (address, bytes) = (StoreImage::ADDRESS, StoreImage::BYTES);
        println!("{}: {bytes} bytes, to be written to {address:#010x}", file.display());
    } else if arguments.dfu {
        println!("the board is still in its bootloader: press RESET");
    }
    Ok(())
}
