//! What is known now, beyond the record of the sample: what the sampler measured is what the link
//! shows. `None` where nothing is known.

use model_core::charge::{Charge, Remaining};
use model_core::payload::{MassEstimate, Unknown};

use crate::estimation::{Changes, Counted, NO_MODEL};
use crate::power_sensors::{Counters, Health, RAIL_COUNT};
use crate::wheels::{DriveState, ServoCounters, WHEELS, WheelHealth};

/// Of a rail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RailSnapshot {
    /// At the consumer, V, by the latest reading of a sensor that can be believed.
    pub voltage: Option<f32>,
    /// A, likewise.
    pub current: Option<f32>,
    /// W, calibrated, likewise.
    pub power: Option<f32>,
    /// Delivered since start, J, by Eq. 9: what is fed back is not taken off.
    pub energy: f32,
    /// Of its sensor.
    pub health: Health,
    /// What happened to its sensor.
    pub counters: Counters,
    /// True power over measured power, in use.
    pub power_factor: f32,
}

impl RailSnapshot {
    /// Before the first poll.
    pub const UNKNOWN: Self = Self {
        voltage: None,
        current: None,
        power: None,
        energy: 0.0,
        health: Health::Absent,
        counters: Counters::NONE,
        power_factor: 1.0,
    };
}

/// Of a wheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelSnapshot {
    /// Of its servo.
    pub health: WheelHealth,
    /// Register 70 of its servo, while that has an alert.
    pub hardware_error: u8,
    /// rad/s, positive forward: behind the filter where that has settled, otherwise as measured.
    pub speed: Option<f32>,
    /// rad/s², behind the filter.
    pub acceleration: Option<f32>,
    /// Register 132 of its servo: 1/4096 turn, in the servo's direction.
    pub position: Option<i32>,
    /// Position that goes on over the servo's restarts: 1/4096 turn, positive forward.
    pub odometer: Option<i32>,
    /// Register 128 of its servo: 0.229 rev/min; 0 while it is absent.
    pub velocity_code: i32,
    /// Register 126 of its servo: 0.1 % of the greatest torque; 0 while it is absent.
    pub load_code: i16,
    /// The register by which its servo is not fit to drive; 0 where it is.
    pub misfit: u8,
}

impl WheelSnapshot {
    /// Before the first answer.
    pub const UNKNOWN: Self = Self {
        health: WheelHealth::Absent,
        hardware_error: 0,
        speed: None,
        acceleration: None,
        position: None,
        odometer: None,
        velocity_code: 0,
        load_code: 0,
        misfit: 0,
    };
}

/// Of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DriveSnapshot {
    /// Whether the robot can drive.
    pub state: DriveState,
    /// Both servos hold their torque.
    pub has_torque: bool,
    /// Of each servo, whether it is known to hold no torque, or does not answer.
    pub are_off: [bool; WHEELS],
    /// What the servos were told last: 0.229 rev/min, positive forward.
    pub goals: [i32; WHEELS],
}

impl DriveSnapshot {
    /// Before the first sample.
    pub const UNKNOWN: Self =
        Self { state: DriveState::Lost, has_torque: false, are_off: [false; WHEELS], goals: [0; WHEELS] };
}

/// Of the battery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatterySnapshot {
    /// How full it is.
    pub charge: Option<Charge<f32>>,
    /// Its resistance within a second of a load step and its standard deviation, Ω.
    pub resistance: Option<(f32, f32)>,
    /// What is left until the motors' supply is cut, at the present load.
    pub remaining: Option<Remaining<f32>>,
}

impl BatterySnapshot {
    /// Before its sensor has said enough.
    pub const UNKNOWN: Self = Self { charge: None, resistance: None, remaining: None };
}

/// Of the estimator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimateSnapshot {
    /// As the control table's `MODEL`; [`NO_MODEL`] without coefficients.
    pub model: u8,
    /// Total mass, or why it is unknown; [`crate::estimation::mass_code`] is its code.
    pub mass: MassEstimate<f32>,
    /// Actuation power, W, behind the filter.
    pub measured_power: Option<f32>,
    /// The same by model and mass.
    pub predicted_power: Option<f32>,
    /// Actuation energy since start, J.
    pub measured_energy: Option<f32>,
    /// The same by the model, while the mass was known.
    pub predicted_energy: Option<f32>,
    /// Samples that these count.
    pub counted: Counted,
    /// Payload changes noticed.
    pub changes: Changes,
}

impl EstimateSnapshot {
    /// Before the first sample.
    pub const UNKNOWN: Self = Self {
        model: NO_MODEL,
        mass: MassEstimate::Unknown(Unknown::NoSamples),
        measured_power: None,
        predicted_power: None,
        measured_energy: None,
        predicted_energy: None,
        counted: Counted::NONE,
        changes: Changes::NONE,
    };
}

/// Of everything.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot {
    /// When the last sample was taken, µs since start.
    pub time_us: u64,
    /// Samples taken.
    pub samples: u32,
    /// In the order of [`crate::power_sensors::RAILS`].
    pub rails: [RailSnapshot; RAIL_COUNT],
    /// By the battery's rail.
    pub battery: BatterySnapshot,
    /// Left, right.
    pub wheels: [WheelSnapshot; WHEELS],
    /// What went wrong on the servo bus.
    pub servo_bus: ServoCounters,
    /// What the estimator says.
    pub estimate: EstimateSnapshot,
    /// The wheels have stood still long enough for the flash to be written.
    pub is_standing: bool,
    /// Whether the robot can drive, and what its servos were told.
    pub drive: DriveSnapshot,
}

impl Snapshot {
    /// Before the first sample.
    pub const UNKNOWN: Self = Self {
        time_us: 0,
        samples: 0,
        rails: [RailSnapshot::UNKNOWN; RAIL_COUNT],
        battery: BatterySnapshot::UNKNOWN,
        wheels: [WheelSnapshot::UNKNOWN; WHEELS],
        servo_bus: ServoCounters::NONE,
        estimate: EstimateSnapshot::UNKNOWN,
        is_standing: false,
        drive: DriveSnapshot::UNKNOWN,
    };
}
