//! One INA219: sets it up, polls it, checks what it says, keeps its health.
//!
//! Nothing on this bus has a checksum, and a flipped bit looks like a measurement. So the chip is
//! made to say it twice: it multiplies its two voltages itself, and its product has to be the one
//! that is made of them here. That holds as long as all three are of one conversion. So a poll
//! starts the next conversion and reads the last one, which stands still until the new one ends.

use embedded_hal_async::i2c::I2c;
use ina219::measurements::{BusVoltage, ShuntVoltage};

use super::convert::{CONFIGURATION, Conversion};
use super::{Event, Rail, Reading, Status};

/// Register (8.6.1).
const CALIBRATION: u8 = 5;
/// Flags of the bus voltage (8.6.3.2).
const CNVR: u16 = 1 << 1;
const OVF: u16 = 1 << 0;

/// With this the current register is the shunt's: current = shunt · calibration / 4096 (8.5.2). It
/// is the greatest power of two with which ±320 mV, 32,000 counts, fit its 16 bits, and at 32 V,
/// 8,000 counts, the power fits its own: 32,000 · 8,000 / 5,000 = 51,200.
const UNITY: u16 = 4096;
/// Power = current · bus / [`POWER_DIVISOR`] (8.5.2): the fraction is lost.
const POWER_DIVISOR: u32 = 5_000;
/// The data sheet does not say whether what is lost is cut off or rounded.
const POWER_TOLERANCE: u32 = 1;

/// The sensor of one rail with its bus.
pub struct PowerSensor<I> {
    sensor: Sensor,
    i2c: I,
}

/// The sensor of one rail.
pub(super) struct Sensor {
    rail: Rail,
    status: Status,
    /// Whether the chip has the rail's set-up, as far as is known.
    is_set_up: bool,
}

/// Why a poll gives no reading.
type Failure = Event;

impl<I: I2c> PowerSensor<I> {
    /// A sensor that the first poll sets up. Nothing is sent yet.
    pub fn new(i2c: I, rail: Rail) -> Self {
        Self { sensor: Sensor::new(rail), i2c }
    }

    /// Where the sensor sits.
    #[must_use]
    pub fn rail(&self) -> Rail {
        self.sensor.rail
    }

    /// From now on true power is measured power times `factor`: a calibration from the store.
    pub fn set_power_factor(&mut self, factor: f32) {
        self.sensor.set_power_factor(factor);
    }

    /// Whether it can be believed, and its counters.
    #[must_use]
    pub fn status(&self) -> Status {
        self.sensor.status
    }

    /// Gives the bus back.
    pub fn release(self) -> I {
        self.i2c
    }

    /// Asks the sensor once. A reading when it has a new one within range that agrees with itself;
    /// the status says why when not.
    ///
    /// Errors stay here: one dead sensor costs its own rail only. Poll no faster than the chip
    /// converts: it begins with one poll and has to have ended with the next.
    pub async fn poll(&mut self) -> Option<Reading> {
        let Self { sensor, i2c } = self;
        let mut conversion = sensor.begin(i2c).await?;
        // It shows by its missing answer.
        let _ = conversion.ask(i2c).await;
        sensor.end(i2c, conversion.answer).await
    }
}

impl Sensor {
    pub(super) const fn new(rail: Rail) -> Self {
        Self { rail, status: Status::new(), is_set_up: false }
    }

    pub(super) const fn rail(&self) -> &Rail {
        &self.rail
    }

    pub(super) fn set_power_factor(&mut self, factor: f32) {
        self.rail.shunt.power_factor = factor;
    }

    pub(super) const fn status(&self) -> &Status {
        &self.status
    }

    /// The first half of a poll: sets the chip up where it is not, and says what to ask it. `None`,
    /// and the poll is over, where it takes no set-up.
    pub(super) async fn begin<I: I2c>(&mut self, i2c: &mut I) -> Option<Conversion> {
        if !self.is_set_up
            && let Err(event) = self.set_up(i2c).await
        {
            self.observe(event);
            return None;
        }
        let set_up = self.rail.set_up.as_bits();
        Some(Conversion { address: self.rail.address.as_byte(), set_up, answer: None })
    }

