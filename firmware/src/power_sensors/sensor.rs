//! One INA219: sets it up, polls it, checks what it says, keeps its health.
//!
//! Nothing on this bus has a checksum, and a flipped bit looks like a measurement. So the chip is made to say it twice: it multiplies its
//! two voltages itself, and its product has to be the one that is made of them here. That holds as long as all three are of one
//! conversion. So a poll starts the next conversion and reads the last one, which stands still until the new one ends.

use embedded_hal_async::i2c::I2c;
use ina219::measurements::{BusVoltage, ShuntVoltage};

use super::{Event, Rail, Reading, Status};

/// Registers (8.6.1).
const CONFIGURATION: u8 = 0;
const SHUNT: u8 = 1;
const BUS: u8 = 2;
const POWER: u8 = 3;
const CALIBRATION: u8 = 5;
/// Flags of the bus voltage (8.6.3.2).
const CNVR: u16 = 1 << 1;
const OVF: u16 = 1 << 0;

/// With this the current register is the shunt's: current = shunt · calibration / 4096 (8.5.2). It is the greatest power of two with
/// which ±320 mV, 32,000 counts, fit its 16 bits, and at 32 V, 8,000 counts, the power fits its own: 32,000 · 8,000 / 5,000 = 51,200.
const UNITY: u16 = 4096;
/// Power = current · bus / [`POWER_DIVISOR`] (8.5.2): the fraction is lost.
const POWER_DIVISOR: u32 = 5_000;
/// The data sheet does not say whether what is lost is cut off or rounded.
const POWER_TOLERANCE: u32 = 1;
/// A conversion that was started and has not ended after two polls was not started.
const NOT_STARTED_AFTER: u8 = 2;

/// The sensor of one rail. Owns its handle of the bus; a shared bus hands out one for each.
pub struct PowerSensor<I> {
    rail: Rail,
    i2c: I,
    status: Status,
    /// Whether the chip has the rail's set-up, as far as is known, and converts.
    is_set_up: bool,
    /// Polls in a row that found a conversion under way.
    waited: u8,
}

/// Why a poll gives no reading.
type Failure = Event;

impl<I: I2c> PowerSensor<I> {
    /// A sensor that the first poll sets up. Nothing is sent yet.
    pub fn new(i2c: I, rail: Rail) -> Self {
        Self { rail, i2c, status: Status::new(), is_set_up: false, waited: 0 }
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
        self.i2c
    }

    /// Asks the sensor once. A reading when it has a new one within range that agrees with itself; the status says why when not.
    ///
    /// Errors stay here: one dead sensor costs its own rail only. Poll no faster than the chip converts: it begins with one poll and has
    /// to have ended with the next.
    pub async fn poll(&mut self) -> Option<Reading> {
        let (event, reading) = match self.ask().await {
            Ok(reading) => (Event::Fresh, Some(reading)),
            Err(event) => (event, None),
        };
        self.waited = if event == Event::NotReady { self.waited.saturating_add(1) } else { 0 };
        // Whoever was away, or says what it did not measure, may have lost its set-up.
        if matches!(event, Event::NoAnswer | Event::SetUpLost | Event::Implausible)
            || self.waited >= NOT_STARTED_AFTER
        {
            self.is_set_up = false;
        }
        self.status.observe(event);
        reading
    }

    async fn ask(&mut self) -> Result<Reading, Failure> {
        if !self.is_set_up {
            self.write(CALIBRATION, UNITY).await?;
            self.convert().await?;
            self.is_set_up = true;
            self.waited = 0;
        }
        let bus = self.read(BUS).await?;
        if bus & CNVR == 0 {
            return Err(Event::NotReady);
        }
        // What was converted stays until the next conversion ends, 2 ms later at the soonest.
        self.convert().await?;
        let shunt = self.read(SHUNT).await?.cast_signed();
        let power = self.read(POWER).await?;
        if bus & OVF != 0 || shunt.unsigned_abs() >= self.full_scale_10uv() {
            return Err(Event::Clipped);
        }
        if !is_product(power, shunt, bus >> 3) {
            let found = self.read(CALIBRATION).await?;
            return Err(if found == UNITY { Event::Implausible } else { Event::SetUpLost });
        }
        Ok(Reading {
            shunt: ShuntVoltage::from_10uv(shunt),
            bus: BusVoltage::from_mv((bus >> 3).saturating_mul(4)),
        })
    }

    /// Starts a conversion by writing the set-up anew (8.6.2.1, mode 3), which a supply that broke down had lost.
    async fn convert(&mut self) -> Result<(), Failure> {
        self.write(CONFIGURATION, self.rail.set_up.as_bits()).await
    }

    /// Writes a register and reads it back.
    async fn write(&mut self, register: u8, value: u16) -> Result<(), Failure> {
        let [high, low] = value.to_be_bytes();
        let found = self.exchange(&[register, high, low]).await?;
        if found == value { Ok(()) } else { Err(Event::SetUpLost) }
    }

