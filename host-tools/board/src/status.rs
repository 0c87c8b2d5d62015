//! What a board measures and estimates just now.

use std::time::Duration;

use firmware::control_table::{self as table, Reason};
use firmware::inertial::InertialHealth;
use firmware::power_sensors::Health;
use firmware::reset::ResetCause;
use firmware::totals::Keeping;
use serde::Serialize;
use support::error::{Error, Result};

use super::client::{Block, Client};
use super::transport::Transport;
use super::{health_text, rail_names};

/// Registers of one instant. What the board does not know is `None`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Status {
    /// Since the board's start, s.
    pub uptime_s: f64,
    /// Each rail.
    pub rails: Vec<RailStatus>,
    /// Of the board's whole life.
    pub totals: TotalsStatus,
    /// The battery by its gauge.
    pub battery: BatteryStatus,
    /// Who tells the orientation: the inertial sensor, or why it does not.
    pub inertial: &'static str,
    /// Heading since start, degrees, counter-clockwise.
    pub yaw_deg: f32,
    /// Left, right, rad/s.
    pub wheel_rad_s: Vec<Option<f32>>,
    /// Whether the wheels stand still.
    pub is_standing: bool,
    /// Total mass, kg, and its 95 % interval.
    pub mass_kg: Option<f32>,
    /// Lower end.
    pub low_kg: Option<f32>,
    /// Upper end.
    pub high_kg: Option<f32>,
    /// Beyond which end of the robot's range the mass lies, if it does.
    #[serde(rename = "beyond")]
    pub out_of_range: Option<&'static str>,
    /// Why the mass is not known, if it is not.
    pub unknown: Option<&'static str>,
    /// Actuation power, W: filtered.
    pub measured_w: Option<f32>,
    /// Actuation power by the model, W.
    pub predicted_w: Option<f32>,
    /// Actuation energy since start, J.
    pub measured_j: Option<f32>,
    /// Share of the samples since start that this counts.
    pub measured_share: Option<f64>,
    /// The same by the model, J, while the mass was known.
    pub predicted_j: Option<f32>,
    /// Share of the samples that it counts.
    pub predicted_share: Option<f64>,
    /// Payload changes noticed since start.
    pub changes: u32,
    /// Why the board uses no coefficients, if it does not.
    pub no_coefficients: Option<&'static str>,
    /// Why the board started last.
    pub reset: &'static str,
    /// Whether the robot can drive, and why not.
    pub drive: String,
    /// What the wheels' servos were told last, left and right, 0.229 rev/min.
    pub goals: Vec<i32>,
    /// Whether a node drives: its heartbeat lives.
    pub is_driven: bool,
    /// Faults counted since start, those that happened.
    pub faults: Vec<(&'static str, u32)>,
}

/// A rail.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RailStatus {
    /// Which.
    pub name: &'static str,
    /// W
    pub power_w: Option<f32>,
    /// V
    pub voltage_v: Option<f32>,
    /// A
    pub current_a: Option<f32>,
    /// Delivered since start, J.
    pub energy_j: Option<f32>,
    /// Delivered in the board's whole life, J.
    pub total_j: f64,
    /// Of its sensor.
    pub health: &'static str,
}

/// What the board has counted since it was first started.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TotalsStatus {
    /// Way of the middle between the wheels, m.
    pub distance_m: f64,
    /// In motion, s.
    pub driving_s: u32,
    /// Switched on, s.
    pub on_s: u32,
    /// Why they are not kept over a reset, if they are not.
    pub unkept: Option<&'static str>,
}

/// The battery, as far as the board knows it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BatteryStatus {
    /// Of its capacity, %.
    pub charge_percent: Option<f32>,
    /// Standard deviation, %.
    pub charge_std_percent: Option<f32>,
    /// Within a second of a load step, Ω.
    pub resistance_ohm: Option<f32>,
    /// Standard deviation, Ω.
    pub resistance_std_ohm: Option<f32>,
    /// What it still gives at the present load until the motors are cut off, Wh.
    #[serde(rename = "left_wh")]
    pub remaining_wh: Option<f32>,
    /// Lower end of the 95 % interval, Wh.
    #[serde(rename = "left_low_wh")]
    pub remaining_low_wh: Option<f32>,
    /// Upper end, Wh.
    #[serde(rename = "left_high_wh")]
    pub remaining_high_wh: Option<f32>,
    /// How long that lasts, s.
    #[serde(rename = "left_s")]
    pub remaining_s: Option<f32>,
    /// That load, W.
    pub load_w: Option<f32>,
}