    /// The second half: what the answer is worth.
    pub(super) async fn end<I: I2c>(&mut self, i2c: &mut I, answer: Option<[u16; 4]>) -> Option<Reading> {
        let result = match answer {
            Some(answer) => self.judge(i2c, answer).await,
            None => Err(Event::NoAnswer),
        };
        self.observe(result.err().unwrap_or(Event::Fresh));
        result.ok()
    }

    fn observe(&mut self, event: Event) {
        // Whoever was away, or says what it did not measure, may have lost its set-up.
        if matches!(event, Event::NoAnswer | Event::SetUpLost | Event::Implausible) {
            self.is_set_up = false;
        }
        self.status.observe(event);
    }

    async fn set_up<I: I2c>(&mut self, i2c: &mut I) -> Result<(), Failure> {
        self.write(i2c, CALIBRATION, UNITY).await?;
        // What was converted with another set-up is not ready any more.
        self.write(i2c, CONFIGURATION, self.rail.set_up.as_bits()).await?;
        self.is_set_up = true;
        Ok(())
    }

    async fn judge<I: I2c>(
        &self,
        i2c: &mut I,
        [bus, set_up, shunt, power]: [u16; 4],
    ) -> Result<Reading, Failure> {
        if set_up != self.rail.set_up.as_bits() {
            return Err(Event::SetUpLost);
        }
        if bus & CNVR == 0 {
            return Err(Event::NotReady);
        }
        let shunt = shunt.cast_signed();
        if bus & OVF != 0 || shunt.unsigned_abs() >= self.full_scale_10uv() {
            return Err(Event::Clipped);
        }
        if !is_product(power, shunt, bus >> 3) {
            let calibration = self.exchange(i2c, &[CALIBRATION]).await?;
            return Err(if calibration == UNITY { Event::Implausible } else { Event::SetUpLost });
        }
        Ok(Reading {
            shunt: ShuntVoltage::from_10uv(shunt),
            bus: BusVoltage::from_mv((bus >> 3).saturating_mul(4)),
        })
    }

    /// Writes a register and reads it back.
    async fn write<I: I2c>(&self, i2c: &mut I, register: u8, value: u16) -> Result<(), Failure> {
        let [high, low] = value.to_be_bytes();
        let read = self.exchange(i2c, &[register, high, low]).await?;
        if read == value { Ok(()) } else { Err(Event::SetUpLost) }
    }

    async fn exchange<I: I2c>(&self, i2c: &mut I, bytes: &[u8]) -> Result<u16, Failure> {
        let mut value = [0; 2];
        let result = i2c.write_read(self.rail.address.as_byte(), bytes, &mut value).await;
        result.map(|()| u16::from_be_bytes(value)).map_err(|_| Event::NoAnswer)
    }

    /// The last code of the shunt register in the range that is set, in 10 µV: a reading there is
    /// clipped (8.6.3.1).
    fn full_scale_10uv(&self) -> u16 {
        self.rail.set_up.shunt_voltage_range.range_mv().end().unsigned_abs().saturating_mul(100)
    }
}

