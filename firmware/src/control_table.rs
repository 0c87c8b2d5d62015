//! The registers of the board as the link shows them: one table for board, host and documentation.
//!
//! Little-endian. Below [`OURS`] stand those of the TurtleBot3's stock firmware, which other
//! software expects; ours begin there. What a register does not know it shows as NaN, or as its
//! state says. Addresses between registers read as 0.

use crate::power_sensors::RAIL_COUNT;
use crate::record::RECORD_BYTES;
use crate::wheels::WHEELS;

/// Version of this table: what [`TABLE_VERSION`] shows.
pub const VERSION: u16 = 5;

/// The board's ID on its link.
pub const BOARD_ID: u8 = 200;

/// What [`MODEL_NUMBER`] shows, as the stock firmware does.
pub const BOARD_MODEL: u16 = 0x5000;

/// Address of the first register of our own.
pub const OURS: u16 = 512;

/// First address beyond the table.
pub const END: u16 = RAIL_IMPLAUSIBLE.end();

/// Most records that the FIFO window shows at once.
pub const FIFO_WINDOW_RECORDS: usize = 16;

/// Bytes of the upload window, and of the stored item that can be read back.
pub const UPLOAD_BYTES: usize = 256;

/// Bytes of a signature: Ed25519.
pub const SIGNATURE_BYTES: usize = 64;

/// Type of a register's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Also flags, codes and raw bytes.
    U8,
    /// Unsigned, two bytes.
    U16,
    /// Unsigned, four bytes.
    U32,
    /// Unsigned, eight bytes.
    U64,
    /// Signed, four bytes.
    I32,
    /// Single precision.
    F32,
}

impl Kind {
    /// Bytes of one value.
    #[must_use]
    pub const fn size(self) -> u16 {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 => 8,
        }
    }

    /// As the documentation writes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::U32 => "u32",
            Self::U64 => "u64",
            Self::I32 => "i32",
            Self::F32 => "f32",
        }
    }
}

/// Who may change a register.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The board only.
    Read,
    /// The host too.
    ReadWrite,
}

/// A register, or an array of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Register {
    /// Of its first byte.
    pub address: u16,
    /// Type of its values.
    pub kind: Kind,
    /// How many values.
    pub count: u16,
    /// Who may change it.
    pub access: Access,
    /// SI unit, or empty.
    pub unit: &'static str,
    /// Name in the documentation.
    pub name: &'static str,
    /// What it holds.
    pub meaning: &'static str,
}

impl Register {
    /// Bytes.
    #[must_use]
    pub const fn size(&self) -> u16 {
        self.kind.size() * self.count
    }

    /// First address behind it.
    #[must_use]
    pub const fn end(&self) -> u16 {
        self.address + self.size()
    }

    /// Its addresses.
    #[must_use]
    pub const fn range(&self) -> core::ops::Range<u16> {
        self.address..self.end()
    }
}

macro_rules! registers {
    ($($name:ident: $address:expr, $kind:ident[$count:expr], $access:ident, $unit:literal, $meaning:literal;)+) => {
        $(
            #[doc = $meaning]
            pub const $name: Register = Register {
                address: $address,
                kind: Kind::$kind,
                count: $count as u16,
                access: Access::$access,
                unit: $unit,
                name: stringify!($name),
                meaning: $meaning,
            };
        )+

        /// Every register, by address.
        pub const REGISTERS: &[Register] = &[$($name),+];
    };
}

