//! What a fit found, and the image in which the board stores it.
//!
//! Little-endian, all numbers in single precision:
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 4 | magic `GMRC` |
//! | 4 | 2 | format version |
//! | 6 | 2 | length of the image, checksum included |
//! | 8 | 1 | model id: 0 Eq. 18 published, 1 Eq. 18 corrected, 2 signed torque |
//! | 9 | 1 | drive: 0 dissipative, 1 regenerative |
//! | 10 | 1 | wheels N |
//! | 11 | 1 | 1 where the wheels scrub in turns, plus 2 where the mass cannot be told ([`Coefficients::identifies_mass`]), plus 4 where the ground adapts, plus 8 where the usual residual is told |
//! | 12 | 24 | robot name, UTF-8, padded with zeros |
//! | 36 | 24 | gyration radius, dead band, filter cutoff, mass without and with full load, static power |
//! | 60 | 16 | noise: density, lasting error, usual residual (ignored without its flag: once a weight), tail |
//! | 76 | 60 | 15 coefficients, or the torque model's 7 and zeros |
//! | 136 | 12 N | R, rows vx, vy, ω |
//! | 136 + 12 N | 4 | CRC-32 (ISO-HDLC) of all before |
//!
//! That is version 1. With effects ([`crate::effects::Columns`]) it is version 2, in which these
//! stand before the checksum:
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 136 + 12 N | 1 | columns E, 1 … 4 |
//! | 137 + 12 N | 3 | 0 |
//! | 140 + 12 N | 10 E | a column each: id, which, coefficient, shape |
//!
//! Where a torque model says more of the sides, of slip or of the delay ([`Conditioning`]), it is
//! version 3: after its 7 values stand these instead of zeros, and columns as in version 2, of
//! which there may be none.
//!
//! | offset | what |
//! |---|---|
//! | 104 | imbalance of the sides, N·m |
//! | 108, 112 | slip memory: slip at 1/√2 of the scrub, relaxation in rad of the wheel |
//! | 116 | delay of the power after the speeds, s |
//! | 120 | loss of the gear by what passes it |
//! | 124 | slip memory: difference of the sides that is hardly a turn, rad/s; 0 for the dead band |
//! | 128 | drop of the bridge over the motor's constant, rad/s |
//! | 132 | share of the friction that passes the gear, 0 to 1; 0 without a loss of the gear |
//!
//! Firmware from before the last four takes an image in which they are 0, and refuses others.
//!
//! A column's id and "which" are a byte each, its coefficient and shape in single precision. Ids
//! never change their meaning; "which" and shape are 0 where nothing is said of them:
//!
//! | id | what is multiplied | which, shape |
//! |---|---|---|
//! | 1, 2, 3 | slope by pitch, ahead, in the world | 3: which 0 along the heading at the start, 1 across |
//! | 4, 5, 6 | winding loss: throughout, by heat, by temperature | 5: time constant, s; 6: cold, °C |
//! | 7, 8, 9 | windage, Stribeck, viscous | 8: speed, rad/s |
//! | 10 | viscous, falling with time | time constant, s |
//! | 11, 12 | rolling resistance, from a time on | 12: time, s |
//! | 13, 14 | load off centre, drag of one wheel | 14: which wheel, from 0 |
//! | 15, 16, 17 | scrub, scrub per kilogram, gear loss by load | |
//! | 18, 19 | supply's sag, share of braking power that returns | |
//! | 20, 21 | power sensor's gain, offset | |
//! | 22 | static power from a time on | time, s |
//! | 23 | static power with motion, and so long after | time, s; which 1: for ever |
//! | 24 | static power by a driver | |
//! | 25, 26 | delay of the power, scale of speeds | 26: which 0 both sides, 1 left, 2 right |
//! | 27, 28 | gear loss in proportion to the torque, scrub per kilogram that shares its grip with rolling | 28: half slip |

use crc::{CRC_32_ISO_HDLC, Crc};

use crate::conditioning::Conditioning;
use crate::effects::{Cause, Column, Columns, Encoded, MOST_COLUMNS, Term};
use crate::eq18::{Gate, REGRESSORS};
use crate::kinematics::{Kinematics, MassMatrix};
use crate::model::{MassRange, Model};
use crate::payload::Noise;
use crate::payload::window::Window;
use crate::real::Real;
use crate::slip::SlipMemory;
use crate::torque::{Drive, PARAMETERS, TorqueModel};