/// Whether the chip's product is that of its two voltages, in counts. Of a reversed current the
/// data sheet leaves open whether the product has its sign.
fn is_product(power: u16, shunt: i16, bus: u16) -> bool {
    let product = u32::from(shunt.unsigned_abs()) * u32::from(bus) / POWER_DIVISOR;
    let agrees = |power: u16| u32::from(power).abs_diff(product) <= POWER_TOLERANCE;
    agrees(power) || shunt < 0 && agrees(power.wrapping_neg())
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};
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

    /// A transaction: what is written, and what is read after each of it, or that nobody
    /// acknowledges.
    type Call = (Vec<Vec<u8>>, Option<Vec<u16>>);

    /// Plays them.
    struct Script(VecDeque<Call>);

    impl ErrorType for Script {
        type Error = ErrorKind;
    }

    impl I2c for Script {
        async fn transaction(
            &mut self,
            address: u8,
            operations: &mut [Operation<'_>],
        ) -> Result<(), ErrorKind> {
            assert_eq!(address, ADDRESS);
            let (written, read) = self.0.pop_front().expect("the script is over");
            let pairs = operations.as_chunks_mut::<2>().0;
            let asked: Vec<&[u8]> = pairs
                .iter()
                .map(|pair| if let [Operation::Write(bytes), _] = pair { *bytes } else { panic!("{pair:?}") })
                .collect();
            assert_eq!(asked, written);
            let values = read.ok_or(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address))?;
            for (pair, value) in pairs.iter_mut().zip(values) {
                let [_, Operation::Read(place)] = pair else { panic!("{pair:?}") };
                place.copy_from_slice(&value.to_be_bytes());
            }
            Ok(())
        }
    }

    fn write(register: u8, value: u16, read: u16) -> Call {
        let [high, low] = value.to_be_bytes();
        (vec![vec![register, high, low]], Some(vec![read]))
    }

    fn read(register: u8, value: u16) -> Call {
        (vec![vec![register]], Some(vec![value]))
    }

    fn silent((written, _): Call) -> Call {
        (written, None)
    }

    fn set_up() -> [Call; 2] {
        [write(CALIBRATION, UNITY, UNITY), write(CONFIGURATION, CONFIGURED, CONFIGURED)]
    }

    fn transaction(bus: u16, set_up: u16, shunt: u16, power: u16) -> Call {
        let [high, low] = CONFIGURED.to_be_bytes();
        // Registers 2, 0, 1 and 3.
        let written = vec![vec![2], vec![CONFIGURATION, high, low], vec![1], vec![3]];
        (written, Some(vec![bus, set_up, shunt, power]))
    }

    fn conversion_of(bus: u16, shunt: u16, power: u16) -> Call {
        transaction(bus, CONFIGURED, shunt, power)
    }

    fn conversion() -> Call {
        conversion_of(BUS_CODE, SHUNT_CODE, POWER_CODE)
    }

    fn not_ready() -> Call {
        conversion_of(BUS_CODE & !CNVR, SHUNT_CODE, POWER_CODE)
    }

    /// Polls until the script is over: (shunt in 10 µV, bus in mV) and health after each poll.
    fn play(calls: &[Call], polls: usize) -> Vec<(Option<(i16, u16)>, Health)> {
        let mut sensor = PowerSensor::new(Script(calls.iter().cloned().collect()), RAILS[1]);
        let results = (0..polls)
            .map(|_| {
                let reading = now(sensor.poll());
                let voltages = reading.map(|r| (r.shunt.shunt_voltage_10uv(), r.bus.voltage_mv()));
                (voltages, sensor.status().health())
            })
            .collect();
        assert!(sensor.release().0.is_empty());
        results
    }

    #[test]
    fn sets_up_once_then_converts_and_reads() {
        let mut calls = set_up().to_vec();
        calls.extend([not_ready(), conversion(), conversion()]);
        let expected = [(None, Health::Absent), (Some(READING), Health::Ok), (Some(READING), Health::Ok)];
        assert_eq!(play(&calls, 3), expected);
    }

    #[test]
    fn no_new_conversion_is_no_reading() {
        let mut calls = set_up().to_vec();
        calls.extend([conversion(), not_ready(), not_ready(), not_ready(), conversion()]);
        let (ok, missing, stale) = ((Some(READING), Health::Ok), (None, Health::Ok), (None, Health::Stale));
        assert_eq!(play(&calls, 5), [ok, missing, missing, stale, ok]);
    }

    /// The overflow flag, and both ends of the ±320 mV range (7D00h and 8300h), cost the reading
    /// but not the next one.
    #[test]
    fn overflow() {
        let mut calls = set_up().to_vec();
        let codes =
            [(BUS_CODE | OVF, SHUNT_CODE), (BUS_CODE, 0x7D00), (BUS_CODE, 0x8300), (BUS_CODE, 0x7D01)];
        calls.extend(codes.map(|(bus, shunt)| conversion_of(bus, shunt, 0)));
        calls.push(conversion());
        let mut expected = vec![(None, Health::Overflow); 4];
        expected.push((Some(READING), Health::Ok));
        assert_eq!(play(&calls, 5), expected);
    }

    /// A sensor that was never there, comes, goes and comes back: each time it is set up first.
    #[test]
    fn unplugged_and_plugged_in_again() {
        let [calibrate, _] = set_up();
        let mut calls = vec![silent(calibrate.clone())];
        calls.extend(set_up());
        calls.extend([conversion(), silent(conversion()), silent(calibrate.clone()), silent(calibrate)]);
        calls.extend(set_up());
        calls.push(conversion());
        let (ok, absent) = ((Some(READING), Health::Ok), (None, Health::Absent));
        assert_eq!(play(&calls, 6), [absent, ok, (None, Health::Ok), (None, Health::Ok), absent, ok]);
    }

    /// After a brown-out the chip multiplies by 0: it is set up again.
    #[test]
    fn brown_out() {
        let mut calls = set_up().to_vec();
        calls.extend([conversion(), conversion_of(BUS_CODE, SHUNT_CODE, 0), read(CALIBRATION, 0)]);
        calls.extend(set_up());
        calls.push(conversion());
        let (ok, lost) = ((Some(READING), Health::Ok), (None, Health::LostCalibration));
        assert_eq!(play(&calls, 3), [ok, lost, ok]);
    }

    /// What is written is read back: another range or another mode would be measured with, and
    /// nothing would show it.
    #[test]
    fn a_set_up_that_was_not_taken_is_written_again() {
        for other in [RESET, CONFIGURED ^ 1 << 11, CONFIGURED ^ 1] {
            let mut calls = set_up().to_vec();
            calls.push(transaction(BUS_CODE, other, SHUNT_CODE, POWER_CODE));
            calls.extend(set_up());
            calls.push(conversion());
            assert_eq!(play(&calls, 2), [(None, Health::LostCalibration), (Some(READING), Health::Ok)]);
        }
    }

    /// One is left out and counted; three in a row, and the sensor is not believed.
    #[test]
    fn what_disagrees_with_the_chips_own_product_is_left_out() {
        let mut calls = set_up().to_vec();
        calls.push(conversion());
        for shunt in [SHUNT_CODE ^ 1 << 3, SHUNT_CODE ^ 1 << 14, SHUNT_CODE ^ 1 << 5] {
            calls.extend([conversion_of(BUS_CODE, shunt, POWER_CODE), read(CALIBRATION, UNITY)]);
            calls.extend(set_up());
        }
        calls.push(conversion());
        let left_out = [(None, Health::Ok), (None, Health::Ok), (None, Health::Implausible)];
        assert_eq!(play(&calls, 5)[1..4], left_out);
    }

    #[test]
    fn dead_bus() {
        let [calibrate, _] = set_up();
        assert_eq!(play(&vec![silent(calibrate); 5], 5), [(None, Health::Absent); 5]);
    }

    proptest! {
        /// Every reading that a chip gives, of either sign and either way to lose the fraction and
        /// to show the sign.
        #[test]
        fn no_true_product_is_left_out(shunt in -31_999_i16..32_000, bus in 0_u16..=8_000, rounds: bool, has_sign: bool) {
            let product = u32::from(shunt.unsigned_abs()) * u32::from(bus);
            let product = ((product + if rounds { 2_500 } else { 0 }) / 5_000) as u16;
            let power = if has_sign && shunt < 0 { product.wrapping_neg() } else { product };
            prop_assert!(is_product(power, shunt, bus));
        }

        /// Any one bit of any of the three: what is still believed is off by 1 % or two counts of
        /// the power register at the most.
        #[test]
        fn one_flipped_bit_shows(shunt in -31_999_i16..32_000, bus in 0_u16..=8_000, place in 0_u32..48) {
            let power = (u32::from(shunt.unsigned_abs()) * u32::from(bus) / 5_000) as u16;
            let flip = |value: u16, first: u32| if (first..first + 16).contains(&place) { value ^ 1 << (place - first) } else { value };
            let read = (flip(shunt.cast_unsigned(), 0).cast_signed(), flip(bus << 3, 16) >> 3, flip(power, 32));
            if is_product(read.2, read.0, read.1) {
                let watts = |shunt: i16, bus: u16| f64::from(shunt) * f64::from(bus) / 5_000.0;
                let (true_power, shown) = (watts(shunt, bus), watts(read.0, read.1));
                prop_assert!((shown - true_power).abs() <= (0.01 * true_power.abs()).max(2.0), "{true_power} {shown}");
            }
        }
    }
}
