//! The registers' values, one line each.

use super::State;
use crate::control_table::{self as table, BOARD_ID, BOARD_MODEL, Item, Kind, Reason, Register};
use crate::drive::battery_percent;
use crate::dynamixel::xl430::Velocity;
use crate::estimation::{NO_MODEL, mass_code, model_code};
use crate::inertial::InertialSnapshot;
use crate::items::{checksum, parts};
use crate::measurement::{BatterySnapshot, RailSnapshot, Snapshot};
use crate::parameters::{TRACK_M, WHEEL_RADIUS_M};
use crate::record::RECORD_BYTES;
use crate::wheels::{DriveState, WheelHealth};

/// -1 as the stock firmware shows it: the node cannot drive.
const NO_MOTORS: u8 = 0xFF;

const J_PER_WH: f32 = 3600.0;

/// Version of this firmware, as the link shows it.
pub const FIRMWARE: u8 = 1;

/// The bytes of the addresses from `address` on. Between registers, and beyond the table, they are
/// 0.
pub fn render(state: &State<'_>, address: u16, out: &mut [u8]) {
    out.fill(0);
    show(state, &mut Window { address, out });
}

/// A value of a register.
trait Value {
    const KIND: Kind;
    fn bytes(self) -> impl AsRef<[u8]>;
}

macro_rules! values {
    ($($number:ty: $kind:ident),+) => {
        $(impl Value for $number {
            const KIND: Kind = Kind::$kind;
            fn bytes(self) -> impl AsRef<[u8]> {
                self.to_le_bytes()
            }
        })+
    };
}

values!(u8: U8, u16: U16, u32: U32, u64: U64, i32: I32, f32: F32);

/// What is not known is NaN.
impl Value for Option<f32> {
    const KIND: Kind = Kind::F32;
    fn bytes(self) -> impl AsRef<[u8]> {
        self.unwrap_or(f32::NAN).to_le_bytes()
    }
}

/// Takes the registers one after the other.
trait Sink {
    /// Pieces of a register's bytes, of values of this kind.
    fn put(&mut self, register: Register, kind: Kind, pieces: impl Iterator<Item = impl AsRef<[u8]>>);

    /// Whether anything of the registers from one to another is asked for.
    fn wants(&self, first: Register, last: Register) -> bool;

    fn values<V: Value>(&mut self, register: Register, values: impl IntoIterator<Item = V>) {
        self.put(register, V::KIND, values.into_iter().map(V::bytes));
    }

    fn value(&mut self, register: Register, value: impl Value) {
        self.values(register, [value]);
    }

    fn bytes(&mut self, register: Register, bytes: &[u8]) {
        self.put(register, Kind::U8, core::iter::once(bytes));
    }
}

/// Some addresses: what lies outside is left out, before it is computed where that takes long.
struct Window<'a> {
    address: u16,
    out: &'a mut [u8],
}

impl Window<'_> {
    /// What of a piece at this address lies within. Once in the image, not once for each register.
    #[inline(never)]
    fn copy(&mut self, at: usize, piece: &[u8]) {
        let first = usize::from(self.address);
        // What of the piece lies before the window, and where in the window it begins.
        let (before, offset) = (first.saturating_sub(at), at.saturating_sub(first));
        if let (Some(bytes), Some(place)) = (piece.get(before..), self.out.get_mut(offset..)) {
            let count = bytes.len().min(place.len());
            if let (Some(bytes), Some(place)) = (bytes.get(..count), place.get_mut(..count)) {
                place.copy_from_slice(bytes);
            }
        }
    }
}

impl Sink for Window<'_> {
    fn put(&mut self, register: Register, _: Kind, pieces: impl Iterator<Item = impl AsRef<[u8]>>) {
        if !self.wants(register, register) {
            return;
        }
        let mut at = usize::from(register.address);
        for piece in pieces {
            let piece = piece.as_ref();
            self.copy(at, piece);
            at += piece.len();
        }
    }

    fn wants(&self, first: Register, last: Register) -> bool {
        let from = usize::from(self.address);
        usize::from(last.end()) > from && usize::from(first.address) < from + self.out.len()
    }
}

