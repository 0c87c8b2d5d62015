//! An INA219, INA226 or INA260 on the computer's own I²C bus.
//!
//! The INA219 is read by the board's code ([`PowerSensor`]). The INA226 and INA260 share their
//! registers but for the one of the current; the only driver of the INA260 wants the `embedded-hal`
//! of 2019, so one reader of both stands here. Source of its facts: TI SBOS547 (INA226), SBOS656
//! (INA260), by register.

use std::path::PathBuf;

use embassy_futures::block_on;
use embedded_hal::i2c::{ErrorType, I2c, Operation};
use firmware::power_sensors::{Event, PowerSensor, RAILS, Rail, Shunt};
use linux_embedded_hal::I2cdev;
use logs::robot::{NodeSettings, PowerChip};
use support::error::{Error, Result};

use super::power::{PowerSource, Reading};

/// Time between two polls, s: no chip converts faster as it is set up here.
const POLL_S: f64 = 0.01;
/// A bus that could not be opened is tried again after this, s.
const RETRY_S: f64 = 1.0;

/// An asynchronous bus that waits: the board's driver wants one.
struct Waiting<I>(I);

impl<I: ErrorType> ErrorType for Waiting<I> {
    type Error = I::Error;
}

impl<I: I2c> embedded_hal_async::i2c::I2c for Waiting<I> {
    async fn read(&mut self, address: u8, into: &mut [u8]) -> std::result::Result<(), I::Error> {
        self.0.read(address, into)
    }

    async fn write(&mut self, address: u8, bytes: &[u8]) -> std::result::Result<(), I::Error> {
        self.0.write(address, bytes)
    }

    async fn write_read(
        &mut self,
        address: u8,
        bytes: &[u8],
        into: &mut [u8],
    ) -> std::result::Result<(), I::Error> {
        self.0.write_read(address, bytes, into)
    }

    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> std::result::Result<(), I::Error> {
        self.0.transaction(address, operations)
    }
}

/// What a poll gave: a reading in W and V where there is one.
type Polled = (Event, Option<Reading>);

enum Chip<I> {
    Ina219(PowerSensor<Waiting<I>>, Shunt),
    Other(Ina226<I>),
}

impl<I: I2c> Chip<I> {
    fn new(bus: I, settings: &NodeSettings) -> Result<Self> {
        if settings.sensor != PowerChip::Ina219 {
            return Ok(Self::Other(Ina226::new(bus, settings)));
        }
        let address = ina219::address::Address::from_byte(settings.address)
            .map_err(|_| Error::usage(format!("address {:#04x}; expected 0x40 to 0x4f", settings.address)))?;
        let shunt = Shunt { ohm: settings.shunt_ohm as f32, power_factor: 1.0 };
        let [battery, ..] = RAILS;
        let sensor = PowerSensor::new(Waiting(bus), Rail { address, shunt, ..battery });
        Ok(Self::Ina219(sensor, shunt))
    }

    fn poll(&mut self) -> Polled {
        match self {
            Self::Other(chip) => chip.poll(),
            Self::Ina219(sensor, shunt) => {
                let before = sensor.status().counters();
                let reading = block_on(sensor.poll()).map(|reading| Reading {
                    power_w: f64::from(reading.power_w(*shunt)),
                    voltage_v: f64::from(reading.bus_v()),
                });
                let after = sensor.status().counters();
                let event = if reading.is_some() {
                    Event::Fresh
                } else if after.clipped > before.clipped {
                    Event::Clipped
                } else if after.set_up_lost > before.set_up_lost {
                    Event::SetUpLost
                } else if after.implausible > before.implausible {
                    Event::Implausible
                } else if after.no_answer > before.no_answer {
                    Event::NoAnswer
                } else {
                    Event::NotReady
                };
                (event, reading)
            }
        }
    }
}

/// Registers of INA226 and INA260.
const CONFIGURATION: u8 = 0x00;
const SHUNT_OR_CURRENT: u8 = 0x01;
const BUS_VOLTAGE: u8 = 0x02;
const MASK_ENABLE: u8 = 0x06;
const DIE: u8 = 0xFF;
/// A conversion has ended since this was read last.
const CONVERSION_READY: u16 = 1 << 3;
/// Weight of one count of the bus voltage, V.
const BUS_VOLTS: f64 = 1.25e-3;
/// Weight of one count across the INA226's shunt, V.
const SHUNT_VOLTS: f64 = 2.5e-6;
/// Weight of one count of the INA260's current, A.
const CURRENT_AMPERES: f64 = 1.25e-3;
/// Both voltages continuously, 1.1 ms each, four averaged (AVG 001, CT 100, MODE 111): 8.8 ms. It
/// differs from what the chips start with, 4127h and 6127h, so that a supply that broke down shows.
const MEASURING: u16 = 0x0327;
/// The configuration is read back once in so many polls.
const POLLS_PER_CHECK: u32 = 50;