    async fn read(&mut self, register: u8) -> Result<u16, Failure> {
        self.exchange(&[register]).await
    }

    async fn exchange(&mut self, bytes: &[u8]) -> Result<u16, Failure> {
        let mut value = [0; 2];
        let result = self.i2c.write_read(self.rail.address.as_byte(), bytes, &mut value).await;
        result.map(|()| u16::from_be_bytes(value)).map_err(|_| Event::NoAnswer)
    }

    /// The last code of the shunt register in the range that is set, in 10 µV: a reading there is clipped (8.6.3.1).
    fn full_scale_10uv(&self) -> u16 {
        self.rail.set_up.shunt_voltage_range.range_mv().end().unsigned_abs().saturating_mul(100)
    }
}

/// Whether the chip's product is that of its two voltages, in counts. Of a reversed current the data sheet leaves open whether the product
/// has its sign.
fn is_product(power: u16, shunt: i16, bus: u16) -> bool {
    let product = u32::from(shunt.unsigned_abs()) * u32::from(bus) / POWER_DIVISOR;
    let agrees = |power: u16| u32::from(power).abs_diff(product) <= POWER_TOLERANCE;
    agrees(power) || shunt < 0 && agrees(power.wrapping_neg())
}

#[cfg(test)]
mod tests {
    use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
    use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
    use proptest::prelude::*;

    use super::*;
    use crate::parameters::RAILS;
    use crate::power_sensors::Health;
    use crate::testing::now;

    const ADDRESS: u8 = 0x41;
    const CONFIGURED: u16 = 0x3D53;
    /// After a power-on reset (8.6.2.1).
    const RESET: u16 = 0x399F;
    /// The datasheet's example (9.2.2.1): 20 mV; 11.98 V, with CNVR. 2,000 · 2,995 / 5,000 = 1,198.
    const SHUNT_CODE: u16 = 0x07D0;
    const BUS_CODE: u16 = 0x5D98 | CNVR;
    const POWER_CODE: u16 = 1198;
    const READING: (i16, u16) = (2000, 11_980);

    fn write(register: u8, value: u16, found: u16) -> Transaction {
        let [high, low] = value.to_be_bytes();
        Transaction::write_read(ADDRESS, vec![register, high, low], found.to_be_bytes().to_vec())
    }

    fn read(register: u8, value: u16) -> Transaction {
        Transaction::write_read(ADDRESS, vec![register], value.to_be_bytes().to_vec())
    }