/// What is not asked for is not computed, a group of registers at a time: nothing interrupts
/// meanwhile.
fn show(state: &State<'_>, to: &mut impl Sink) {
    show_board(state, to);
    if to.wants(table::DEVICE_STATUS, table::PROFILE_ACCELERATION) {
        show_stock(state, to);
    }
    if to.wants(table::RESET_CAUSE, table::LINK_ABANDONED) {
        show_drive(state, to);
    }
    if to.wants(table::INERTIAL_STATE, table::GYROSCOPE_BIAS) {
        show_inertial(&state.inertial, to);
    }
    if to.wants(table::BATTERY_CHARGE, table::BATTERY_LOAD) {
        show_battery(&state.snapshot.battery, to);
    }
    show_measurements(state, to);
    show_estimate(state, to);
    show_counters(state, to);
    show_upload(state, to);
    show_fifo(state, to);
    if to.wants(table::TOTAL_ENERGY, table::UPLOAD_SIGNATURE) {
        show_store(state, to);
    }
}

fn show_board(state: &State<'_>, to: &mut impl Sink) {
    let settings = &state.settings;
    let coefficients = settings.coefficients();
    to.value(table::MODEL_NUMBER, BOARD_MODEL);
    to.value(table::MODEL_INFORMATION, 1_u32);
    to.value(table::FIRMWARE_VERSION, FIRMWARE);
    to.value(table::DEVICE_ID, BOARD_ID);
    // Both wrap, as counters of such clocks do.
    to.value(table::MILLIS, (state.time_us / 1000) as u32);
    to.value(table::MICROS, state.time_us as u32);
    to.value(table::TABLE_VERSION, table::VERSION);
    to.value(table::SAMPLE_RATE, settings.sample_rate_hz());
    to.value(table::WINDOW, state.window_s);
    to.value(table::MODEL, coefficients.map_or(NO_MODEL, model_code));
    to.value(table::COEFFICIENTS_STATE, coefficients.map_or_else(|reason| reason, |_| Reason::None) as u8);
    let (image, _) = parts(settings.stored(Item::Coefficients));
    to.value(table::COEFFICIENTS_CRC, coefficients.map_or(0, |_| checksum(image)));
    to.bytes(table::ROBOT_NAME, settings.robot().name.as_bytes());
    to.value(table::UPTIME, state.time_us);
}

/// What the ROS node reads, where the stock firmware has it.
fn show_stock(state: &State<'_>, to: &mut impl Sink) {
    let State { pilot, panel, snapshot, .. } = state;
    let wheels = || snapshot.wheels.iter();
    let has_motors =
        !matches!(snapshot.drive.state, DriveState::Lost | DriveState::Unfit | DriveState::CutOff);
    let battery = state.battery_voltage();
    let charge = snapshot.battery.charge.map(|charge| 100.0 * charge.share);
    let percent = charge.or(battery.map(battery_percent));
    to.value(table::DEVICE_STATUS, if has_motors { 0_u8 } else { NO_MOTORS });
    to.value(table::HEARTBEAT, pilot.heartbeat());
    to.bytes(table::LEDS, &panel.leds);
    to.bytes(table::BUTTONS, &panel.buttons);
    to.bytes(table::BUMPERS, &[0; 2]);
    for absent in [table::ILLUMINATION, table::INFRARED, table::SONAR] {
        to.value(absent, 0.0);
    }
    let inertial = &state.inertial;
    to.values(table::LINEAR_ACCELERATION, inertial.acceleration.unwrap_or([0.0; 3]));
    to.values(table::MAGNETIC_FIELD, [0.0; 3]);
    to.value(table::BATTERY_VOLTAGE, battery.map_or(0, |voltage| (voltage * 100.0 + 0.5) as i32));
    to.value(table::BATTERY_PERCENT, percent.map_or(0, |percent| (percent * 100.0 + 0.5) as i32));
    to.value(table::SOUND, panel.sound);
    to.value(table::CALIBRATE_IMU, state.calibration());
    to.values(table::ANGULAR_VELOCITY, inertial.rotation.unwrap_or([0.0, 0.0, yaw_rate(snapshot)]));
    to.values(table::ORIENTATION, inertial.orientation.unwrap_or(state.heading.quaternion()));
    to.values(table::SERVO_LOAD, wheels().map(|wheel| i32::from(wheel.load_code)));
    to.values(table::SERVO_VELOCITY, wheels().map(|wheel| wheel.velocity_code));
    to.values(table::ODOMETER, wheels().map(|wheel| wheel.odometer.unwrap_or(0)));
    to.value(table::MOTORS_FOUND, u8::from(wheels().all(|wheel| wheel.health != WheelHealth::Absent)));
    to.value(table::TORQUE_ENABLE, u8::from(pilot.torque()));
    to.values(table::COMMAND_VELOCITY, pilot.commanded());
    to.values(table::PROFILE_ACCELERATION, pilot.profile());
}

/// rad/s, counter-clockwise, by the servos' own velocities.
fn yaw_rate(snapshot: &Snapshot) -> f32 {
    let [left, right] = snapshot.wheels.map(|wheel| Velocity(wheel.velocity_code).rad_per_s());
    (right - left) * (WHEEL_RADIUS_M / TRACK_M)
}

