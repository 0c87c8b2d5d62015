//! The parameters file: everything that another robot, or another taste, changes without touching
//! code.
//!
//! What a fit finds is not here but in the coefficients; what belongs to a chip is where its
//! registers are.

use ina219::address::{Address, Pin};
use ina219::configuration::{
    BusVoltageRange, Configuration, MeasuredSignals, OperatingMode, Reset, Resolution, ShuntVoltageRange,
};

use model_core::charge::Pack;

use crate::power_sensors::{RAIL_COUNT, Rail, RailName, Shunt};
use crate::wheels::{Servo, WHEELS};

/// Samples per second, Hz. Not above 213: the sensors would not have finished a conversion
/// ([`SENSOR_SET_UP`]).
pub const SAMPLE_RATE_HZ: u32 = 200;
/// Time between samples, µs.
pub const SAMPLE_PERIOD_US: u64 = 1_000_000 / SAMPLE_RATE_HZ as u64;

/// Length of the window over which the mass is estimated, s; as `gmr estimate`.
pub const WINDOW_S: usize = 25;
/// Length of a bucket, s: how often the mass is estimated anew. Divides the window.
pub const BUCKET_S: usize = 1;
/// Room for buckets. A gap that outlasts them forgets more than the window holds.
pub const MOST_BUCKETS: usize = model_core::board::BUCKETS;

/// Clock of the power sensors' bus, Hz. At 400 kHz a register takes 120 µs, four sensors with three
/// each 1.5 ms.
pub const SENSOR_BUS_HZ: u32 = 400_000;

/// What each power sensor is set to: 32 V, which no rail reaches, ±320 mV, both voltages once, when
/// a poll asks for it, as means of four 12-bit conversions.
///
/// The two means take 2 × 2.13 ms, at most 2 × 2.34 ms (INA219 datasheet 7.5, 8.6.2.1), so each
/// poll of a 5 ms period finds those that the one before has started. It has to differ from what
/// the chip starts with, so that a supply that broke down shows.
pub const SENSOR_SET_UP: Configuration = Configuration {
    reset: Reset::Run,
    bus_voltage_range: BusVoltageRange::Fsr32v,
    shunt_voltage_range: ShuntVoltageRange::Fsr320mv,
    bus_resolution: Resolution::Avg4,
    shunt_resolution: Resolution::Avg4,
    operating_mode: OperatingMode::Triggered(MeasuredSignals::ShutAndBusVoltage),
};

/// As fitted to common INA219 modules: 0.1 Ω, so the sensor saturates at 3.2 A. Two stalled wheel
/// servos draw 2.6 A.
const MODULE_SHUNT: Shunt = Shunt { ohm: 0.1, power_factor: 1.0 };

/// The four sensors, in the order of the control table. Their addresses differ in the module's two
/// solder pads, A1 and A0.
pub const RAILS: [Rail; RAIL_COUNT] = [
    rail(RailName::Battery, Address::from_pins(Pin::Gnd, Pin::Gnd)),
    rail(RailName::Motors, Address::from_pins(Pin::Vcc, Pin::Gnd)),
    rail(RailName::Computer, Address::from_pins(Pin::Gnd, Pin::Vcc)),
    rail(RailName::Lidar, Address::from_pins(Pin::Vcc, Pin::Vcc)),
];

const fn rail(name: RailName, address: Address) -> Rail {
    Rail { name, address, shunt: MODULE_SHUNT, set_up: SENSOR_SET_UP }
}

/// A rail whose sensor has gone is asked again once in so many samples: a bus that has to time out
/// first would cost the other rails theirs. Divisible by the number of rails, whose turns are
/// spread over it.
pub const SENSOR_PROBE_SAMPLES: u32 = 20;

