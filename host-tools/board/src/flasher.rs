//! What a board keeps: checked as the board checks it, stored, read back and compared.

use std::path::Path;
use std::time::Duration;

use firmware::control_table::{self as table, Item, Reason, UploadState};
use firmware::items::{Calibration, RobotIdentity, SIGNATURE_BYTES, check_coefficients, checksum, parts};
use firmware::power_sensors::RAIL_COUNT;
use firmware::wheels::WHEELS;
use logs::robot::Robot;
use model::coefficients::{CoefficientsFile, GROUND_NEEDS, Taking};
use model::effects::written::id_of;
use model_core::coefficients::{Coefficients, Image};
use model_core::effects::Cause;
use model_core::eq18::Gate;
use model_core::model::Model;
use support::context::Context;
use support::error::{Error, Result};

use super::client::{Board, Client};
use super::rail_names;
use super::store_image::StoreImage;
use super::transport::Transport;

/// Samples per second of a board that cannot be asked.
pub const USUAL_RATE_HZ: u16 = 200;
/// How often a waiting upload is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Erasing and writing the store takes less, even where both sectors are erased.
const WRITTEN_WITHIN: Duration = Duration::from_secs(5);
/// A board takes new coefficients into use within a sample or two.
const IN_USE_WITHIN: Duration = Duration::from_secs(2);
/// Filter cutoff of a robot that is asked only for what it is, Hz.
const ANY_CUTOFF_HZ: f64 = 1.0;

/// Where a board's items are kept: the board, running, or an image of its store.
pub trait Target {
    /// An item; empty when there is none.
    ///
    /// # Errors
    /// The target cannot be read.
    fn stored(&mut self, item: Item) -> Result<Vec<u8>>;

    /// Stores an item, reads it back and compares.
    ///
    /// # Errors
    /// It is refused, not stored in time, or not what was read back.
    fn put(&mut self, item: Item, bytes: &[u8]) -> Result<()>;

    /// Takes the coefficients before those stored into use again, as [`put`](Self::put) would;
    /// gives them.
    ///
    /// # Errors
    /// There are none, and as [`put`](Self::put).
    fn roll_back(&mut self) -> Result<Vec<u8>>;

    /// Samples per second.
    fn sample_rate_hz(&self) -> u16;
}

impl Target for StoreImage {
    fn stored(&mut self, item: Item) -> Result<Vec<u8>> {
        Self::stored(self, item)
    }

    fn put(&mut self, item: Item, bytes: &[u8]) -> Result<()> {
        Self::put(self, item, bytes)?;
        compare(item, bytes, &Self::stored(self, item)?)
    }

    fn roll_back(&mut self) -> Result<Vec<u8>> {
        let previous = self.previous()?;
        if previous.is_empty() {
            return Err(nothing_before());
        }
        let identity = identity(self)?;
        check_coefficients(parts(&previous).0, &identity, USUAL_RATE_HZ)
            .map_err(|reason| refused(Item::Coefficients, reason as u8))?;
        Target::put(self, Item::Coefficients, &previous)?;
        Ok(previous)
    }

    fn sample_rate_hz(&self) -> u16 {
        USUAL_RATE_HZ
    }
}

/// A board that runs this project's firmware.
pub struct Running<'a, T> {
    /// Its link.
    pub client: &'a mut Client<T>,
    /// What it said of itself.
    pub board: &'a Board,
    /// How long its wheels may take to stand still, on its clock: it writes its flash only then.
    pub timeout: Duration,
    /// Called while it is waited for, with the time so far.
    pub waiting: &'a mut dyn FnMut(Duration),
}