/// Longest robot name in bytes.
pub const NAME_BYTES: usize = 24;

/// Version of the layout of images without effects.
pub const VERSION: u16 = 1;

/// Version of the layout of images with effects.
pub const VERSION_WITH_EFFECTS: u16 = 2;

/// Version of the layout of images whose torque model has traits.
pub const VERSION_WITH_TRAITS: u16 = 3;

/// Most wheels that an image can hold.
pub const MOST_WHEELS: usize = 6;

/// Bytes of the longest image.
pub const LONGEST_IMAGE: usize = HEAD + 12 * MOST_WHEELS + COLUMNS_HEAD + COLUMN * MOST_COLUMNS + 4;

const MAGIC: [u8; 4] = *b"GMRC";
const HEAD: usize = 136;
/// Number of columns, and zeros.
const COLUMNS_HEAD: usize = 4;
const COLUMN: usize = 10;
/// Bits of byte 11. Firmware that does not know one refuses the image.
const SCRUBS: u8 = 1;
const NO_MASS: u8 = 2;
/// Flag: rolling resistance and scrub adapt.
const ADAPTS: u8 = 4;
/// Flag: the noise's third number is [`Noise::residual_std`].
const RESIDUAL: u8 = 8;
/// Further numbers of a torque model, after its values.
const TRAITS: usize = REGRESSORS - PARAMETERS;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A robot's name, cut to [`NAME_BYTES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Name([u8; NAME_BYTES]);

impl Name {
    /// Cut to [`NAME_BYTES`] at a character's end.
    pub fn new(name: &str) -> Self {
        let mut bytes = [0; NAME_BYTES];
        let mut rest = &mut bytes[..];
        for character in name.chars() {
            let mut buffer = [0; 4];
            let encoded = character.encode_utf8(&mut buffer).as_bytes();
            let Some((head, tail)) = rest.split_at_mut_checked(encoded.len()) else { break };
            head.copy_from_slice(encoded);
            rest = tail;
        }
        Self(bytes)
    }

    /// One that is known at compile time; empty where it is longer than [`NAME_BYTES`].
    pub const fn literal(name: &'static str) -> Self {
        let mut bytes = [0; NAME_BYTES];
        if let Some((head, _)) = bytes.split_at_mut_checked(name.len()) {
            head.copy_from_slice(name.as_bytes());
        }
        Self(bytes)
    }

    /// As stored. `None` unless they are UTF-8, padded with zeros.
    pub fn from_bytes(bytes: [u8; NAME_BYTES]) -> Option<Self> {
        let padded = Self(bytes);
        (Self::new(padded.as_str()) == padded).then_some(padded)
    }

    /// UTF-8, padded with zeros.
    pub fn as_bytes(&self) -> &[u8; NAME_BYTES] {
        &self.0
    }

    /// Without the padding; empty where the bytes are no UTF-8.
    pub fn as_str(&self) -> &str {
        let length = self.0.iter().position(|byte| *byte == 0).unwrap_or(NAME_BYTES);
        self.0.get(..length).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("")
    }
}

/// The robot that the coefficients are for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Robot<T, const N: usize> {
    /// Its name.
    pub name: Name,
    /// R.
    pub kinematics: Kinematics<T, N>,
    /// k, m.
    pub gyration_radius: T,
    /// M'' for both, m².
    pub mass_matrix: MassMatrix<T, N>,
    /// Wheels slower than this are at rest, rad/s.
    pub dead_band: T,
    /// Low-pass cutoff for speed and power, Hz.
    pub cutoff_hz: T,
    /// What else lies between samples and motion.
    pub conditioning: Conditioning<T>,
    /// Total masses without and with full payload, kg.
    pub range: MassRange<T>,
    /// What the robot draws apart from its drives, W; 0 where actuation power is measured on its
    /// own.
    pub static_power: T,
}

impl<T: Real, const N: usize> Robot<T, N> {
    /// Whether turns drag its wheels: by its kind of steering, or because a fit has found that
    /// scrub builds up.
    pub fn scrubs(&self) -> bool {
        self.kinematics.scrubs() || !self.conditioning.slip.is_off() || self.conditioning.true_slip != T::ZERO
    }