registers! {
    MODEL_NUMBER: 0, U16[1], Read, "", "20480, as the stock firmware's";
    MODEL_INFORMATION: 2, U32[1], Read, "", "1: Burger";
    FIRMWARE_VERSION: 6, U8[1], Read, "", "Of this firmware";
    DEVICE_ID: 7, U8[1], Read, "", "200";
    MILLIS: 10, U32[1], Read, "ms", "Time since start";
    MICROS: 14, U32[1], Read, "µs", "Time since start; the stock firmware has flags here";
    DEVICE_STATUS: 18, U8[1], Read, "", "0, or 255 (−1): no motors, see DRIVE_STATE";
    HEARTBEAT: 19, U8[1], ReadWrite, "", "Has to change: 500 ms after its last change the wheels stop";
    LEDS: 20, U8[4], ReadWrite, "", "The user LEDs 1 to 4: 0 off";
    BUTTONS: 26, U8[2], Read, "", "1 while pressed: SW1, SW2";
    BUMPERS: 28, U8[2], Read, "", "Always 0";
    ILLUMINATION: 30, F32[1], Read, "", "Always 0";
    INFRARED: 34, F32[1], Read, "", "Always 0";
    SONAR: 38, F32[1], Read, "", "Always 0";
    BATTERY_VOLTAGE: 42, I32[1], Read, "0.01 V", "Of the board's supply, or of the battery's sensor; 0 where neither is known";
    BATTERY_PERCENT: 46, I32[1], Read, "0.01 %", "BATTERY_CHARGE; while that is not known as the stock firmware has it, by the voltage alone: 10.5 V are 0, 12.3 V 100";
    SOUND: 50, U8[1], ReadWrite, "", "Melody: kept, not played";
    CALIBRATE_IMU: 59, U8[1], ReadWrite, "", "1: learn the gyroscope's bias anew, as soon as the robot stands; 1 until that is done. Kept where there is no sensor";
    ANGULAR_VELOCITY: 60, F32[3], Read, "rad/s", "Of the robot; without an inertial sensor from its wheels";
    LINEAR_ACCELERATION: 72, F32[3], Read, "m/s²", "Felt, gravity's reaction included; 0 without an inertial sensor";
    MAGNETIC_FIELD: 84, F32[3], Read, "T", "Always 0";
    ORIENTATION: 96, F32[4], Read, "", "Unit quaternion w, x, y, z since start; without an inertial sensor the heading from the wheels";
    SERVO_LOAD: 120, I32[WHEELS], Read, "0.1 %", "Left, right: the servo's register 126 (the node calls it current)";
    SERVO_VELOCITY: 128, I32[WHEELS], Read, "0.229 rev/min", "Left, right: the servo's register 128";
    ODOMETER: 136, I32[WHEELS], Read, "1/4096 turn", "Left, right: positions that go on over the servos' restarts";
    MOTORS_FOUND: 148, U8[1], Read, "", "1 where both servos answer";
    TORQUE_ENABLE: 149, U8[1], ReadWrite, "", "1: torque on, from the start; off and on again restarts a servo that has failed";
    COMMAND_VELOCITY: 150, I32[6], ReadWrite, "0.01 m/s, 0.01 rad/s", "Linear x, y, z, angular x, y, z; taken while the heartbeat lives";
    PROFILE_ACCELERATION: 174, I32[WHEELS], ReadWrite, "214.577 rev/min²", "Left, right: of the servos' goals; 0 without";

    TABLE_VERSION: OURS, U16[1], Read, "", "Version of the registers from 512 on: 5";
    SAMPLE_RATE: 514, U16[1], Read, "Hz", "Samples per second";
    WINDOW: 516, U16[1], Read, "s", "Length of the window over which the mass is estimated";
    MODEL: 518, U8[1], Read, "", "Model in use: 0 Eq. 18 as published, 1 corrected, 2 signed torque, 3 the same on ground that adapts, 255 none";
    COEFFICIENTS_STATE: 519, U8[1], Read, "", "0 in use, 1 none stored, otherwise the reason why those stored are refused: as UPLOAD_REASON";
    COEFFICIENTS_CRC: 520, U32[1], Read, "", "CRC-32 at the end of the image in use; 0 without";
    ROBOT_NAME: 524, U8[24], Read, "", "The robot that this board is set up for: UTF-8, padded with zeros";
    UPTIME: 548, U64[1], Read, "µs", "Time since start";

    RAIL_POWER: 556, F32[RAIL_COUNT], Read, "W", "Power of battery, motors, computer, lidar";
    RAIL_VOLTAGE: 572, F32[RAIL_COUNT], Read, "V", "Bus voltage of each rail";
    RAIL_CURRENT: 588, F32[RAIL_COUNT], Read, "A", "Current of each rail";
    RAIL_ENERGY: 604, F32[RAIL_COUNT], Read, "J", "Energy that each rail delivered since start, less what was fed back";
    RAIL_HEALTH: 620, U8[RAIL_COUNT], Read, "", "0 ok, 1 stale, 2 overflow, 3 absent, 4 lost calibration, 5 implausible";
    RAIL_COUNTERS: 624, U32[5 * RAIL_COUNT], Read, "", "Of each rail: readings, polls without a new one, clipped, no answer, set-up lost; RAIL_IMPLAUSIBLE is the sixth";
    RAIL_CALIBRATION: 704, F32[RAIL_COUNT], Read, "", "True power over measured power, from the store; 1 without";

    WHEEL_HEALTH: 720, U8[WHEELS], Read, "", "Left, right: 0 ok, 1 alert (see WHEEL_HARDWARE_ERROR), 3 absent";
    WHEEL_HARDWARE_ERROR: 722, U8[WHEELS], Read, "", "The servo's register 70";
    WHEEL_SPEED: 724, F32[WHEELS], Read, "rad/s", "Behind the filter where there are coefficients, raw otherwise";
    WHEEL_ACCELERATION: 732, F32[WHEELS], Read, "rad/s²", "Behind the filter; NaN without coefficients";
    WHEEL_POSITION: 740, I32[WHEELS], Read, "1/4096 turn", "The servo's register 132";

    PAYLOAD_STATE: 748, U8[1], Read, "", "0 mass known, 1 no samples or no coefficients, 2 nothing in motion, 3 interval too wide, 4 not finite, 5 lighter than without payload and 6 heavier than with the full one, MASS being that end, 7 coefficients that cannot tell it";
    STANDSTILL: 749, U8[1], Read, "", "1 while the wheels have stood still long enough for the flash to be written";
    MASS: 752, F32[1], Read, "kg", "Total mass, robot and payload";
    MASS_LOW: 756, F32[1], Read, "kg", "Lower end of its 95 % interval";
    MASS_HIGH: 760, F32[1], Read, "kg", "Upper end of its 95 % interval";
    MEASURED_POWER: 764, F32[1], Read, "W", "Actuation power, filtered, static power taken off";
    PREDICTED_POWER: 768, F32[1], Read, "W", "Actuation power by model and mass";
    MEASURED_ENERGY: 772, F32[1], Read, "J", "Actuation energy since start: by Eq. 9, or less what returned where the coefficients say that drives return power";
    PREDICTED_ENERGY: 776, F32[1], Read, "J", "The same by the model, while the mass was known";
    PAYLOAD_CHANGES: 780, U32[1], Read, "", "Payload changes noticed since start";
    LAST_CHANGE: 784, U64[1], Read, "µs", "Since when the payload is another, by the last change noticed";

    SAMPLES: 792, U32[1], Read, "", "Samples taken";
    MISSED_DEADLINES: 796, U32[1], Read, "", "Samples that began later than half a period, writing the store apart";
    SERVO_TIMEOUTS: 800, U32[1], Read, "", "Sync reads that a servo did not answer in time";
    SERVO_BROKEN: 804, U32[1], Read, "", "Packets from the servos with a wrong checksum or length";
    BUS_ERRORS: 808, U32[1], Read, "", "I2C transactions that failed";
    BUS_RECOVERIES: 812, U32[1], Read, "", "Times the I2C bus was set up again";
    LINK_PACKETS: 816, U32[1], Read, "", "Packets for this board";
    LINK_BROKEN: 820, U32[1], Read, "", "Packets on the link with a wrong checksum or length";
    FIFO_LOST: 824, U32[1], Read, "", "Records overwritten before they were acknowledged, while anybody read";
    STORE_WRITES: 828, U32[1], Read, "", "Items written to flash since start";

    UPLOAD_ITEM: 832, U8[1], ReadWrite, "", "What the window is for: 1 coefficients, 2 calibration, 3 robot";
    UPLOAD_COMMAND: 833, U8[1], ReadWrite, "", "1 check the window and store it; 2 forget an upload that waits. Reads as 0";
    UPLOAD_LENGTH: 834, U16[1], ReadWrite, "", "Bytes of the window that count";
    UPLOAD_STATE: 836, U8[1], Read, "", "0 idle, 1 waiting for standstill, 2 stored and read back, 3 refused (UPLOAD_REASON)";
    UPLOAD_REASON: 837, U8[1], Read, "", "Why: see docs/link.md";
    STORED_LENGTH: 838, U16[1], Read, "", "Bytes stored of UPLOAD_ITEM; 0 when there is none";
    UPLOAD_WINDOW: 840, U8[UPLOAD_BYTES], ReadWrite, "", "The item, as its format has it";
    STORED_WINDOW: 1096, U8[UPLOAD_BYTES], Read, "", "What the flash holds of UPLOAD_ITEM";

    FIFO_ACKNOWLEDGE: 1352, U32[1], ReadWrite, "", "The record up to which, itself not counted, the host has them all: the window begins there";
    FIFO_OLDEST: 1356, U32[1], Read, "", "Sequence number of the oldest record there is";
    FIFO_NEXT: 1360, U32[1], Read, "", "Sequence number that the next record will have";
    FIFO_COUNT: 1364, U16[1], Read, "", "Records in the window";
    RECORD_SIZE: 1366, U16[1], Read, "", "Bytes of a record";
    FIFO_WINDOW: 1368, U8[FIFO_WINDOW_RECORDS * RECORD_BYTES], Read, "", "Records, oldest first";

    RESET_CAUSE: 2328, U8[1], Read, "", "Why the board started: 0 power-on, 1 button, 2 asked for, 3 panic, 4 fault, 5 interrupt without a handler, 6 non-maskable interrupt, 7 hang, 8 call of the bootloader, 9 brown-out";
    DRIVE_STATE: 2329, U8[1], Read, "", "0 ready, 1 a servo does not answer, 2 a servo is set up otherwise (SERVO_MISFIT), 3 torque switched off, 4 a servo has failed (WHEEL_HARDWARE_ERROR), 5 being prepared, 6 the motors' supply is cut";
    SERVO_MISFIT: 2330, U8[WHEELS], Read, "", "Left, right: the servo's register that does not fit; 0 where all do";
    RESET_ADDRESS: 2332, U32[1], Read, "", "Of a fault: where; of an interrupt: its number";
    RESET_FAILURES: 2336, U32[1], Read, "", "Resets that nobody wanted, since power-on";
    DRIVE_GOALS: 2340, I32[WHEELS], Read, "0.229 rev/min", "Left, right: what the servos were told last";
    COMMAND_TIMEOUT: 2348, U16[1], ReadWrite, "ms", "For how long a command counts while the heartbeat lives; 0, as at the start: for good";
    NODE_CONNECTED: 2350, U8[1], Read, "", "1 while the heartbeat lives";
    DRIVE_STOPS: 2352, U32[1], Read, "", "Motions ended because heartbeat or command were missing";
    SERVO_REFUSED: 2356, U32[1], Read, "", "Instructions that a servo refused";
    SERVO_UNANSWERED: 2360, U32[1], Read, "", "Pings that a servo which is sought did not answer";
    SERVO_UNVERIFIED: 2364, U32[1], Read, "", "Goals that a servo had not taken when they were read back";
    SERVO_TRIPPED: 2368, U32[1], Read, "", "Times that a servo's own watchdog had stopped it";
    SERVO_RESTARTS: 2372, U32[1], Read, "", "Times that a servo had started anew";
    LINK_ABANDONED: 2376, U32[1], Read, "", "Answers that the host did not fetch in time, or closed its port before";

    BATTERY_CHARGE: 2380, F32[1], Read, "%", "Of the battery's capacity, by its sensor's current and voltage; NaN until known to 10 points, and 10 s after the sensor's last word";
    BATTERY_CHARGE_STD: 2384, F32[1], Read, "%", "Its standard deviation";
    BATTERY_RESISTANCE: 2388, F32[1], Read, "Ω", "Of the battery within a second of a load step, without the sensor's shunt; NaN until load steps have shown it";
    BATTERY_RESISTANCE_STD: 2392, F32[1], Read, "Ω", "Its standard deviation";
    BATTERY_ENERGY_LEFT: 2396, F32[1], Read, "Wh", "What the battery still gives at the present load until the motors' supply is cut";
    BATTERY_ENERGY_LOW: 2400, F32[1], Read, "Wh", "Lower end of its 95 % interval";
    BATTERY_ENERGY_HIGH: 2404, F32[1], Read, "Wh", "Upper end of its 95 % interval";
    BATTERY_TIME_LEFT: 2408, F32[1], Read, "s", "How long that lasts; NaN while nothing is drawn";
    BATTERY_LOAD: 2412, F32[1], Read, "W", "The present load: the battery's mean power of the last minute";

    INERTIAL_STATE: 2416, U8[1], Read, "", "The inertial sensor: 0 tells the orientation, 1 none has answered, 2 its bias waits for standstill, 3 lost; but for 0 the wheels tell the heading";
    INERTIAL_CHIP: 2417, U8[1], Read, "", "0 none, 1 MPU-9250, 2 ICM-20648";
    INERTIAL_ERRORS: 2420, U32[1], Read, "", "Its readings that failed";
    INERTIAL_RESTARTS: 2424, U32[1], Read, "", "Times that it was set up anew";
    GYROSCOPE_BIAS: 2428, F32[3], Read, "rad/s", "What is taken off its rotation; NaN before it is known";

    TOTAL_ENERGY: 2440, U64[RAIL_COUNT], Read, "mJ", "Energy that each rail has ever delivered, less what was fed back: kept over resets, but for what came after the last write, a minute at most";
    TOTAL_DISTANCE: 2472, U32[1], Read, "cm", "Way of the middle between the wheels, forward and back, likewise";
    TOTAL_DRIVING_TIME: 2476, U32[1], Read, "s", "Time in motion with torque on, likewise";
    TOTAL_TIME: 2480, U32[1], Read, "s", "Time switched on, likewise";
    TOTALS_WRITES: 2484, U32[1], Read, "", "Times that these were written to flash since start";
    STORE_ERASES: 2488, U32[1], Read, "", "Sectors erased since start";
    TOTALS_STATE: 2492, U8[1], Read, "", "0 written once a minute, 1 not read at start: since start only, 2 waiting for a sector to be erased, which takes torque to be off, 3 the flash does not take them";
    STORE_PREPARED: 2493, U8[1], Read, "", "1 while the spare sector is erased: what is stored next needs no erase";
    PREVIOUS_CRC: 2496, U32[1], ReadWrite, "", "CRC-32 of the coefficients before those stored; 0 without. Writing it takes them into use again, as an upload";
    PREVIOUS_STATE: 2500, U8[1], Read, "", "0 they would be taken, 1 there are none, otherwise the reason why not: as UPLOAD_REASON";
    NEEDS_SIGNATURE: 2501, U8[1], Read, "", "1: coefficients without a right signature are not used";
    UPLOAD_SIGNATURE: 2504, U8[SIGNATURE_BYTES], ReadWrite, "", "Ed25519 signature of the coefficients in the window; zeros: none";
    MEASURED_SAMPLES: 2568, U32[1], Read, "", "Samples that MEASURED_ENERGY counts: what is missing of SAMPLES nobody measured, or had no coefficients";
    PREDICTED_SAMPLES: 2572, U32[1], Read, "", "Samples that PREDICTED_ENERGY counts";
    RAIL_IMPLAUSIBLE: 2576, U32[RAIL_COUNT], Read, "", "Of each rail, readings left out because they are not the sensor's own product of current and voltage";
}