/// The wheels' servos, left and right. The factory's set-up of a TurtleBot3 reverses the right one
/// in the servo itself.
pub const SERVOS: [Servo; WHEELS] = [Servo { id: 1, reversed: false }, Servo { id: 2, reversed: false }];
/// Bits per second on the servo bus, ten for each byte.
pub const SERVO_BAUD: u32 = 1_000_000;
/// What a servo waits before it answers, µs: register 9, as the factory sets it.
pub const SERVO_RETURN_DELAY_US: u32 = 500;
/// How much later than it should be an answer may be, µs.
pub const SERVO_MARGIN_US: u32 = 500;
/// A servo that has gone is sought again after this time, µs.
pub const SERVO_PROBE_US: u64 = 100_000;

/// Drive mode that a servo is set to at the factory, left and right (register 10): the right one
/// counts the other way round.
pub const SERVO_DRIVE_MODES: [u8; WHEELS] = [0, 1];
/// Without an instruction for so long, a servo stops by itself, in units of 20 ms (register 98).
/// They are asked 200 times a second.
pub const SERVO_WATCHDOG: u8 = 10;
/// Goals are sent again after this time though they have not changed, µs.
pub const GOAL_PERIOD_US: u64 = 20_000;
/// How often goals and watchdog, or torque and errors, are read back, µs: each of the two ten times
/// a second.
pub const VERIFY_PERIOD_US: u64 = 50_000;
/// A write that a servo did not acknowledge is tried again after this time, µs.
pub const SERVO_RETRY_US: u64 = 20_000;

/// Radius of the wheels that are driven, m: a TurtleBot3 Burger's.
pub const WHEEL_RADIUS_M: f32 = 0.033;
/// Distance between them, m.
pub const TRACK_M: f32 = 0.160;
/// What the stock firmware lets a Burger drive: 61 rev/min of its wheels, m/s.
pub const HIGHEST_LINEAR_M_S: f32 = 61.0 / 60.0 * core::f32::consts::TAU * WHEEL_RADIUS_M;
/// Likewise on the spot, rad/s.
pub const HIGHEST_ANGULAR_RAD_S: f32 = HIGHEST_LINEAR_M_S / (TRACK_M / 2.0);

/// No wheel accelerates faster, rad/s²: half of what a servo's stall torque (1.4 N·m) does to a
/// wheel that carries nothing (some 0.0035 kg·m² with the gear's rotor).
pub const WHEEL_ACCELERATION_RAD_S2: f32 = 200.0;
/// How much the servo's own velocity register may lag, s. Not documented: an assumption.
pub const SERVO_VELOCITY_LAG_S: f32 = 0.02;

/// Wheels slower than this are at rest, rad/s, while no coefficients say better.
pub const DEAD_BAND_RAD_S: f32 = 0.02;
/// How long the wheels have to have been at rest before the flash may be written, µs: writing stops
/// the processor.
pub const STANDSTILL_US: u64 = 1_000_000;

/// The battery: capacity, cells, their curve, and the voltage at which the motors are cut off.
#[must_use]
pub fn battery_pack() -> Pack<f32> {
    Pack::turtlebot3()
}

/// Samples further apart than this do not follow one another, µs: five periods, as model-core's
/// estimator has it.
pub const LONGEST_STEP_US: u64 = 5 * SAMPLE_PERIOD_US;

const _: () = assert!(SAMPLE_RATE_HZ <= 213 && 1_000_000 % SAMPLE_RATE_HZ == 0);
const _: () = assert!(WINDOW_S.is_multiple_of(BUCKET_S) && WINDOW_S / BUCKET_S < MOST_BUCKETS);
const _: () = assert!(SENSOR_PROBE_SAMPLES.is_multiple_of(RAIL_COUNT as u32));

#[cfg(test)]
mod tests {
    use super::*;

    /// INA219 datasheet 8.5.5.1, and two sensors at one address would answer both.
    #[test]
    fn addresses_are_the_four_pad_combinations() {
        assert_eq!(RAILS.map(|rail| rail.address.as_byte()), [0x40, 0x41, 0x44, 0x45]);
    }

    /// Else a brown-out would not show. The crate's default is the chip's after a reset (8.6.2.1).
    #[test]
    fn no_sensor_starts_with_its_set_up() {
        for rail in RAILS {
            assert_ne!(rail.set_up, Configuration::default());
        }
    }
}