    /// The same robot in another precision.
    pub fn convert<U: Real>(&self) -> Option<Robot<U, N>> {
        let number = |value: T| U::from_f64(value.to_f64());
        let rows = self.kinematics.rows().map(|row| row.map(number));
        let kinematics = Kinematics::from_rows(rows).ok()?.with_scrub(self.kinematics.scrubs());
        let gyration_radius = number(self.gyration_radius);
        Some(Robot {
            name: self.name,
            kinematics,
            gyration_radius,
            mass_matrix: kinematics.mass_matrix(gyration_radius).ok()?,
            dead_band: number(self.dead_band),
            cutoff_hz: number(self.cutoff_hz),
            conditioning: self.conditioning.convert(),
            range: MassRange::new(number(self.range.no_load()), number(self.range.full_load()))?,
            static_power: number(self.static_power),
        })
    }
}

/// A fitted model with all that running it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients<T, const N: usize> {
    /// Geometry and conditioning.
    pub robot: Robot<T, N>,
    /// The model.
    pub model: Model<T>,
    /// Its residuals.
    pub noise: Noise<T>,
    /// Effects that it lacks.
    pub columns: Columns<T>,
    /// Whether the fit saw what tells one mass from another. Where it saw one payload or one speed
    /// only, estimates of the mass are unknown, whatever the samples say.
    pub identifies_mass: bool,
    /// Whether rolling resistance and scrub are to adapt on the way ([`crate::adapt`]): of the
    /// signed model without effects only.
    pub ground_adapts: bool,
}

/// Why bytes are no coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecodeError {
    /// Fewer bytes than the image says, or than any image has.
    Truncated,
    /// They do not begin with `GMRC`.
    NotAnImage,
    /// Another layout.
    Version {
        /// The version of the image.
        version: u16,
    },
    /// The checksum does not match: a bit has flipped.
    Checksum,
    /// The model id is none of those known.
    UnknownModel {
        /// The id in the image.
        id: u8,
    },
    /// An effect that this version does not know.
    UnknownEffect {
        /// The id in the image.
        id: u8,
    },
    /// For a robot with another number of wheels.
    WheelCount {
        /// How many the image has.
        count: u8,
    },
    /// A field holds what it cannot; its name.
    Field(&'static str),
}

/// An encoded image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Image {
    bytes: [u8; LONGEST_IMAGE],
    length: usize,
}

impl Image {
    /// The image's bytes.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }

    fn put(&mut self, bytes: &[u8]) {
        let end = self.length + bytes.len();
        if let Some(place) = self.bytes.get_mut(self.length..end) {
            place.copy_from_slice(bytes);
            self.length = end;
        }
    }

    fn put_number<T: Real>(&mut self, value: T) {
        self.put(&(value.to_f64() as f32).to_le_bytes());
    }
}

/// Reads fields one after the other.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const L: usize>(&mut self) -> Result<[u8; L], DecodeError> {
        let (head, tail) = self.0.split_first_chunk::<L>().ok_or(DecodeError::Truncated)?;
        self.0 = tail;
        Ok(*head)
    }

    fn half_word(&mut self) -> Result<u16, DecodeError> {
        self.take().map(u16::from_le_bytes)
    }

    fn number<T: Real>(&mut self, field: &'static str) -> Result<T, DecodeError> {
        let value = f32::from_le_bytes(self.take()?);
        if value.is_finite() { Ok(T::from_f64(f64::from(value))) } else { Err(DecodeError::Field(field)) }
    }

    fn not_negative<T: Real>(&mut self, field: &'static str) -> Result<T, DecodeError> {
        let value: T = self.number(field)?;
        if value >= T::ZERO { Ok(value) } else { Err(DecodeError::Field(field)) }
    }

    /// The effects of a robot with so many wheels, in an image of this length.
    fn columns<T: Real>(
        &mut self,
        version: u16,
        wheels: usize,
        length: usize,
    ) -> Result<Columns<T>, DecodeError> {
        let wrong = DecodeError::Field("effects");
        let [count, zeros @ ..] = self.take::<COLUMNS_HEAD>()?;
        let count = usize::from(count);
        let fewest = if version == VERSION_WITH_EFFECTS { 1 } else { 0 };
        if !(fewest..=MOST_COLUMNS).contains(&count) || zeros != [0; COLUMNS_HEAD - 1] {
            return Err(wrong);
        }
        if length != length_of(version, wheels, count) {
            return Err(DecodeError::Truncated);
        }
        let mut list = [Column { cause: Cause::Hot, coefficient: T::ZERO }; MOST_COLUMNS];
        for place in list.iter_mut().take(count) {
            let [id, which] = self.take()?;
            let coefficient = self.number("effects")?;
            let shape: f32 = self.number("effects")?;
            let cause = Cause::decode(Encoded { id, which, shape });
            let cause = cause.ok_or(DecodeError::UnknownEffect { id })?;
            *place = Column { cause, coefficient };
        }
        Columns::new(list.get(..count).unwrap_or(&[]), wheels).map_err(|_| wrong)
    }
}