/// Why an upload is refused, or what is stored not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Reason {
    /// Nothing is wrong.
    None = 0,
    /// There is nothing.
    Empty = 1,
    /// Fewer bytes than the item says, or more than the window has.
    Length = 2,
    /// Not what `UPLOAD_ITEM` says: its magic is missing.
    NotAnImage = 3,
    /// A layout of another version.
    Version = 4,
    /// The checksum does not match.
    Checksum = 5,
    /// A model that this firmware does not have.
    Model = 6,
    /// Another number of wheels.
    Wheels = 7,
    /// Another robot's name or geometry.
    Robot = 8,
    /// A number that is not finite, negative, or beyond what any robot has.
    Value = 9,
    /// The filter's cutoff is beyond what the sample rate allows.
    Cutoff = 10,
    /// `UPLOAD_ITEM` names none.
    Item = 11,
    /// The flash cannot be read or written.
    Flash = 12,
    /// What was read back is not what was written.
    ReadBack = 13,
    /// An effect that this firmware does not have.
    Effect = 14,
    /// An effect by something that the board does not measure.
    Input = 15,
    /// A delay that reaches back farther than the samples that the board keeps.
    Delay = 16,
    /// Both sectors are full, and none may be erased while torque is on.
    Erase = 17,
    /// Not signed, on a board that is built with a key, or with another key.
    Signature = 18,
    /// A filter that settles only after most of the window, or loses the power in single precision.
    Slow = 19,
    /// The mass would stay unknown however the robot drives.
    Mass = 20,
}