fn show_drive(state: &State<'_>, to: &mut impl Sink) {
    let State { pilot, reset, snapshot, .. } = state;
    let servos = &snapshot.servo_bus;
    to.value(table::RESET_CAUSE, reset.cause as u8);
    to.value(table::DRIVE_STATE, snapshot.drive.state as u8);
    to.values(table::SERVO_MISFIT, snapshot.wheels.iter().map(|wheel| wheel.misfit));
    to.value(table::RESET_ADDRESS, reset.address);
    to.value(table::RESET_FAILURES, reset.failures);
    to.values(table::DRIVE_GOALS, snapshot.drive.goals);
    to.value(table::COMMAND_TIMEOUT, pilot.command_timeout_ms());
    to.value(table::NODE_CONNECTED, u8::from(pilot.is_connected()));
    to.value(table::DRIVE_STOPS, pilot.stops());
    to.value(table::SERVO_REFUSED, servos.refused);
    to.value(table::SERVO_UNANSWERED, servos.unanswered_pings);
    to.value(table::SERVO_UNVERIFIED, servos.unverified);
    to.value(table::SERVO_TRIPPED, servos.tripped);
    to.value(table::SERVO_RESTARTS, servos.restarts);
    to.value(table::LINK_ABANDONED, state.counters.link_abandoned);
}

fn show_inertial(inertial: &InertialSnapshot, to: &mut impl Sink) {
    to.value(table::INERTIAL_STATE, inertial.health as u8);
    to.value(table::INERTIAL_CHIP, inertial.model.map_or(0, |model| model as u8));
    to.value(table::INERTIAL_ERRORS, inertial.errors);
    to.value(table::INERTIAL_RESTARTS, inertial.restarts);
    to.values(table::GYROSCOPE_BIAS, inertial.bias.unwrap_or([f32::NAN; 3]));
}

fn show_battery(battery: &BatterySnapshot, to: &mut impl Sink) {
    let BatterySnapshot { charge, resistance, remaining } = battery;
    to.value(table::BATTERY_CHARGE, charge.map(|charge| 100.0 * charge.share));
    to.value(table::BATTERY_CHARGE_STD, charge.map(|charge| 100.0 * charge.std));
    to.value(table::BATTERY_RESISTANCE, resistance.map(|(resistance, _)| resistance));
    to.value(table::BATTERY_RESISTANCE_STD, resistance.map(|(_, std)| std));
    to.value(table::BATTERY_ENERGY_LEFT, remaining.map(|battery| battery.energy / J_PER_WH));
    to.value(table::BATTERY_ENERGY_LOW, remaining.map(|battery| battery.energy_low / J_PER_WH));
    to.value(table::BATTERY_ENERGY_HIGH, remaining.map(|battery| battery.energy_high / J_PER_WH));
    to.value(table::BATTERY_TIME_LEFT, remaining.and_then(|battery| battery.time));
    to.value(table::BATTERY_LOAD, remaining.map(|battery| battery.load));
}

fn show_measurements(state: &State<'_>, to: &mut impl Sink) {
    let rails = || state.snapshot.rails.iter();
    to.values(table::RAIL_POWER, rails().map(|rail| rail.power));
    to.values(table::RAIL_VOLTAGE, rails().map(|rail| rail.voltage));
    to.values(table::RAIL_CURRENT, rails().map(|rail| rail.current));
    to.values(table::RAIL_ENERGY, rails().map(|rail| rail.energy));
    to.values(table::RAIL_HEALTH, rails().map(|rail| rail.health.code()));
    to.values(table::RAIL_COUNTERS, rails().flat_map(rail_counters));
    to.values(table::RAIL_IMPLAUSIBLE, rails().map(|rail| rail.counters.implausible));
    to.values(table::RAIL_CALIBRATION, state.settings.calibration().power_factors);
    let wheels = || state.snapshot.wheels.iter();
    to.values(table::WHEEL_HEALTH, wheels().map(|wheel| wheel.health as u8));
    to.values(table::WHEEL_HARDWARE_ERROR, wheels().map(|wheel| wheel.hardware_error));
    to.values(table::WHEEL_SPEED, wheels().map(|wheel| wheel.speed));
    to.values(table::WHEEL_ACCELERATION, wheels().map(|wheel| wheel.acceleration));
    to.values(table::WHEEL_POSITION, wheels().map(|wheel| wheel.position.unwrap_or(0)));
}