const fn length_of(version: u16, wheels: usize, columns: usize) -> usize {
    let head = if version == VERSION { 0 } else { COLUMNS_HEAD };
    HEAD + 12 * wheels + head + COLUMN * columns + 4
}

impl<T: Real, const N: usize> Coefficients<T, N> {
    /// The estimator of the mass by them, for samples `period` (s) apart.
    pub fn window(&self, period: T) -> Window<T> {
        let (range, noise) = (self.robot.range, self.noise);
        Window { range, noise, period, linear_beyond: noise.linear_beyond(self.robot.cutoff_hz) }
    }

    /// The least power that counts as energy, W: 0, by Eq. 9, where braking power is burnt or the
    /// model (Eq. 18) knows of none; −∞ where it returns to the supply, by the drives or by an
    /// effect.
    pub fn energy_floor(&self) -> T {
        let returns = |column: &Column<T>| {
            matches!(column.cause, Cause::Term(Term::Return)) && column.coefficient > T::ZERO
        };
        let regenerative = matches!(self.model, Model::Signed { drive: Drive::Regenerative, .. });
        if regenerative || self.columns.iter().any(returns) { -T::INFINITY } else { T::ZERO }
    }

    /// The image, in single precision. `None` for more than [`MOST_WHEELS`] wheels, for what has no
    /// model id (ungated products with coefficients of their own), for effects and traits of
    /// another model than the signed one, and for true slip, which needs a gyro. Of the versions
    /// that have room for all it is the first: older firmware takes it.
    pub fn encode(&self) -> Option<Image> {
        let columns = self.columns.len();
        let traits = self.traits();
        // As single precision has them.
        let has_traits = traits.iter().any(|value| value.to_f64() as f32 != 0.0);
        let is_signed = matches!(self.model, Model::Signed { .. });
        if N > MOST_WHEELS
            || !(is_signed || columns == 0 && !has_traits)
            || (self.ground_adapts && !(is_signed && columns == 0))
            || self.robot.conditioning.true_slip != T::ZERO
        {
            return None;
        }
        let version = match (has_traits, columns) {
            (false, 0) => VERSION,
            (false, _) => VERSION_WITH_EFFECTS,
            (true, _) => VERSION_WITH_TRAITS,
        };
        let length = length_of(version, N, columns);
        let (model, drive, values) = match &self.model {
            Model::Eq18 { gate: Gate::Published, beta } => (0, 0, *beta),
            Model::Eq18 { gate: Gate::Corrected, beta } => (1, 0, *beta),
            Model::Eq18 { gate: Gate::Signed, .. } => return None,
            Model::Signed { torque, drive } => {
                let mut values = [T::ZERO; REGRESSORS];
                for (place, value) in values.iter_mut().zip(torque.to_array().into_iter().chain(traits)) {
                    *place = value;
                }
                (2, u8::from(*drive == Drive::Regenerative), values)
            }
        };
        // As single precision has it.
        let residual_std =
            if self.noise.residual_std.to_f64() as f32 > 0.0 { self.noise.residual_std } else { T::ZERO };
        let mut image = Image { bytes: [0; LONGEST_IMAGE], length: 0 };
        image.put(&MAGIC);
        image.put(&version.to_le_bytes());
        image.put(&(length as u16).to_le_bytes());
        let flags = if self.robot.kinematics.scrubs() { SCRUBS } else { 0 }
            | if self.identifies_mass { 0 } else { NO_MASS }
            | if self.ground_adapts { ADAPTS } else { 0 }
            | if residual_std == T::ZERO { 0 } else { RESIDUAL };
        image.put(&[model, drive, N as u8, flags]);
        let robot = &self.robot;
        image.put(&robot.name.0);
        for value in [
            robot.gyration_radius,
            robot.dead_band,
            robot.cutoff_hz,
            robot.range.no_load(),
            robot.range.full_load(),
            robot.static_power,
            self.noise.density,
            self.noise.model_std,
            residual_std,
            self.noise.tail,
        ] {
            image.put_number(value);
        }
        for value in values {
            image.put_number(value);
        }
        for value in robot.kinematics.rows().iter().flatten() {
            image.put_number(*value);
        }
        if version != VERSION {
            image.put(&[columns as u8, 0, 0, 0]);
        }
        for column in self.columns.iter() {
            let Encoded { id, which, shape } = column.cause.encode()?;
            image.put(&[id, which]);
            image.put_number(column.coefficient);
            image.put(&shape.to_le_bytes());
        }
        let checksum = CRC.checksum(image.as_bytes());
        image.put(&checksum.to_le_bytes());
        Some(image)
    }

