//! The INA219's handling on a mock bus that has the chip's registers. Values: TI SBOS448G, by
//! section.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::cell::{Cell, RefCell};

use embedded_hal_async::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use firmware::parameters::{RAILS, SENSOR_PROBE_SAMPLES};
use firmware::power_sensors::{Convert, Health, PowerSensor, PowerSensors, RAIL_COUNT, Reading};
use on_target_tests::{Failed, Outcome, close, ensure, now, tests};

tests!(
    reads_what_the_datasheet_reads,
    not_ready_is_no_reading,
    out_of_range_is_no_reading,
    gone_and_back,
    brown_out_is_found,
    a_dead_sensor_costs_its_own_rail,
);

/// After a power-on reset (8.6.2.1).
const RESET: u16 = 0x399F;
/// 32 V, ±320 mV, both as means of four 12-bit conversions, once.
const SET_UP: u16 = 0x3D53;
const CNVR: u16 = 0b10;
const OVF: u16 = 0b01;
/// The example of 9.2.2.1: 20 mV and 11.98 V.
const SHUNT: u16 = 0x07D0;
const BUS: u16 = 0x5D98;

#[derive(Clone, Copy)]
struct Chip {
    is_present: bool,
    configuration: u16,
    calibration: u16,
    shunt: u16,
    bus: u16,
}

struct Bus {
    chips: RefCell<[Chip; RAIL_COUNT]>,
    transactions: Cell<u32>,
}

impl Bus {
    fn new() -> Self {
        let chip =
            Chip { is_present: true, configuration: RESET, calibration: 0, shunt: SHUNT, bus: BUS | CNVR };
        Self { chips: RefCell::new([chip; RAIL_COUNT]), transactions: Cell::new(0) }
    }

    fn change(&self, rail: usize, change: impl Fn(&mut Chip)) {
        if let Some(chip) = self.chips.borrow_mut().get_mut(rail) {
            change(chip);
        }
    }
}

impl ErrorType for &Bus {
    type Error = ErrorKind;
}

impl Convert for &Bus {}

impl I2c for &Bus {
    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.transactions.set(self.transactions.get() + 1);
        let mut chips = self.chips.borrow_mut();
        let addresses = RAILS.map(|rail| rail.address.as_byte());
        let chip = chips.iter_mut().zip(addresses).find(|(chip, at)| chip.is_present && *at == address);
        let Some((chip, _)) = chip else {
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        };
        for pair in operations.as_chunks_mut().0 {
            let [Operation::Write([register, value @ ..]), Operation::Read(place)] = pair else {
                return Err(ErrorKind::Other);
            };
            if let [high, low] = value {
                let value = u16::from_be_bytes([*high, *low]);
                match register {
                    0x00 => chip.configuration = value,
                    0x05 => chip.calibration = value,
                    _ => return Err(ErrorKind::Other),
                }
            }
            let value = match register {
                0x00 => chip.configuration,
                0x01 => chip.shunt,
                0x02 => chip.bus,
                // 8.5.2
                0x03 => {
                    let current = u32::from(chip.shunt.cast_signed().unsigned_abs())
                        * u32::from(chip.calibration)
                        / 4096;
                    (current * u32::from(chip.bus >> 3) / 5000) as u16
                }
                0x05 => chip.calibration,
                _ => 0,
            };
            place.copy_from_slice(&value.to_be_bytes());
        }
        Ok(())
    }
}

/// Polls once and checks health and whether there is a reading.
fn poll(
    sensor: &mut PowerSensor<&Bus>,
    has_reading: bool,
    health: Health,
) -> Result<Option<Reading>, Failed> {
    let reading = now(sensor.poll())?;
    let found = sensor.status().health();
    ensure(
        reading.is_some() == has_reading && found == health,
        format_args!("{reading:?}, {found:?}; expected a reading: {has_reading}, {health:?}"),
    )?;
    Ok(reading)
}

fn reads_what_the_datasheet_reads() -> Outcome {
    let bus = Bus::new();
    let mut sensor = PowerSensor::new(&bus, RAILS[1]);
    let reading = poll(&mut sensor, true, Health::Ok)?.ok_or(Failed)?;
    let configuration = bus.chips.borrow()[1].configuration;
    ensure(configuration == SET_UP, format_args!("configuration {configuration:#06x}"))?;
    // 20 mV over 0.1 Ω at 11.98 V. Each figure passes four roundings at the most.
    let shunt = sensor.rail().shunt;
    close(format_args!("current"), reading.current_a(shunt), 0.2, 5e-7 * 0.2)?;
    close(format_args!("voltage"), reading.bus_v(), 11.98, 5e-7 * 11.98)?;
    close(format_args!("power"), reading.power_w(shunt), 2.396, 5e-7 * 2.396)?;
    sensor.set_power_factor(1.002);
    close(format_args!("calibrated"), reading.power_w(sensor.rail().shunt), 2.396 * 1.002, 5e-7 * 2.4)
}