impl<T: Transport> Target for Running<'_, T> {
    fn stored(&mut self, item: Item) -> Result<Vec<u8>> {
        self.settle()?;
        self.client.set(&table::UPLOAD_ITEM, item as u8)?;
        let block = self.client.block(&table::STORED_LENGTH, &table::STORED_WINDOW)?;
        let length = usize::from(block.get::<u16>(&table::STORED_LENGTH)?);
        let window = block.bytes(&table::STORED_WINDOW)?;
        let bytes = window.get(..length).ok_or_else(|| Error::failed(format!("{length} bytes stored")))?;
        Ok(bytes.to_vec())
    }

    fn put(&mut self, item: Item, bytes: &[u8]) -> Result<()> {
        self.settle()?;
        let (bytes, signature) = match item {
            Item::Coefficients => parts(bytes),
            Item::Calibration | Item::Robot => (bytes, None),
        };
        if item == Item::Coefficients {
            self.sign(signature)?;
        }
        self.client.set(&table::UPLOAD_ITEM, item as u8)?;
        self.client.set(&table::UPLOAD_LENGTH, bytes.len() as u16)?;
        self.client.set_bytes(&table::UPLOAD_WINDOW, bytes)?;
        self.client.set(&table::UPLOAD_COMMAND, STORE)?;
        self.await_stored(item, checksum(bytes))?;
        compare(item, bytes, &self.stored(item)?)?;
        if item == Item::Coefficients { self.await_use(bytes) } else { Ok(()) }
    }

    fn roll_back(&mut self) -> Result<Vec<u8>> {
        self.settle()?;
        let block = self.client.block(&table::PREVIOUS_CRC, &table::PREVIOUS_STATE)?;
        let crc = block.get::<u32>(&table::PREVIOUS_CRC)?;
        match block.get::<u8>(&table::PREVIOUS_STATE)? {
            0 => {}
            empty if empty == Reason::Empty as u8 => return Err(nothing_before()),
            reason => return Err(refused(Item::Coefficients, reason)),
        }
        self.client.set(&table::PREVIOUS_CRC, crc)?;
        self.await_stored(Item::Coefficients, crc)?;
        let previous = self.stored(Item::Coefficients)?;
        if checksum(&previous) != crc {
            return Err(Error::failed("what was read back is not what was there before"));
        }
        self.await_use(&previous)?;
        Ok(previous)
    }

    fn sample_rate_hz(&self) -> u16 {
        self.board.sample_rate_hz
    }
}

/// [`table::UPLOAD_COMMAND`]: check the window and store it.
const STORE: u8 = 1;
/// [`table::UPLOAD_COMMAND`]: forget an upload that waits.
const FORGET: u8 = 2;

impl<T: Transport> Running<'_, T> {
    /// Makes the board forget an upload that somebody left waiting: until then it takes no other.
    fn settle(&mut self) -> Result<()> {
        let begun = self.client.now();
        loop {
            match self.client.set(&table::UPLOAD_COMMAND, FORGET) {
                // It is being written just now.
                Err(_) if self.client.now().saturating_sub(begun) < WRITTEN_WITHIN => {
                    self.client.wait(LOOK_EVERY)?;
                }
                settled => return settled,
            }
        }
    }

    /// Says the signature of the coefficients that follow, or that there is none.
    fn sign(&mut self, signature: Option<&[u8; SIGNATURE_BYTES]>) -> Result<()> {
        if signature.is_none() && self.client.get::<u8>(&table::NEEDS_SIGNATURE)? != 0 {
            return Err(Error::failed(
                "the board takes signed coefficients only; expected --sign with the key that it was built for",
            ));
        }
        self.client.set_bytes(&table::UPLOAD_SIGNATURE, signature.unwrap_or(&[0; SIGNATURE_BYTES]))
    }

    /// Waits until an item that ends with this checksum is stored.
    fn await_stored(&mut self, item: Item, crc: u32) -> Result<()> {
        let begun = self.client.now();
        loop {
            let block = self.client.block(&table::UPLOAD_STATE, &table::UPLOAD_REASON)?;
            match UploadState::from_code(block.get(&table::UPLOAD_STATE)?) {
                Some(UploadState::Stored) => return Ok(()),
                Some(UploadState::Refused) => {
                    return Err(refused(item, block.get(&table::UPLOAD_REASON)?));
                }
                Some(UploadState::Waiting) => {}
                _ => return Err(Error::failed("the board forgot the upload: has it started again?")),
            }
            let waited = self.client.now().saturating_sub(begun);
            if waited >= self.timeout {
                self.settle()?;
                // At the last moment they may have stood still after all.
                if checksum(&self.stored(item)?) == crc {
                    return Ok(());
                }
                let (what, then) = if block.get::<u8>(&table::UPLOAD_REASON)? == Reason::Erase as u8 {
                    (
                        "torque was not off",
                        "the flash erased, which is full (register 149, or start the board again)",
                    )
                } else {
                    ("the wheels did not stand still", "the flash written")
                };
                return Err(Error::failed(format!(
                    "{what} within {} s, and only then is {then}; the board keeps the {} it had",
                    self.timeout.as_secs_f64(),
                    item_text(item)
                )));
            }
            (self.waiting)(waited);
            self.client.wait(LOOK_EVERY)?;
        }
    }

    /// Waits until the board estimates with these coefficients.
    fn await_use(&mut self, image: &[u8]) -> Result<()> {
        let begun = self.client.now();
        loop {
            let block = self.client.block(&table::COEFFICIENTS_STATE, &table::COEFFICIENTS_CRC)?;
            let state = block.get::<u8>(&table::COEFFICIENTS_STATE)?;
            if state == 0 && block.get::<u32>(&table::COEFFICIENTS_CRC)? == checksum(image) {
                return Ok(());
            }
            if self.client.now().saturating_sub(begun) >= IN_USE_WITHIN {
                let why = match Reason::from_code(state) {
                    Some(Reason::None) => "it still uses others",
                    Some(reason) => reason.text(),
                    None => "for a reason that this version does not know",
                };
                return Err(Error::failed(format!(
                    "the board stored the coefficients but does not use them: {why}"
                )));
            }
            self.client.wait(LOOK_EVERY)?;
        }
    }
}