    /// What version 3 has beyond the first, in its order.
    fn traits(&self) -> [T; TRAITS] {
        let Conditioning { slip, delay, .. } = self.robot.conditioning;
        let TorqueModel { imbalance, gear_loss, bridge_drop, wheel_friction_share, .. } = match &self.model {
            Model::Signed { torque, .. } => *torque,
            Model::Eq18 { .. } => TorqueModel::default(),
        };
        let has_loss = gear_loss.to_f64() as f32 != 0.0;
        let share = if has_loss { wheel_friction_share } else { T::ZERO };
        [imbalance, slip.half_slip, slip.relaxation, delay, gear_loss, slip.rest, bridge_drop, share]
    }

    /// Reads an image back.
    ///
    /// # Errors
    /// The first thing that is wrong with it. Bytes after the image's length are ignored: flash is
    /// longer.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let mut reader = Reader(bytes);
        if reader.take::<4>()? != MAGIC {
            return Err(DecodeError::NotAnImage);
        }
        let version = reader.half_word()?;
        if !(VERSION..=VERSION_WITH_TRAITS).contains(&version) {
            return Err(DecodeError::Version { version });
        }
        let length = usize::from(reader.half_word()?);
        let body_length = length.checked_sub(4).ok_or(DecodeError::Truncated)?;
        let (body, rest) = bytes.split_at_checked(body_length).ok_or(DecodeError::Truncated)?;
        let checksum = Reader(rest).take().map(u32::from_le_bytes)?;
        if CRC.checksum(body) != checksum {
            return Err(DecodeError::Checksum);
        }
        let [model, drive, wheels, flags] = reader.take::<4>()?;
        if usize::from(wheels) != N {
            return Err(DecodeError::WheelCount { count: wheels });
        }
        if version == VERSION && length != length_of(version, N, 0) {
            return Err(DecodeError::Truncated);
        }
        let name = Name(reader.take()?);
        let gyration_radius = reader.number("gyration_radius_m")?;
        let dead_band = reader.not_negative("speed_dead_band_rad_s")?;
        let cutoff_hz: T = reader.number("filter_cutoff_hz")?;
        if cutoff_hz <= T::ZERO {
            return Err(DecodeError::Field("filter_cutoff_hz"));
        }
        let (no_load, full_load) = (reader.number("mass_no_load_kg")?, reader.number("mass_full_load_kg")?);
        let range = MassRange::new(no_load, full_load).ok_or(DecodeError::Field("mass_no_load_kg"))?;
        let static_power = reader.number("static_power_w")?;
        let density = reader.not_negative("noise")?;
        let model_std = reader.not_negative("noise")?;
        let residual_std: T = reader.not_negative("noise")?;
        let has_residual = flags & RESIDUAL != 0;
        if has_residual && residual_std == T::ZERO {
            return Err(DecodeError::Field("noise"));
        }
        let residual_std = if has_residual { residual_std } else { T::ZERO };
        let tail = reader.not_negative("noise")?;
        let mut values = [T::ZERO; REGRESSORS];
        for value in &mut values {
            *value = reader.number("coefficients")?;
        }
        let mut traits = [T::ZERO; TRAITS];
        let model = match model {
            0 => Model::Eq18 { gate: Gate::Published, beta: values },
            1 => Model::Eq18 { gate: Gate::Corrected, beta: values },
            2 => {
                let mut parameters = [T::ZERO; PARAMETERS];
                let mut all = values.into_iter();
                for (place, value) in parameters.iter_mut().zip(&mut all) {
                    *place = value;
                }
                if version == VERSION_WITH_TRAITS {
                    for (place, value) in traits.iter_mut().zip(all) {
                        *place = value;
                    }
                }
                let drive = match drive {
                    0 => Drive::Dissipative,
                    1 => Drive::Regenerative,
                    _ => return Err(DecodeError::Field("drive")),
                };
                let [imbalance, _, _, _, gear_loss, _, bridge_drop, wheel_friction_share] = traits;
                let shared = TorqueModel::from_array(parameters);
                let torque =
                    TorqueModel { imbalance, gear_loss, bridge_drop, wheel_friction_share, ..shared };
                Model::Signed { torque, drive }
            }
            id => return Err(DecodeError::UnknownModel { id }),
        };
        let [_, half_slip, relaxation, delay, gear_loss, rest, _, wheel_friction_share] = traits;
        let slip = SlipMemory { half_slip, relaxation, rest };
        let conditioning = Conditioning { slip, delay, true_slip: T::ZERO };
        // One image for the same coefficients: without traits it is of an older version, and a gear
        // without a loss says nothing of friction.
        let has_traits = version != VERSION_WITH_TRAITS || traits.iter().any(|value| *value != T::ZERO);
        let is_canonical = has_traits && (wheel_friction_share == T::ZERO || gear_loss != T::ZERO);
        if !(model.is_sound() && conditioning.is_sound() && is_canonical) {
            return Err(DecodeError::Field("coefficients"));
        }
        let mut rows = [[T::ZERO; N]; 3];
        for value in rows.iter_mut().flatten() {
            *value = reader.number("kinematics")?;
        }
        let kinematics = Kinematics::from_rows(rows)
            .map_err(|_| DecodeError::Field("kinematics"))?
            .with_scrub(flags & SCRUBS != 0);
        if flags & !(SCRUBS | NO_MASS | ADAPTS | RESIDUAL) != 0 {
            return Err(DecodeError::Field("kinematics"));
        }
        let mass_matrix =
            kinematics.mass_matrix(gyration_radius).map_err(|_| DecodeError::Field("gyration_radius_m"))?;
        let columns = if version == VERSION {
            Columns::NONE
        } else {
            if !matches!(model, Model::Signed { .. }) {
                return Err(DecodeError::Field("effects"));
            }
            reader.columns(version, N, length)?
        };
        let ground_adapts = flags & ADAPTS != 0;
        if ground_adapts && !(matches!(model, Model::Signed { .. }) && columns.is_empty()) {
            return Err(DecodeError::Field("ground"));
        }
        Ok(Self {
            robot: Robot {
                name,
                kinematics,
                gyration_radius,
                mass_matrix,
                dead_band,
                cutoff_hz,
                conditioning,
                range,
                static_power,
            },
            model,
            noise: Noise { density, model_std, tail, residual_std },
            columns,
            identifies_mass: flags & NO_MASS == 0,
            ground_adapts,
        })
    }

    /// The same coefficients in another precision.
    pub fn convert<U: Real>(&self) -> Option<Coefficients<U, N>> {
        let number = |value: T| U::from_f64(value.to_f64());
        let model = match &self.model {
            Model::Eq18 { gate, beta } => Model::Eq18 { gate: *gate, beta: beta.map(number) },
            Model::Signed { torque, drive } => Model::Signed { torque: torque.convert(), drive: *drive },
        };
        Some(Coefficients {
            robot: self.robot.convert()?,
            model,
            noise: Noise {
                density: number(self.noise.density),
                model_std: number(self.noise.model_std),
                tail: number(self.noise.tail),
                residual_std: number(self.noise.residual_std),
            },
            columns: self.columns.convert(),
            identifies_mass: self.identifies_mass,
            ground_adapts: self.ground_adapts,
        })
    }
}