fn show_estimate(state: &State<'_>, to: &mut impl Sink) {
    let estimate = &state.snapshot.estimate;
    let mass = estimate.mass.known();
    to.value(table::PAYLOAD_STATE, mass_code(&estimate.mass));
    to.value(table::STANDSTILL, u8::from(state.snapshot.is_standing));
    to.value(table::MASS, mass.map(|mass| mass.mass));
    to.value(table::MASS_LOW, mass.map(|mass| mass.low));
    to.value(table::MASS_HIGH, mass.map(|mass| mass.high));
    to.value(table::MEASURED_POWER, estimate.measured_power);
    to.value(table::PREDICTED_POWER, estimate.predicted_power);
    to.value(table::MEASURED_ENERGY, estimate.measured_energy.unwrap_or(0.0));
    to.value(table::PREDICTED_ENERGY, estimate.predicted_energy.unwrap_or(0.0));
    to.value(table::MEASURED_SAMPLES, estimate.counted.measured);
    to.value(table::PREDICTED_SAMPLES, estimate.counted.predicted);
    to.value(table::PAYLOAD_CHANGES, estimate.changes.count);
    to.value(table::LAST_CHANGE, estimate.changes.last_us.unwrap_or(0));
}

fn show_counters(state: &State<'_>, to: &mut impl Sink) {
    let (counters, servo_bus) = (&state.counters, &state.snapshot.servo_bus);
    to.value(table::SAMPLES, state.snapshot.samples);
    to.value(table::MISSED_DEADLINES, counters.missed_deadlines);
    to.value(table::SERVO_TIMEOUTS, servo_bus.timeouts);
    to.value(table::SERVO_BROKEN, servo_bus.broken);
    to.value(table::BUS_ERRORS, counters.bus_errors);
    to.value(table::BUS_RECOVERIES, counters.bus_recoveries);
    to.value(table::LINK_PACKETS, counters.link_packets);
    to.value(table::LINK_BROKEN, counters.link_broken);
    to.value(table::FIFO_LOST, state.fifo.lost());
    to.value(table::STORE_WRITES, counters.store_writes);
}

fn show_upload(state: &State<'_>, to: &mut impl Sink) {
    let upload = &state.upload;
    let (stored, _) = parts(Item::from_code(upload.item).map_or(&[][..], |item| state.settings.stored(item)));
    to.value(table::UPLOAD_ITEM, upload.item);
    to.value(table::UPLOAD_COMMAND, 0_u8);
    to.value(table::UPLOAD_LENGTH, upload.length);
    to.value(table::UPLOAD_STATE, upload.state() as u8);
    to.value(table::UPLOAD_REASON, upload.reason() as u8);
    to.value(table::STORED_LENGTH, stored.len() as u16);
    to.bytes(table::UPLOAD_WINDOW, &upload.window);
    to.bytes(table::STORED_WINDOW, stored);
}

fn show_fifo(state: &State<'_>, to: &mut impl Sink) {
    let fifo = &state.fifo;
    to.value(table::FIFO_ACKNOWLEDGE, fifo.acknowledged());
    to.value(table::FIFO_OLDEST, fifo.oldest());
    to.value(table::FIFO_NEXT, fifo.next());
    to.value(table::FIFO_COUNT, fifo.window_count() as u16);
    to.value(table::RECORD_SIZE, RECORD_BYTES as u16);
    to.put(table::FIFO_WINDOW, Kind::U8, fifo.window());
}

fn show_store(state: &State<'_>, to: &mut impl Sink) {
    let totals = state.totals();
    to.values(table::TOTAL_ENERGY, totals.energy_mj);
    to.value(table::TOTAL_DISTANCE, totals.distance_cm);
    to.value(table::TOTAL_DRIVING_TIME, totals.driving_s);
    to.value(table::TOTAL_TIME, totals.on_s);
    to.value(table::TOTALS_WRITES, state.ledger.writes());
    to.value(table::STORE_ERASES, state.counters.store_erases);
    to.value(table::TOTALS_STATE, state.ledger.keeping() as u8);
    to.value(table::STORE_PREPARED, u8::from(state.is_store_prepared));
    to.value(table::PREVIOUS_CRC, checksum(state.settings.previous().image()));
    to.value(table::PREVIOUS_STATE, state.settings.previous_reason() as u8);
    to.value(table::NEEDS_SIGNATURE, u8::from(state.needs_signature));
    to.bytes(table::UPLOAD_SIGNATURE, &state.upload.signature);
}

fn rail_counters(rail: &RailSnapshot) -> [u32; 5] {
    let counters = rail.counters;
    [counters.fresh, counters.not_ready, counters.clipped, counters.no_answer, counters.set_up_lost]
}

#[cfg(test)]
mod tests;