fn nothing_before() -> Error {
    Error::failed("the board holds no coefficients before those that it has")
}

fn refused(item: Item, reason: u8) -> Error {
    let why = Reason::from_code(reason).map_or_else(
        || format!("reason {reason}, which this version does not know"),
        |reason| reason.text().to_owned(),
    );
    let item = item_text(item);
    Error::failed(format!("the board refuses the {item}: {why}; it keeps the {item} it had"))
}

fn compare(item: Item, expected: &[u8], stored: &[u8]) -> Result<()> {
    if expected == stored {
        return Ok(());
    }
    Err(Error::failed(format!("what was read back is not the {} that was written", item_text(item))))
}

/// A model as `gmr fit --model` names it; with a word of the ground where that adapts.
pub fn model_text(coefficients: &Coefficients<f32, WHEELS>) -> &'static str {
    match coefficients.model {
        Model::Eq18 { gate: Gate::Published, .. } => "eq18-published",
        Model::Eq18 { .. } => "eq18",
        Model::Signed { .. } if coefficients.ground_adapts => "signed, ground adapts",
        Model::Signed { .. } => "signed",
    }
}

/// In words.
pub fn item_text(item: Item) -> &'static str {
    match item {
        Item::Coefficients => "coefficients",
        Item::Calibration => "calibration",
        Item::Robot => "robot",
    }
}

/// What is to be stored.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// The robot that the board is to be set up for from now on.
    pub identity: Option<RobotIdentity>,
    /// An image of coefficients, and its signature behind it if it is signed.
    pub coefficients: Option<Vec<u8>>,
    /// True power over measured power of some rails: the others keep theirs.
    pub calibration: Option<[Option<f32>; RAIL_COUNT]>,
}

/// What became of an item.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Outcome {
    /// Which.
    pub item: &'static str,
    /// Bytes of its image.
    pub bytes: usize,
    /// CRC-32 at the image's end.
    pub crc: u32,
    /// Whether a signature went with it.
    pub signed: bool,
    /// Whether it was there already: then nothing was written.
    pub unchanged: bool,
}

