//! One INA219: sets it up, polls it, keeps its health.

use embedded_hal_async::i2c::I2c;
use ina219::AsyncIna219;
use ina219::calibration::UnCalibrated;
use ina219::errors::{BusVoltageReadError, ConfigurationReadError, ShuntVoltageReadError};

use super::{Event, Rail, Reading, Status};

/// The configuration is read back once in so many polls: ten times a second at 200 Hz.
const POLLS_PER_CHECK: u8 = 20;

/// The sensor of one rail. Owns its handle of the bus; a shared bus hands out one for each.
///
/// The chip's calibration register stays 0: power is computed here, from the two voltages. What a supply that broke
/// down loses, and what is read back, is therefore the configuration.
pub struct PowerSensor<I> {
    rail: Rail,
    chip: AsyncIna219<I, UnCalibrated>,
    status: Status,
    /// Whether the chip has the rail's set-up, as far as is known.
    is_set_up: bool,
    polls_to_check: u8,
}

impl<I: I2c> PowerSensor<I> {
    /// A sensor that the first poll sets up. Nothing is sent yet.
    pub fn new(i2c: I, rail: Rail) -> Self {
        let chip = AsyncIna219::new_unchecked(i2c, rail.address, UnCalibrated);
        Self { rail, chip, status: Status::new(), is_set_up: false, polls_to_check: POLLS_PER_CHECK }
    }

    /// Where the sensor sits.
    #[must_use]
    pub fn rail(&self) -> Rail {
        self.rail
    }

    /// From now on true power is measured power times `factor`: a calibration from the store.
    pub fn set_power_factor(&mut self, factor: f32) {
        self.rail.shunt.power_factor = factor;
    }

    /// Whether it can be believed, and its counters.
    #[must_use]
    pub fn status(&self) -> Status {
        self.status
    }

    /// Gives the bus back.
    pub fn release(self) -> I {
        self.chip.destroy()
    }

    /// Asks the sensor once. A reading when it has a new one within range; the status says why when not.
    ///
    /// Errors stay here: one dead sensor costs its own rail only. Poll no faster than the chip converts: a conversion
    /// that ends between the two reads of a poll is lost.
    pub async fn poll(&mut self) -> Option<Reading> {
        let (event, reading) = self.ask().await;
        if matches!(event, Event::NoAnswer | Event::SetUpLost) {
            // Whoever was away may have lost its set-up.
            self.is_set_up = false;
        }
        self.status.observe(event);
        reading
    }

    async fn ask(&mut self) -> (Event, Option<Reading>) {
        if !self.is_set_up {
            if self.chip.set_configuration(self.rail.set_up).await.is_err() {
                return (Event::NoAnswer, None);
            }
            self.is_set_up = true;
            self.polls_to_check = POLLS_PER_CHECK;
        }

        self.polls_to_check = self.polls_to_check.saturating_sub(1);
        if self.polls_to_check == 0 {
            self.polls_to_check = POLLS_PER_CHECK;
            match self.chip.configuration().await {
                Ok(found) if found == self.rail.set_up => {}
                Ok(_) | Err(ConfigurationReadError::ConfigurationMismatch { .. }) => {
                    return (Event::SetUpLost, None);
                }
                Err(ConfigurationReadError::I2cError(_)) => return (Event::NoAnswer, None),
            }
        }

        // Reading the bus voltage changes nothing in the chip; reading the power register clears CNVR (8.6.3.2).
        let bus = match self.chip.bus_voltage().await {
            Ok(bus) => bus,
            Err(BusVoltageReadError::BusVoltageOutOfRange { .. }) => return (Event::Clipped, None),
            Err(BusVoltageReadError::I2cError(_)) => return (Event::NoAnswer, None),
        };
        if !bus.is_conversion_ready() {
            return (Event::NotReady, None);
        }
        let shunt = self.chip.shunt_voltage().await;
        if self.chip.power_raw().await.is_err() {
            return (Event::NoAnswer, None);
        }
        match shunt {
            Err(ShuntVoltageReadError::I2cError(_)) => (Event::NoAnswer, None),
            Err(ShuntVoltageReadError::ShuntVoltageOutOfRange { .. }) => (Event::Clipped, None),
            Ok(shunt)
                if bus.has_math_overflowed()
                    || shunt.shunt_voltage_10uv().unsigned_abs() >= self.full_scale_10uv() =>
            {
                (Event::Clipped, None)
            }
            Ok(shunt) => (Event::Fresh, Some(Reading { shunt, bus })),
        }
    }