/// Counters of which any but 0 is worth a look.
const FAULTS: [(&table::Register, &str); 19] = [
    (&table::MISSED_DEADLINES, "missed deadlines"),
    (&table::SERVO_TIMEOUTS, "servo timeouts"),
    (&table::SERVO_BROKEN, "broken servo packets"),
    (&table::BUS_ERRORS, "I2C errors"),
    (&table::BUS_RECOVERIES, "I2C recoveries"),
    (&table::LINK_BROKEN, "broken link packets"),
    (&table::FIFO_LOST, "lost records"),
    (&table::WHEEL_HARDWARE_ERROR, "servo hardware error"),
    (&table::RESET_FAILURES, "unwanted resets"),
    (&table::DRIVE_STOPS, "stops without a heartbeat"),
    (&table::SERVO_REFUSED, "instructions refused by a servo"),
    (&table::SERVO_UNANSWERED, "pings without an answer"),
    (&table::SERVO_UNVERIFIED, "goals not taken"),
    (&table::SERVO_TRIPPED, "servos stopped by their watchdog"),
    (&table::SERVO_RESTARTS, "servo restarts"),
    (&table::LINK_ABANDONED, "answers not fetched"),
    (&table::INERTIAL_ERRORS, "inertial sensor errors"),
    (&table::INERTIAL_RESTARTS, "inertial sensor restarts"),
    (&table::RAIL_IMPLAUSIBLE, "power readings left out that disagree with themselves"),
];

impl Status {
    /// Reads them.
    ///
    /// # Errors
    /// The board does not answer.
    pub fn read<T: Transport>(client: &mut Client<T>) -> Result<Self> {
        let block = client.block(&table::TABLE_VERSION, &table::STORE_WRITES)?;
        let behind = client.block(&table::RESET_CAUSE, &table::RAIL_IMPLAUSIBLE)?;
        let stock = client.block(&table::ORIENTATION, &table::ORIENTATION)?;
        let number = |register: &table::Register| Ok(known(block.get(register)?));
        let samples = f64::from(block.get::<u32>(&table::SAMPLES)?);
        let share = |register: &table::Register| -> Result<Option<f64>> {
            let counted = f64::from(behind.get::<u32>(register)?);
            Ok((samples > 0.0).then(|| (counted / samples).min(1.0)))
        };
        let state = block.get::<u8>(&table::PAYLOAD_STATE)?;
        let coefficients = block.get::<u8>(&table::COEFFICIENTS_STATE)?;
        Ok(Self {
            uptime_s: Duration::from_micros(block.get(&table::UPTIME)?).as_secs_f64(),
            rails: rails(&block, &behind)?,
            totals: totals(&behind)?,
            battery: battery(&behind)?,
            inertial: inertial_text(behind.get(&table::INERTIAL_STATE)?, behind.get(&table::INERTIAL_CHIP)?),
            yaw_deg: yaw_deg(&stock.all(&table::ORIENTATION)?),
            wheel_rad_s: block.all(&table::WHEEL_SPEED)?.into_iter().map(known).collect(),
            is_standing: block.get::<u8>(&table::STANDSTILL)? != 0,
            mass_kg: number(&table::MASS)?,
            low_kg: number(&table::MASS_LOW)?,
            high_kg: number(&table::MASS_HIGH)?,
            out_of_range: out_of_range_text(state),
            unknown: unknown_text(state),
            measured_w: number(&table::MEASURED_POWER)?,
            predicted_w: number(&table::PREDICTED_POWER)?,
            measured_j: number(&table::MEASURED_ENERGY)?,
            measured_share: share(&table::MEASURED_SAMPLES)?,
            predicted_j: number(&table::PREDICTED_ENERGY)?,
            predicted_share: share(&table::PREDICTED_SAMPLES)?,
            changes: block.get(&table::PAYLOAD_CHANGES)?,
            no_coefficients: (coefficients != 0)
                .then(|| Reason::from_code(coefficients).map_or("for an unknown reason", Reason::text)),
            reset: ResetCause::from_code(behind.get(&table::RESET_CAUSE)?)
                .map_or("a cause that this version does not know", ResetCause::text),
            drive: drive_text(behind.get(&table::DRIVE_STATE)?, &behind.all(&table::SERVO_MISFIT)?),
            goals: behind.all(&table::DRIVE_GOALS)?,
            is_driven: behind.get::<u8>(&table::NODE_CONNECTED)? != 0,
            faults: faults(&[block, behind])?,
        })
    }
}

/// NaN is how the board says that it does not know.
fn known(value: f32) -> Option<f32> {
    value.is_finite().then_some(value)
}

fn totals(block: &Block) -> Result<TotalsStatus> {
    let state = block.get::<u8>(&table::TOTALS_STATE)?;
    Ok(TotalsStatus {
        distance_m: f64::from(block.get::<u32>(&table::TOTAL_DISTANCE)?) / 100.0,
        driving_s: block.get(&table::TOTAL_DRIVING_TIME)?,
        on_s: block.get(&table::TOTAL_TIME)?,
        unkept: (state != Keeping::Ok as u8).then_some(match state {
            1 => "the flash could not be read: since start only",
            2 => "the flash is full, and erased as soon as torque is off",
            3 => "the flash does not take them",
            _ => "for a reason that this version does not know",
        }),
    })
}