/// Checks everything, then stores the items. The robot comes first: the board judges coefficients
/// by it.
///
/// # Errors
/// Something is not for this board (nothing was stored then), or as [`Target::put`].
pub fn flash(target: &mut dyn Target, request: &Request) -> Result<Vec<Outcome>> {
    let now = identity(target)?;
    let after = request.identity.unwrap_or(now);
    let mut images = Vec::new();
    if request.identity.is_some() {
        images.push((Item::Robot, after.encode().to_vec()));
    }
    if let Some(factors) = request.calibration {
        images.push((Item::Calibration, calibration(target, factors)?.encode().to_vec()));
    }
    if let Some(image) = &request.coefficients {
        check_coefficients(parts(image).0, &after, target.sample_rate_hz())
            .map_err(|reason| not_for(reason, image, &after))?;
        images.push((Item::Coefficients, image.clone()));
    }
    let mut outcomes = Vec::new();
    for (item, image) in images {
        let unchanged = target.stored(item)? == image;
        if !unchanged {
            target.put(item, &image)?;
        }
        outcomes.push(outcome(item, &image, unchanged));
    }
    Ok(outcomes)
}

/// Takes the coefficients before those stored into use again.
///
/// # Errors
/// As [`Target::roll_back`].
pub fn roll_back(target: &mut dyn Target) -> Result<Outcome> {
    let image = target.roll_back()?;
    Ok(outcome(Item::Coefficients, &image, false))
}

fn outcome(item: Item, bytes: &[u8], unchanged: bool) -> Outcome {
    let (image, signature) = match item {
        Item::Coefficients => parts(bytes),
        Item::Calibration | Item::Robot => (bytes, None),
    };
    let (bytes, crc, signed) = (image.len(), checksum(image), signature.is_some());
    Outcome { item: item_text(item), bytes, crc, signed, unchanged }
}

/// Why a board with this identity would refuse coefficients.
fn not_for(reason: Reason, image: &[u8], identity: &RobotIdentity) -> Error {
    let theirs = Coefficients::<f32, WHEELS>::decode(image).map(|coefficients| coefficients.robot.name);
    match (reason, theirs) {
        (Reason::Robot, Ok(name)) if name != identity.name => Error::failed(format!(
            "the board is set up for {}, these coefficients are for {}; nothing was stored (--set-robot sets the board up \
             for another robot)",
            identity.name.as_str(),
            name.as_str()
        )),
        (Reason::Robot, _) => Error::failed(format!(
            "the board is set up for a {} of another geometry; nothing was stored (--set-robot sets the board up for this one)",
            identity.name.as_str()
        )),
        _ => Error::failed(format!(
            "the board would refuse the coefficients: {}; nothing was stored",
            reason.text()
        )),
    }
}

/// The robot that a board is set up for.
///
/// # Errors
/// The target cannot be read.
pub fn identity(target: &mut dyn Target) -> Result<RobotIdentity> {
    // As the board does: what it cannot read it does not use.
    Ok(RobotIdentity::decode(&target.stored(Item::Robot)?).unwrap_or_default())
}

/// The calibration that a board has, with these factors in the place of its own.
fn calibration(target: &mut dyn Target, factors: [Option<f32>; RAIL_COUNT]) -> Result<Calibration> {
    let mut calibration = Calibration::decode(&target.stored(Item::Calibration)?).unwrap_or_default();
    for (place, factor) in calibration.power_factors.iter_mut().zip(factors) {
        *place = factor.unwrap_or(*place);
    }
    let image = calibration.encode();
    match Calibration::decode(&image) {
        Ok(calibration) => Ok(calibration),
        Err(reason) => {
            let pairs = rail_names().into_iter().zip(calibration.power_factors);
            let factors: Vec<String> = pairs.map(|(rail, factor)| format!("{rail}={factor}")).collect();
            Err(Error::usage(format!(
                "--calibrate {}: {}; expected true power over measured power, 0.5 to 2",
                factors.join(","),
                reason.text()
            )))
        }
    }
}