    /// The last code of the shunt register in the range that is set, in 10 µV: a reading there is clipped (8.6.3.1).
    fn full_scale_10uv(&self) -> u16 {
        self.rail.set_up.shunt_voltage_range.range_mv().end().unsigned_abs().saturating_mul(100)
    }
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};

    use super::*;
    use crate::parameters::RAILS;
    use crate::power_sensors::Health;
    use crate::testing::now;

    const ADDRESS: u8 = 0x41;
    const CONFIGURED: u16 = 0x3D57;
    /// After a power-on reset (8.6.2.1).
    const RESET: u16 = 0x399F;
    /// The datasheet's example (9.2.2.1): 20 mV; 11.98 V, with CNVR.
    const SHUNT: u16 = 0x07D0;
    const BUS: u16 = 0x5D98 | CNVR;
    const CNVR: u16 = 0b10;
    const OVF: u16 = 0b01;
    const READING: (i16, u16) = (2000, 11_980);

    fn write(register: u8, value: u16) -> Transaction {
        let [high, low] = value.to_be_bytes();
        Transaction::write(ADDRESS, vec![register, high, low])
    }

    fn read(register: u8, value: u16) -> Transaction {
        Transaction::write_read(ADDRESS, vec![register], value.to_be_bytes().to_vec())
    }

    fn not_acknowledged(transaction: Transaction) -> Transaction {
        transaction.with_error(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address))
    }

    fn set_up() -> Transaction {
        write(0x00, CONFIGURED)
    }

    fn conversion() -> [Transaction; 3] {
        [read(0x02, BUS), read(0x01, SHUNT), read(0x03, 0)]
    }

    /// Polls until the transcript is used up: (shunt in 10 µV, bus in mV) and health after each poll.
    fn play(transcript: &[Transaction], polls: usize) -> Vec<(Option<(i16, u16)>, Health)> {
        let mut sensor = PowerSensor::new(Mock::new(transcript), RAILS[1]);
        let results = (0..polls)
            .map(|_| {
                let reading = now(sensor.poll());
                let voltages = reading.map(|r| (r.shunt.shunt_voltage_10uv(), r.bus.voltage_mv()));
                (voltages, sensor.status().health())
            })
            .collect();
        sensor.release().done();
        results
    }

    #[test]
    fn sets_up_once_then_reads() {
        let mut transcript = vec![set_up()];
        transcript.extend(conversion());
        transcript.extend(conversion());
        assert_eq!(play(&transcript, 2), [(Some(READING), Health::Ok); 2]);
    }

    #[test]
    fn no_new_conversion_reads_nothing_else() {
        let mut transcript = vec![set_up()];
        transcript.extend(conversion());
        transcript.extend([read(0x02, BUS & !CNVR), read(0x02, BUS & !CNVR), read(0x02, BUS & !CNVR)]);
        transcript.extend(conversion());
        let (ok, missing, stale) = ((Some(READING), Health::Ok), (None, Health::Ok), (None, Health::Stale));
        assert_eq!(play(&transcript, 5), [ok, missing, missing, stale, ok]);
    }

    /// The overflow flag, and both ends of the ±320 mV range (7D00h and 8300h), cost the reading but not the next one.
    #[test]
    fn overflow() {
        let mut transcript = vec![set_up()];
        for (bus, shunt) in [(BUS | OVF, SHUNT), (BUS, 0x7D00), (BUS, 0x8300), (BUS, 0x7D01)] {
            transcript.extend([read(0x02, bus), read(0x01, shunt), read(0x03, 0)]);
        }
        transcript.extend(conversion());
        let mut expected = vec![(None, Health::Overflow); 4];
        expected.push((Some(READING), Health::Ok));
        assert_eq!(play(&transcript, 5), expected);
    }

    /// A sensor that was never there, comes, goes and comes back: each time it is set up first.
    #[test]
    fn unplugged_and_plugged_in_again() {
        let mut transcript = vec![not_acknowledged(set_up()), set_up()];
        transcript.extend(conversion());
        transcript.push(not_acknowledged(read(0x02, 0)));
        transcript.extend([not_acknowledged(set_up()), not_acknowledged(set_up()), set_up()]);
        transcript.extend(conversion());
        let (ok, absent) = ((Some(READING), Health::Ok), (None, Health::Absent));
        assert_eq!(play(&transcript, 6), [absent, ok, (None, Health::Ok), (None, Health::Ok), absent, ok]);
    }

    #[test]
    fn a_bus_error_at_any_read_costs_the_reading() {
        for failing in 0..3 {
            let mut transcript = vec![set_up()];
            let mut reads = conversion().to_vec();
            reads[failing] = not_acknowledged(reads[failing].clone());
            // The sensor still clears CNVR after a failed shunt read.
            reads.truncate(if failing == 0 { 1 } else { 3 });
            transcript.extend(reads);
            assert_eq!(play(&transcript, 1), [(None, Health::Absent)], "read {failing}");
        }
    }

    /// After a brown-out the chip converts on, with its reset configuration: the check finds that and sets it up again.
    #[test]
    fn brown_out() {
        let polls = usize::from(POLLS_PER_CHECK);
        let mut transcript = vec![set_up()];
        (1..polls).for_each(|_| transcript.extend(conversion()));
        transcript.push(read(0x00, RESET));
        transcript.push(set_up());
        transcript.extend(conversion());
        let results = play(&transcript, polls + 1);
        assert_eq!(results[polls - 2], (Some(READING), Health::Ok));
        assert_eq!(results[polls - 1], (None, Health::LostCalibration));
        assert_eq!(results[polls], (Some(READING), Health::Ok));
    }

    #[test]
    fn an_intact_configuration_costs_no_reading() {
        let polls = usize::from(POLLS_PER_CHECK);
        let mut transcript = vec![set_up()];
        (1..polls).for_each(|_| transcript.extend(conversion()));
        transcript.push(read(0x00, CONFIGURED));
        transcript.extend(conversion());
        assert_eq!(play(&transcript, polls), vec![(Some(READING), Health::Ok); polls]);
    }

    #[test]
    fn dead_bus() {
        let transcript = vec![not_acknowledged(set_up()); 5];
        assert_eq!(play(&transcript, 5), [(None, Health::Absent); 5]);
    }
}