fn rails(block: &Block, behind: &Block) -> Result<Vec<RailStatus>> {
    let read = |register: &table::Register| block.all::<f32>(register);
    let (power, voltage) = (read(&table::RAIL_POWER)?, read(&table::RAIL_VOLTAGE)?);
    let (current, energy) = (read(&table::RAIL_CURRENT)?, read(&table::RAIL_ENERGY)?);
    let health = block.all::<u8>(&table::RAIL_HEALTH)?;
    let total = behind.all::<u64>(&table::TOTAL_ENERGY)?;
    let at = |values: &[f32], rail: usize| values.get(rail).copied().and_then(known);
    let rail = |(rail, name)| RailStatus {
        name,
        power_w: at(&power, rail),
        voltage_v: at(&voltage, rail),
        current_a: at(&current, rail),
        energy_j: at(&energy, rail),
        total_j: total.get(rail).map_or(0.0, |total| *total as f64 / 1000.0),
        health: health.get(rail).copied().and_then(Health::from_code).map_or("unknown", health_text),
    };
    Ok(rail_names().into_iter().enumerate().map(rail).collect())
}

fn battery(block: &Block) -> Result<BatteryStatus> {
    let number = |register: &table::Register| Ok::<_, Error>(known(block.get(register)?));
    Ok(BatteryStatus {
        charge_percent: number(&table::BATTERY_CHARGE)?,
        charge_std_percent: number(&table::BATTERY_CHARGE_STD)?,
        resistance_ohm: number(&table::BATTERY_RESISTANCE)?,
        resistance_std_ohm: number(&table::BATTERY_RESISTANCE_STD)?,
        remaining_wh: number(&table::BATTERY_ENERGY_LEFT)?,
        remaining_low_wh: number(&table::BATTERY_ENERGY_LOW)?,
        remaining_high_wh: number(&table::BATTERY_ENERGY_HIGH)?,
        remaining_s: number(&table::BATTERY_TIME_LEFT)?,
        load_w: number(&table::BATTERY_LOAD)?,
    })
}

fn faults(blocks: &[Block; 2]) -> Result<Vec<(&'static str, u32)>> {
    let [before, behind] = blocks;
    let mut faults = Vec::new();
    for (register, text) in FAULTS {
        let block = if register.address < table::RESET_CAUSE.address { before } else { behind };
        let count = match register.kind {
            table::Kind::U8 => block.all::<u8>(register)?.into_iter().map(u32::from).max().unwrap_or(0),
            _ => block.all::<u32>(register)?.into_iter().fold(0, u32::saturating_add),
        };
        if count > 0 {
            faults.push((text, count));
        }
    }
    Ok(faults)
}

/// Of a quaternion w, x, y, z.
fn yaw_deg(orientation: &[f32]) -> f32 {
    match orientation {
        &[w, x, y, z] => (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)).to_degrees(),
        _ => 0.0,
    }
}

/// [`table::INERTIAL_STATE`] and [`table::INERTIAL_CHIP`] in words.
fn inertial_text(state: u8, chip: u8) -> &'static str {
    match (InertialHealth::from_code(state), chip) {
        (Some(InertialHealth::Ok), 1) => "by the MPU-9250",
        (Some(InertialHealth::Ok), 2) => "by the ICM-20648",
        (Some(InertialHealth::Ok), _) => "by an inertial sensor",
        (Some(InertialHealth::Absent), _) => "by the wheels: no inertial sensor",
        (Some(InertialHealth::Settling), _) => "by the wheels: the gyroscope's bias waits for standstill",
        (Some(InertialHealth::Lost), _) => "by the wheels: the inertial sensor does not answer any more",
        (None, _) => "by what this version does not know",
    }
}

/// [`table::DRIVE_STATE`] in words, with the registers of [`table::SERVO_MISFIT`].
fn drive_text(state: u8, misfits: &[u8]) -> String {
    match state {
        0 => "ready".to_owned(),
        1 => "a servo does not answer".to_owned(),
        2 => {
            let registers: Vec<String> = misfits
                .iter()
                .zip(["left", "right"])
                .filter(|(register, _)| **register != 0)
                .map(|(register, side)| format!("register {register} of the {side} servo"))
                .collect();
            format!("set up otherwise: {}", registers.join(", "))
        }
        3 => "torque is off".to_owned(),
        4 => "a servo has failed".to_owned(),
        5 => "being prepared".to_owned(),
        6 => "the motors' supply is cut".to_owned(),
        _ => "a state that this version does not know".to_owned(),
    }
}

/// [`table::PAYLOAD_STATE`] where the mass lies beyond the robot's range.
fn out_of_range_text(state: u8) -> Option<&'static str> {
    match state {
        5 => Some("lighter than without payload"),
        6 => Some("heavier than with the full payload"),
        _ => None,
    }
}

/// [`table::PAYLOAD_STATE`] in words.
fn unknown_text(state: u8) -> Option<&'static str> {
    match state {
        0 | 5 | 6 => None,
        1 => Some("no samples or no coefficients"),
        2 => Some("nothing in motion"),
        3 => Some("the interval is too wide"),
        4 => Some("not finite"),
        7 => Some("the coefficients come from one payload or one speed only"),
        _ => Some("a state that this version does not know"),
    }
}