/// An INA226, or an INA260, which has its shunt inside.
struct Ina226<I> {
    bus: I,
    address: u8,
    /// A for a count of [`SHUNT_OR_CURRENT`].
    amperes: f64,
    /// Bits 15 to 12 are the chip's own (register 00h).
    set_up: u16,
    /// Bits 15 to 4 of the die's register.
    die: u16,
    is_set_up: bool,
    polls: u32,
}

impl<I: I2c> Ina226<I> {
    fn new(bus: I, settings: &NodeSettings) -> Self {
        let (amperes, reserved, die) = match settings.sensor {
            PowerChip::Ina260 => (CURRENT_AMPERES, 0x6000, 0x227),
            _ => (SHUNT_VOLTS / settings.shunt_ohm, 0x4000, 0x226),
        };
        let set_up = reserved | MEASURING;
        Self { bus, address: settings.address, amperes, set_up, die, is_set_up: false, polls: 0 }
    }

    fn read(&mut self, register: u8) -> std::result::Result<u16, I::Error> {
        let mut word = [0; 2];
        self.bus.write_read(self.address, &[register], &mut word)?;
        Ok(u16::from_be_bytes(word))
    }

    fn poll(&mut self) -> Polled {
        let polled = self.ask().unwrap_or((Event::NoAnswer, None));
        if matches!(polled.0, Event::NoAnswer | Event::SetUpLost) {
            self.is_set_up = false;
        }
        polled
    }

    fn ask(&mut self) -> std::result::Result<Polled, I::Error> {
        self.polls += 1;
        if !self.is_set_up {
            // Another chip at this address would give numbers as well, and wrong ones.
            if self.read(DIE)? >> 4 != self.die {
                return Ok((Event::NoAnswer, None));
            }
            let [high, low] = self.set_up.to_be_bytes();
            self.bus.write(self.address, &[CONFIGURATION, high, low])?;
            self.is_set_up = true;
        } else if self.polls.is_multiple_of(POLLS_PER_CHECK) && self.read(CONFIGURATION)? != self.set_up {
            return Ok((Event::SetUpLost, None));
        }
        if self.read(MASK_ENABLE)? & CONVERSION_READY == 0 {
            return Ok((Event::NotReady, None));
        }
        let code = self.read(SHUNT_OR_CURRENT)? as i16;
        let bus = self.read(BUS_VOLTAGE)?;
        if code == i16::MAX || code == i16::MIN {
            return Ok((Event::Clipped, None));
        }
        let voltage_v = f64::from(bus) * BUS_VOLTS;
        Ok((Event::Fresh, Some(Reading { power_w: f64::from(code) * self.amperes * voltage_v, voltage_v })))
    }
}