/// The image of coefficients for `robot`. Ground adapts, and a fit that cannot be used is taken,
/// only where that is asked for.
///
/// # Errors
/// As [`CoefficientsFile::read`]; the robot has more wheels than the board drives; ground cannot
/// adapt with this model.
pub fn coefficients_image(
    robot: &Robot,
    coefficients: &Path,
    ground_adapts: bool,
    not_usable: Option<&Context>,
) -> Result<Vec<u8>> {
    check_wheels(robot)?;
    let taking = Taking { not_usable, ..Taking::default() };
    let read = CoefficientsFile::read_taking(coefficients, robot, taking)?.coefficients.core();
    if ground_adapts && !(matches!(read.model, Model::Signed { .. }) && read.columns.is_empty()) {
        return Err(Error::failed(GROUND_NEEDS).in_file(coefficients));
    }
    let coefficients_read = Coefficients { ground_adapts, ..read };
    let image = coefficients_read
        .encode()
        .ok_or_else(|| Error::failed("this model is not one that boards have").in_file(coefficients))?;
    let identity = robot_identity(robot)?;
    check_coefficients(image.as_bytes(), &identity, USUAL_RATE_HZ).map_err(|reason| {
        let effects = culprits(reason, &coefficients_read);
        Error::failed(format!("no board would use them: {}{effects}", reason.text())).in_file(coefficients)
    })?;
    Ok(image.as_bytes().to_vec())
}

/// Coefficients that no board would take are not written. Whoever wants the figures of such a fit
/// asks without `--out`.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct NotForBoards(String);

/// Refuses a fit that no board of this robot would take: found out at `gmr flash`, that would be
/// too late. `image` is the fit as a board would hold it, but for true slip; none where boards have
/// no such model.
///
/// # Errors
/// A [`NotForBoards`] as [`Error::cause`].
pub fn check_fitted(context: &Context, robot: &Robot, image: Option<&Image>) -> Result<()> {
    // A robot that no board drives has nothing to ask one for.
    if robot.wheels() != WHEELS {
        return Ok(());
    }
    let refused = |why: &str| {
        let message = format!(
            "not written: no board would take these coefficients ({why}); drive at more speeds, turns and payloads, and look at the logs \
             with gmr inspect"
        );
        Error::of(NotForBoards(message))
    };
    let image = image.ok_or_else(|| refused("boards have no such model"))?;
    match check_coefficients(image.as_bytes(), &robot_identity(robot)?, USUAL_RATE_HZ) {
        // The sample rate limits delay and filter: another board may take them. Without a mass they
        // still predict the power of a drive.
        Err(reason @ (Reason::Delay | Reason::Cutoff | Reason::Slow | Reason::Mass)) => {
            context.notice(format_args!(
                "a board at {USUAL_RATE_HZ} Hz would not take these coefficients: {}",
                reason.text()
            ));
            Ok(())
        }
        Err(reason) => Err(refused(reason.text())),
        Ok(_) => Ok(()),
    }
}

/// The names of the effects for which a board refuses coefficients, if that is the reason.
fn culprits(reason: Reason, coefficients: &Coefficients<f64, WHEELS>) -> String {
    let is_culprit = |cause: &Cause<f64>| match reason {
        Reason::Input => !cause.needs().nothing(),
        Reason::Delay => *cause == Cause::Delay,
        _ => false,
    };
    let effects = coefficients.columns.iter().filter(|column| is_culprit(&column.cause));
    let named: Vec<String> = effects
        .map(|column| match id_of(&column.cause) {
            (id, "") => format!("{id} of {}", column.coefficient),
            (id, needed) => format!("{id} by {needed}"),
        })
        .collect();
    if named.is_empty() { String::new() } else { format!(": {}", named.join(", ")) }
}

/// What the board is told to be built into.
///
/// # Errors
/// The robot has more wheels than the board drives.
pub fn robot_identity(robot: &Robot) -> Result<RobotIdentity> {
    check_wheels(robot)?;
    let core = robot.core::<WHEELS>(ANY_CUTOFF_HZ)?;
    let single = core.convert::<f32>().ok_or_else(|| {
        Error::failed(format!("{} is not a robot in single precision, as boards compute", robot.name()))
    })?;
    Ok(RobotIdentity::of(&single))
}

fn check_wheels(robot: &Robot) -> Result<()> {
    if robot.wheels() == WHEELS {
        return Ok(());
    }
    Err(Error::failed(format!(
        "{} has {} driven wheels; the board drives {WHEELS}",
        robot.name(),
        robot.wheels()
    )))
}
