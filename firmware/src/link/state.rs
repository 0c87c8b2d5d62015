//! All that the link shows: the board's tasks fill it in, [`super::render`] makes registers of it.

use model_core::payload::{MassEstimate, Unknown};

use super::{Fifo, Settings, Upload};
use crate::control_table::{Item, Reason};
use crate::items::ItemBytes;
use crate::power_sensors::{self, Health, RAIL_COUNT};
use crate::wheels::{WHEELS, WheelHealth};

/// The board as the link shows it. `RECORDS` is the size of its [`Fifo`].
#[derive(Debug, Clone, PartialEq)]
pub struct State<const RECORDS: usize> {
    /// Now: time since start, µs.
    pub time_us: u64,
    /// Length of the estimator's window, s.
    pub window_s: u16,
    /// In the order of [`power_sensors::RAILS`].
    pub rails: [Rail; RAIL_COUNT],
    /// Left, right.
    pub wheels: [Wheel; WHEELS],
    /// What is known of payload and power.
    pub estimate: Estimate,
    /// The wheels have stood still long enough for the flash to be written.
    pub is_standing: bool,
    /// What happened since start.
    pub counters: Counters,
    /// The samples.
    pub fifo: Fifo<RECORDS>,
    pub(super) settings: Settings,
    pub(super) upload: Upload,
}

/// A supply rail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rail {
    /// W
    pub power: Option<f32>,
    /// V
    pub voltage: Option<f32>,
    /// A
    pub current: Option<f32>,
    /// Delivered since start, J.
    pub energy: f32,
    /// Of its sensor.
    pub health: Health,
    /// Of its sensor.
    pub counters: power_sensors::Counters,
}

/// A wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    /// Of its servo.
    pub health: WheelHealth,
    /// The servo's register 70.
    pub hardware_error: u8,
    /// rad/s; filtered where there are coefficients.
    pub speed: Option<f32>,
    /// rad/s², filtered.
    pub acceleration: Option<f32>,
    /// The servo's register 132, 1/4096 turn; the last one known.
    pub position: i32,
}

/// What is known of payload and power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Total mass, kg.
    pub mass: MassEstimate<f32>,
    /// Actuation power behind the filter, W.
    pub measured_power: Option<f32>,
    /// Actuation power by model and mass, W.
    pub predicted_power: Option<f32>,
    /// Actuation energy since start, J.
    pub measured_energy: f32,
    /// The same by the model, while the mass was known, J.
    pub predicted_energy: f32,
    /// Payload changes noticed since start.
    pub changes: u32,
    /// Since when the payload is another, by the last one, µs since start; 0 while there was none.
    pub last_change_us: u64,
}

/// What happened since start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Samples taken.
    pub samples: u32,
    /// Samples that began late.
    pub missed_deadlines: u32,
    /// Sync reads that a servo did not answer in time.
    pub servo_timeouts: u32,
    /// Broken packets from the servos.
    pub servo_broken: u32,
    /// I2C transactions that failed.
    pub bus_errors: u32,
    /// Times the I2C bus was set up again.
    pub bus_recoveries: u32,
    /// Packets for this board.
    pub link_packets: u32,
    /// Broken packets on the link.
    pub link_broken: u32,
    /// Items written to flash.
    pub store_writes: u32,
}

impl Rail {
    /// Before the first poll.
    pub const UNKNOWN: Self = Self {
        power: None,
        voltage: None,
        current: None,
        energy: 0.0,
        health: Health::Absent,
        counters: power_sensors::Counters {
            fresh: 0,
            not_ready: 0,
            clipped: 0,
            no_answer: 0,
            set_up_lost: 0,
        },
    };
}

impl Wheel {
    /// Before the first answer.
    pub const UNKNOWN: Self =
        Self { health: WheelHealth::Absent, hardware_error: 0, speed: None, acceleration: None, position: 0 };
}

impl Estimate {
    /// Before the first sample.
    pub const UNKNOWN: Self = Self {
        mass: MassEstimate::Unknown(Unknown::NoSamples),
        measured_power: None,
        predicted_power: None,
        measured_energy: 0.0,
        predicted_energy: 0.0,
        changes: 0,
        last_change_us: 0,
    };
}

impl Counters {
    const NONE: Self = Self {
        samples: 0,
        missed_deadlines: 0,
        servo_timeouts: 0,
        servo_broken: 0,
        bus_errors: 0,
        bus_recoveries: 0,
        link_packets: 0,
        link_broken: 0,
        store_writes: 0,
    };
}

impl<const RECORDS: usize> State<RECORDS> {
    /// Nothing measured, nothing stored.
    #[must_use]
    pub const fn new(sample_rate_hz: u16, window_s: u16) -> Self {
        Self {
            time_us: 0,
            window_s,
            rails: [Rail::UNKNOWN; RAIL_COUNT],
            wheels: [Wheel::UNKNOWN; WHEELS],
            estimate: Estimate::UNKNOWN,
            is_standing: false,
            counters: Counters::NONE,
            fifo: Fifo::new(),
            settings: Settings::new(sample_rate_hz),
            upload: Upload::new(),
        }
    }

    /// Coefficients, calibration and robot in use.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// How far an upload is.
    #[must_use]
    pub const fn upload(&self) -> &Upload {
        &self.upload
    }

    /// What the flash held of an item at start, or why that is not known. Every item at once: [`crate::items::ITEMS`].
    pub fn load(&mut self, item: Item, stored: Result<ItemBytes, Reason>) {
        self.settings.load(item, stored);
    }

    /// An upload to be written now: there is one, it is checked, and the robot stands still. [`Self::stored`] has to follow.
    pub fn take_pending(&mut self) -> Option<(Item, ItemBytes)> {
        if self.is_standing { self.upload.take() } else { None }
    }

    /// How writing what [`Self::take_pending`] gave went: read back and equal, or not. On success it is what is in use.
    pub fn stored(&mut self, item: Item, result: Result<(), Reason>) {
        if let (Ok(()), Some(bytes)) = (result, self.upload.being_written(item)) {
            self.settings.load(item, Ok(bytes));
            self.counters.store_writes = self.counters.store_writes.saturating_add(1);
        }
        self.upload.end(result);
    }
}
