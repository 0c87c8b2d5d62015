//! Coefficients, calibration and robot to a board, or what it holds, wherever its store is.

use std::path::Path;
use std::time::Duration;

use firmware::control_table::{Item, Reason};
use firmware::items::{Calibration, check_coefficients, checksum, parts};
use firmware::wheels::WHEELS;
use model::effects::written::id_of;
use model_core::coefficients::Coefficients;
use serde::Serialize;
use support::error::{Error, Result};
use support::printable;
use support::progress::WaitProgress;

use crate::client::Client;
use crate::flasher::{self, Outcome, Request, Running, Target, flash, roll_back};
use crate::serial::Serial;
use crate::store_image::StoreImage;
use crate::{dfu, image_file, probe, rail_names};

/// Where a board's store is.
#[derive(Debug, Clone, Copy)]
pub enum Place<'a> {
    /// On a running board, by its serial port, whose wheels may take so long to stand still.
    Port(&'a Path, Duration),
    /// In a file for any programmer, which is written whole.
    File(&'a Path),
    /// On a board in its chip's bootloader.
    Dfu,
    /// On a board at a debug probe.
    Probe,
}

/// What a command is to do.
#[derive(Debug)]
pub enum Task {
    /// Store what is asked for.
    Store(Request),
    /// Show what is there, and write nothing.
    Read,
    /// Take the coefficients before those on the board into use again.
    RollBack,
}

/// What a command found or did.
#[derive(Debug)]
pub enum Done {
    /// It stored these.
    Stored {
        /// The robot that the board is set up for.
        robot: String,
        /// What was stored, read back and compared.
        items: Vec<Outcome>,
    },
    /// It holds this.
    Held(Held),
}

/// What a board holds.
#[derive(Debug, Serialize)]
pub struct Held {
    /// The robot that it is set up for.
    pub robot: String,
    /// Its coefficients.
    pub coefficients: Option<HeldCoefficients>,
    /// True power over measured power of each rail.
    pub calibration: serde_json::Map<String, serde_json::Value>,
}

/// Coefficients on a board.
#[derive(Debug, Serialize)]
pub struct HeldCoefficients {
    /// Which model; none where they cannot be read.
    pub model: Option<&'static str>,
    /// The robot that they are for.
    pub robot: Option<String>,
    /// Effects beyond the fitted model, by the dictionary's ids.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<&'static str>,
    /// CRC-32 of the image.
    pub crc: u32,
    /// Why the board does not use them, if it does not.
    pub refused: Option<&'static str>,
}

/// Does it.
///
/// # Errors
/// The board, probe, bootloader or file cannot be reached; the board refuses, with its reason; what
/// was read back is not what was written.
pub fn carry_out(place: Place<'_>, task: &Task) -> Result<Done> {
    match place {
        Place::Port(port, timeout) => {
            let at_port = |error: Error| error.in_file(port);
            let (mut client, board) = Client::connect(Serial::open(port)?).map_err(at_port)?;
            let bar = WaitProgress::new("waiting for the wheels to stand still", timeout);
            let waiting = &mut |waited| bar.at(waited);
            let mut target = Running { client: &mut client, board: &board, timeout, waiting };
            work(&mut target, task).map_err(at_port)
        }
        Place::File(file) => on_image(StoreImage::erased(), |image| image_file::write(file, image), task),
        Place::Dfu => on_image(dfu::read()?, dfu::write, task),
        Place::Probe => on_image(probe::read()?, probe::write, task),
    }
}

fn work(target: &mut dyn Target, task: &Task) -> Result<Done> {
    let items = match task {
        Task::Read => return Ok(Done::Held(held(target)?)),
        Task::Store(request) => flash(target, request)?,
        Task::RollBack => vec![roll_back(target)?],
    };
    let robot = printable::name(flasher::identity(target)?.name.as_str());
    Ok(Done::Stored { robot, items })
}

/// Works on a copy of the store, which is written back if anything in it is new.
fn on_image(
    mut image: StoreImage,
    write: impl FnOnce(&StoreImage) -> Result<()>,
    task: &Task,
) -> Result<Done> {
    let done = work(&mut image, task)?;
    if let Done::Stored { items, .. } = &done
        && items.iter().any(|item| !item.unchanged)
    {
        write(&image)?;
    }
    Ok(done)
}

fn held(target: &mut dyn Target) -> Result<Held> {
    let identity = flasher::identity(target)?;
    let image = target.stored(Item::Coefficients)?;
    let image = parts(&image).0;
    let decoded = Coefficients::<f32, WHEELS>::decode(image).ok();
    let coefficients = (!image.is_empty()).then(|| HeldCoefficients {
        model: decoded.as_ref().map(flasher::model_text),
        robot: decoded.map(|coefficients| printable::name(coefficients.robot.name.as_str())),
        effects: decoded.map_or_else(Vec::new, |coefficients| {
            coefficients.columns.iter().map(|column| id_of(&column.cause).0).collect()
        }),
        crc: checksum(image),
        refused: check_coefficients(image, &identity, target.sample_rate_hz()).err().map(Reason::text),
    });
    let calibration = Calibration::decode(&target.stored(Item::Calibration)?).unwrap_or_default();
    let factors = rail_names().into_iter().zip(calibration.power_factors);
    // As many digits as single precision has.
    let decimal = |factor: f32| factor.to_string().parse::<f64>().unwrap_or(f64::from(factor));
    Ok(Held {
        robot: printable::name(identity.name.as_str()),
        coefficients,
        calibration: factors.map(|(rail, factor)| (rail.to_owned(), decimal(factor).into())).collect(),
    })
}