    fn not_acknowledged(transaction: Transaction) -> Transaction {
        transaction.with_error(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address))
    }

    fn convert() -> Transaction {
        write(CONFIGURATION, CONFIGURED, CONFIGURED)
    }

    fn set_up() -> [Transaction; 2] {
        [write(CALIBRATION, UNITY, UNITY), convert()]
    }

    fn conversion_of(bus: u16, shunt: u16, power: u16) -> [Transaction; 4] {
        [read(BUS, bus), convert(), read(SHUNT, shunt), read(POWER, power)]
    }

    fn conversion() -> [Transaction; 4] {
        conversion_of(BUS_CODE, SHUNT_CODE, POWER_CODE)
    }

    fn not_ready() -> Transaction {
        read(BUS, BUS_CODE & !CNVR)
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
    fn sets_up_once_then_converts_and_reads() {
        let mut transcript = set_up().to_vec();
        transcript.push(not_ready());
        transcript.extend(conversion());
        transcript.extend(conversion());
        let expected = [(None, Health::Absent), (Some(READING), Health::Ok), (Some(READING), Health::Ok)];
        assert_eq!(play(&transcript, 3), expected);
    }

    /// A conversion that does not end was not started: it is started anew.
    #[test]
    fn no_new_conversion_reads_nothing_else() {
        let mut transcript = set_up().to_vec();
        transcript.extend(conversion());
        transcript.extend([not_ready(), not_ready()]);
        transcript.extend(set_up());
        transcript.push(not_ready());
        transcript.extend(conversion());
        let (ok, missing, stale) = ((Some(READING), Health::Ok), (None, Health::Ok), (None, Health::Stale));
        assert_eq!(play(&transcript, 5), [ok, missing, missing, stale, ok]);
    }

    /// The overflow flag, and both ends of the ±320 mV range (7D00h and 8300h), cost the reading but not the next one.
    #[test]
    fn overflow() {
        let mut transcript = set_up().to_vec();
        let codes =
            [(BUS_CODE | OVF, SHUNT_CODE), (BUS_CODE, 0x7D00), (BUS_CODE, 0x8300), (BUS_CODE, 0x7D01)];
        for (bus, shunt) in codes {
            transcript.extend(conversion_of(bus, shunt, 0));
        }
        transcript.extend(conversion());
        let mut expected = vec![(None, Health::Overflow); 4];
        expected.push((Some(READING), Health::Ok));
        assert_eq!(play(&transcript, 5), expected);
    }

    /// A sensor that was never there, comes, goes and comes back: each time it is set up first.
    #[test]
    fn unplugged_and_plugged_in_again() {
        let [calibrate, _] = set_up();
        let mut transcript = vec![not_acknowledged(calibrate.clone())];
        transcript.extend(set_up());
        transcript.extend(conversion());
        transcript.push(not_acknowledged(read(BUS, 0)));
        transcript.extend([not_acknowledged(calibrate.clone()), not_acknowledged(calibrate)]);
        transcript.extend(set_up());
        transcript.extend(conversion());
        let (ok, absent) = ((Some(READING), Health::Ok), (None, Health::Absent));
        assert_eq!(play(&transcript, 6), [absent, ok, (None, Health::Ok), (None, Health::Ok), absent, ok]);
    }

    #[test]
    fn a_bus_error_at_any_step_costs_the_reading() {
        for failing in 0..4 {
            let mut transcript = set_up().to_vec();
            let mut reads = conversion().to_vec();
            reads[failing] = not_acknowledged(reads[failing].clone());
            reads.truncate(failing + 1);
            transcript.extend(reads);
            assert_eq!(play(&transcript, 1), [(None, Health::Absent)], "step {failing}");
        }
    }

    /// After a brown-out the chip multiplies by 0: it is set up again.
    #[test]
    fn brown_out() {
        let mut transcript = set_up().to_vec();
        transcript.extend(conversion());
        transcript.extend(conversion_of(BUS_CODE, SHUNT_CODE, 0));
        transcript.push(read(CALIBRATION, 0));
        transcript.extend(set_up());
        transcript.extend(conversion());
        let (ok, lost) = ((Some(READING), Health::Ok), (None, Health::LostCalibration));
        assert_eq!(play(&transcript, 3), [ok, lost, ok]);
    }

    /// What is written is read back: another range or another mode would be measured with, and nothing would show it.
    #[test]
    fn a_set_up_that_was_not_taken_is_written_again() {
        for found in [RESET, CONFIGURED ^ 1 << 11, CONFIGURED ^ 1] {
            let mut transcript = set_up().to_vec();
            transcript.extend([read(BUS, BUS_CODE), write(CONFIGURATION, CONFIGURED, found)]);
            transcript.extend(set_up());
            transcript.extend(conversion());
            assert_eq!(play(&transcript, 2), [(None, Health::LostCalibration), (Some(READING), Health::Ok)]);
        }
    }

    /// One is left out and counted; three in a row, and the sensor is not believed.
    #[test]
    fn what_disagrees_with_the_chips_own_product_is_left_out() {
        let mut transcript = set_up().to_vec();
        transcript.extend(conversion());
        for shunt in [SHUNT_CODE ^ 1 << 3, SHUNT_CODE ^ 1 << 14, SHUNT_CODE ^ 1 << 5] {
            transcript.extend(conversion_of(BUS_CODE, shunt, POWER_CODE));
            transcript.push(read(CALIBRATION, UNITY));
            transcript.extend(set_up());
        }
        transcript.extend(conversion());
        let left_out = [(None, Health::Ok), (None, Health::Ok), (None, Health::Implausible)];
        assert_eq!(play(&transcript, 5)[1..4], left_out);
    }

    #[test]
    fn dead_bus() {
        let [calibrate, _] = set_up();
        let transcript = vec![not_acknowledged(calibrate); 5];
        assert_eq!(play(&transcript, 5), [(None, Health::Absent); 5]);
    }

    proptest! {
        /// Every reading that a chip gives, of either sign and either way to lose the fraction and to show the sign.
        #[test]
        fn no_true_product_is_left_out(shunt in -31_999_i16..32_000, bus in 0_u16..=8_000, rounds: bool, has_sign: bool) {
            let product = u32::from(shunt.unsigned_abs()) * u32::from(bus);
            let product = ((product + if rounds { 2_500 } else { 0 }) / 5_000) as u16;
            let power = if has_sign && shunt < 0 { product.wrapping_neg() } else { product };
            prop_assert!(is_product(power, shunt, bus));
        }

        /// Any one bit of any of the three: what is still believed is off by 1 % or two counts of the power register at the most.
        #[test]
        fn one_flipped_bit_shows(shunt in -31_999_i16..32_000, bus in 0_u16..=8_000, place in 0_u32..48) {
            let power = (u32::from(shunt.unsigned_abs()) * u32::from(bus) / 5_000) as u16;
            let flip = |value: u16, first: u32| if (first..first + 16).contains(&place) { value ^ 1 << (place - first) } else { value };
            let found = (flip(shunt.cast_unsigned(), 0).cast_signed(), flip(bus << 3, 16) >> 3, flip(power, 32));
            if is_product(found.2, found.0, found.1) {
                let watts = |shunt: i16, bus: u16| f64::from(shunt) * f64::from(bus) / 5_000.0;
                let (true_power, shown) = (watts(shunt, bus), watts(found.0, found.1));
                prop_assert!((shown - true_power).abs() <= (0.01 * true_power.abs()).max(2.0), "{true_power} {shown}");
            }
        }
    }
}