fn not_ready_is_no_reading() -> Outcome {
    let bus = Bus::new();
    let mut sensor = PowerSensor::new(&bus, RAILS[1]);
    poll(&mut sensor, true, Health::Ok)?;
    bus.change(1, |chip| chip.bus = BUS);
    poll(&mut sensor, false, Health::Ok)?;
    poll(&mut sensor, false, Health::Ok)?;
    poll(&mut sensor, false, Health::Stale)?;
    bus.change(1, |chip| chip.bus = BUS | CNVR);
    poll(&mut sensor, true, Health::Ok)?;
    ensure(sensor.status().counters().not_ready == 3, format_args!("{:?}", sensor.status().counters()))
}

/// OVF, and both ends of ±320 mV: 7D00h and 8300h (8.6.3.1).
fn out_of_range_is_no_reading() -> Outcome {
    let bus = Bus::new();
    let mut sensor = PowerSensor::new(&bus, RAILS[1]);
    for (flags, shunt) in [(CNVR | OVF, SHUNT), (CNVR, 0x7D00), (CNVR, 0x8300)] {
        bus.change(1, |chip| (chip.bus, chip.shunt) = (BUS | flags, shunt));
        poll(&mut sensor, false, Health::Overflow)?;
    }
    bus.change(1, |chip| (chip.bus, chip.shunt) = (BUS | CNVR, 0x8301));
    let reading = poll(&mut sensor, true, Health::Ok)?.ok_or(Failed)?;
    close(format_args!("braking"), reading.current_a(sensor.rail().shunt), -3.1999, 5e-7 * 3.2)
}

fn gone_and_back() -> Outcome {
    let bus = Bus::new();
    let mut sensor = PowerSensor::new(&bus, RAILS[1]);
    poll(&mut sensor, true, Health::Ok)?;
    bus.change(1, |chip| (chip.is_present, chip.configuration, chip.calibration) = (false, RESET, 0));
    poll(&mut sensor, false, Health::Ok)?;
    poll(&mut sensor, false, Health::Ok)?;
    poll(&mut sensor, false, Health::Absent)?;
    bus.change(1, |chip| chip.is_present = true);
    poll(&mut sensor, true, Health::Ok)?;
    let configuration = bus.chips.borrow()[1].configuration;
    ensure(configuration == SET_UP, format_args!("configuration {configuration:#06x}"))
}

/// The chip converts on with what it starts with: its product is 0, and it is set up.
fn brown_out_is_found() -> Outcome {
    let bus = Bus::new();
    let mut sensor = PowerSensor::new(&bus, RAILS[1]);
    poll(&mut sensor, true, Health::Ok)?;
    bus.change(1, |chip| (chip.configuration, chip.calibration) = (RESET, 0));
    let mut lost = 0;
    for _ in 0..20 {
        if now(sensor.poll())?.is_none() {
            lost += 1;
            ensure(
                sensor.status().health() == Health::LostCalibration,
                format_args!("{:?}", sensor.status()),
            )?;
        }
    }
    let configuration = bus.chips.borrow()[1].configuration;
    ensure(
        lost == 1 && configuration == SET_UP,
        format_args!("{lost} lost, configuration {configuration:#06x}"),
    )?;
    poll(&mut sensor, true, Health::Ok)?;
    ensure(sensor.status().counters().set_up_lost == 1, format_args!("{:?}", sensor.status().counters()))
}

fn a_dead_sensor_costs_its_own_rail() -> Outcome {
    let bus = Bus::new();
    bus.change(2, |chip| chip.is_present = false);
    let mut sensors = PowerSensors::new(&bus);
    for poll in 0..u64::from(2 * SENSOR_PROBE_SAMPLES) {
        let [battery, motors, computer, lidar] =
            now(sensors.poll(5_000 * poll))?.map(|reading| reading.is_some());
        ensure(battery && motors && !computer && lidar, format_args!("poll {poll}"))?;
    }
    let [_, _, computer, _] = sensors.statuses();
    let asked = computer.counters().no_answer;
    ensure(asked == 3 + 2, format_args!("asked {asked} times"))?;
    bus.change(2, |chip| chip.is_present = true);
    for poll in 0..u64::from(SENSOR_PROBE_SAMPLES) {
        now(sensors.poll(1_000_000 + 5_000 * poll))?;
    }
    let [_, _, computer, _] = sensors.statuses();
    ensure(computer.health() == Health::Ok, format_args!("{computer:?}"))
}