/// The sensor that robot.toml names, sought again where it has gone.
pub struct Sensor {
    settings: NodeSettings,
    chip: Option<Chip<I2cdev>>,
    next_s: f64,
    counts: [(&'static str, u64); 4],
}

impl Sensor {
    /// Of a bus that is there.
    ///
    /// # Errors
    /// The bus cannot be opened: with what to do about it.
    pub fn open(settings: &NodeSettings) -> Result<Self> {
        let chip = Some(Self::chip(settings)?);
        let counts = [
            ("power sensor clipped", 0),
            ("power sensor without answer", 0),
            ("power sensor lost its set-up", 0),
            ("power sensor disagreed with itself", 0),
        ];
        Ok(Self { settings: settings.clone(), chip, next_s: 0.0, counts })
    }

    fn chip(settings: &NodeSettings) -> Result<Chip<I2cdev>> {
        let bus = I2cdev::new(&settings.bus).map_err(|error| {
            let path = PathBuf::from(&settings.bus);
            Error::failed(format!(
                "{error}; expected an I²C bus that may be opened (on a Raspberry Pi: raspi-config, and the group i2c)"
            ))
            .in_file(path)
        })?;
        Chip::new(bus, settings)
    }
}

impl PowerSource for Sensor {
    fn take(&mut self, now: f64) -> Result<Vec<(f64, Reading)>> {
        if now < self.next_s {
            return Ok(Vec::new());
        }
        self.next_s = now + POLL_S;
        let Some(chip) = &mut self.chip else {
            // An adapter that was pulled out may come back.
            self.chip = Self::chip(&self.settings).ok();
            self.next_s = now + RETRY_S;
            return Ok(Vec::new());
        };
        let (event, reading) = chip.poll();
        match event {
            Event::Clipped => self.counts[0].1 += 1,
            Event::NoAnswer => {
                self.counts[1].1 += 1;
                if !std::path::Path::new(&self.settings.bus).exists() {
                    self.chip = None;
                }
            }
            Event::SetUpLost => self.counts[2].1 += 1,
            Event::Implausible => self.counts[3].1 += 1,
            Event::Fresh | Event::NotReady => {}
        }
        Ok(reading.map(|reading| (now, reading)).into_iter().collect())
    }

    fn faults(&self) -> Vec<(&'static str, u64)> {
        self.counts.iter().copied().filter(|(_, count)| *count > 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};

    use super::*;

    const ADDRESS: u8 = 0x40;

    fn settings(sensor: PowerChip) -> NodeSettings {
        NodeSettings { sensor, shunt_ohm: 0.002, ..NodeSettings::default() }
    }

    fn read(register: u8, value: u16) -> Transaction {
        Transaction::write_read(ADDRESS, vec![register], value.to_be_bytes().to_vec())
    }

    fn write(register: u8, value: u16) -> Transaction {
        let [high, low] = value.to_be_bytes();
        Transaction::write(ADDRESS, vec![register, high, low])
    }

    /// Written and read back.
    fn set(register: u8, value: u16) -> Transaction {
        let [high, low] = value.to_be_bytes();
        Transaction::write_read(ADDRESS, vec![register, high, low], vec![high, low])
    }

    fn play(sensor: PowerChip, transcript: &[Transaction], polls: usize) -> Vec<Polled> {
        let mut bus = Mock::new(transcript);
        let mut chip = Chip::new(bus.clone(), &settings(sensor)).unwrap();
        let polled = (0..polls).map(|_| chip.poll()).collect();
        bus.done();
        polled
    }

    fn near(polled: &Polled, power_w: f64, voltage_v: f64) {
        let reading = polled.1.unwrap();
        assert!((reading.power_w - power_w).abs() < 1e-3 * power_w.abs(), "{reading:?}");
        assert!((reading.voltage_v - voltage_v).abs() < 1e-9 + 1e-3 * voltage_v, "{reading:?}");
    }

    /// The example of the INA226's datasheet (8.2.2.1): 10 A through 2 mΩ, 11.98 V behind it: shunt
    /// 8000, bus 9584, 119.8 W.
    #[test]
    fn ina226_datasheet_example() {
        let polled = play(
            PowerChip::Ina226,
            &[
                read(DIE, 0x2260),
                write(CONFIGURATION, 0x4327),
                read(MASK_ENABLE, 0),
                read(MASK_ENABLE, CONVERSION_READY),
                read(SHUNT_OR_CURRENT, 8000),
                read(BUS_VOLTAGE, 9584),
            ],
            2,
        );
        assert_eq!(polled[0], (Event::NotReady, None));
        near(&polled[1], 119.8, 11.98);
    }

    /// −2 A are −1600 counts of 1.25 mA; 12 V are 9600 of 1.25 mV: braking flows back.
    #[test]
    fn ina260_measures_current_itself_and_with_its_sign() {
        let polled = play(
            PowerChip::Ina260,
            &[
                read(DIE, 0x2270),
                write(CONFIGURATION, 0x6327),
                read(MASK_ENABLE, CONVERSION_READY),
                read(SHUNT_OR_CURRENT, (-1600_i16) as u16),
                read(BUS_VOLTAGE, 9600),
            ],
            1,
        );
        near(&polled[0], -24.0, 12.0);
    }

    /// Another chip is none; a full scale is clipped; whoever lost its set-up is set up again.
    #[test]
    fn what_cannot_be_believed_is_no_reading() {
        let polled = play(
            PowerChip::Ina226,
            &[
                read(DIE, 0x2270),
                read(DIE, 0x2260),
                write(CONFIGURATION, 0x4327),
                read(MASK_ENABLE, CONVERSION_READY),
                read(SHUNT_OR_CURRENT, 0x7FFF),
                read(BUS_VOLTAGE, 9584),
            ],
            2,
        );
        assert_eq!(polled, [(Event::NoAnswer, None), (Event::Clipped, None)]);
    }

    /// The board's driver on a computer's bus, with the INA219's example (SBOS448G 9.2.2.1): 20 mV
    /// across 2 mΩ, 11.98 V.
    #[test]
    fn ina219_is_read_by_the_boards_driver() {
        let polled = play(
            PowerChip::Ina219,
            &[
                set(0x05, 0x1000),
                set(0x00, 0x3D53),
                Transaction::transaction_start(ADDRESS),
                Transaction::write(ADDRESS, vec![0x02]),
                Transaction::read(ADDRESS, vec![0x5D, 0x98 | 0b10]),
                Transaction::write(ADDRESS, vec![0x00, 0x3D, 0x53]),
                Transaction::read(ADDRESS, vec![0x3D, 0x53]),
                Transaction::write(ADDRESS, vec![0x01]),
                Transaction::read(ADDRESS, vec![0x07, 0xD0]),
                Transaction::write(ADDRESS, vec![0x03]),
                Transaction::read(ADDRESS, 1198_u16.to_be_bytes().to_vec()),
                Transaction::transaction_end(ADDRESS),
            ],
            1,
        );
        near(&polled[0], 119.8, 11.98);
    }
}