impl Reason {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::None,
            1 => Self::Empty,
            2 => Self::Length,
            3 => Self::NotAnImage,
            4 => Self::Version,
            5 => Self::Checksum,
            6 => Self::Model,
            7 => Self::Wheels,
            8 => Self::Robot,
            9 => Self::Value,
            10 => Self::Cutoff,
            11 => Self::Item,
            12 => Self::Flash,
            13 => Self::ReadBack,
            14 => Self::Effect,
            15 => Self::Input,
            16 => Self::Delay,
            17 => Self::Erase,
            18 => Self::Signature,
            19 => Self::Slow,
            20 => Self::Mass,
            _ => return None,
        })
    }

    /// In words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::None => "nothing is wrong",
            Self::Empty => "nothing is stored",
            Self::Length => "fewer bytes than the item says, or more than fit",
            Self::NotAnImage => "not an image of this item",
            Self::Version => "an image of another version",
            Self::Checksum => "the checksum does not match",
            Self::Model => "a model that the firmware does not have",
            Self::Wheels => "for another number of wheels",
            Self::Robot => "for another robot",
            Self::Value => "a value that no robot has",
            Self::Cutoff => "the filter's cutoff is beyond what the sample rate allows",
            Self::Item => "no such item",
            Self::Flash => "the flash cannot be read or written",
            Self::ReadBack => "the flash does not hold what was written",
            Self::Effect => "an effect that the firmware does not have",
            Self::Input => {
                "an effect by what the board does not measure: pitch, temperature or processor load"
            }
            Self::Delay => "a delay longer than the board keeps samples for",
            Self::Erase => "the flash has to be erased first, which waits until torque is off",
            Self::Signature => "not signed with the key that the board asks for",
            Self::Slow => "a filter cutoff below 0.1 Hz, which settles too late for any mass",
            Self::Mass => {
                "a mass that stays unknown however the robot drives: the power does not depend on it, or its noise hides it"
            }
        }
    }
}

/// What an upload is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Item {
    /// The image of `model_core::coefficients`.
    Coefficients = 1,
    /// [`crate::items::Calibration`].
    Calibration = 2,
    /// [`crate::items::RobotIdentity`].
    Robot = 3,
}

impl Item {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            1 => Self::Coefficients,
            2 => Self::Calibration,
            3 => Self::Robot,
            _ => return None,
        })
    }
}

/// How far an upload is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum UploadState {
    /// None yet.
    #[default]
    Idle = 0,
    /// Checked; written as soon as the wheels stand still.
    Waiting = 1,
    /// In flash, read back and compared.
    Stored = 2,
    /// Not taken; what was stored before still is.
    Refused = 3,
}

impl UploadState {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Idle,
            1 => Self::Waiting,
            2 => Self::Stored,
            3 => Self::Refused,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_sorted_and_do_not_overlap() {
        for pair in REGISTERS.windows(2) {
            assert!(pair[0].end() <= pair[1].address, "{} reaches into {}", pair[0].name, pair[1].name);
        }
        assert_eq!(END, REGISTERS.last().unwrap().end());
    }

    /// Numbers stand at multiples of their size where ours begin, so that a host can map them.
    #[test]
    fn ours_are_aligned() {
        for register in REGISTERS.iter().filter(|register| register.address >= OURS) {
            let alignment = register.kind.size().min(4);
            assert_eq!(register.address % alignment, 0, "{}", register.name);
        }
    }
}
