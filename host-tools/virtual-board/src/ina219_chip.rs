//! The power sensor TI INA219 as its bus sees it: registers, conversions in time, and the faults a
//! chip can have.
//!
//! Source: datasheet SBOS448G, by section. What it leaves open is decided as TI's later chips of
//! this family document it, and said where it is.

use plant::ina219::{BUS_LSB_V, SHUNT_LSB_V};

/// Configuration after power-on: 32 V, ±320 mV, 12 bit, both voltages continuously (8.6.2.1).
const CONFIGURATION_RESET: u16 = 0x399F;
/// Bits of the configuration register that are kept: RST clears itself, bit 14 is not used.
const CONFIGURATION_KEPT: u16 = 0x3FFF;
const RST: u16 = 1 << 15;
const CNVR: u16 = 1 << 1;
const OVF: u16 = 1 << 0;

/// Registers by the pointer's value (8.6.1).
mod register {
    pub(super) const CONFIGURATION: u8 = 0;
    pub(super) const SHUNT: u8 = 1;
    pub(super) const BUS: u8 = 2;
    pub(super) const POWER: u8 = 3;
    pub(super) const CURRENT: u8 = 4;
    pub(super) const CALIBRATION: u8 = 5;
}

/// What is being converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Signal {
    Shunt,
    Bus,
}

/// A conversion under way: the mean of the signal over its whole length.
#[derive(Debug, Clone, Copy)]
struct Conversion {
    signal: Signal,
    length_us: u64,
    remaining_us: u64,
    /// ∫ signal dt so far, V·µs.
    integral: f64,
}

/// What the sensor would see of the rail if it measured all the time.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Through the shunt, A; positive to the consumer.
    pub current_a: f64,
    /// At the consumer's side, V.
    pub bus_v: f64,
}

/// One chip with its shunt.
#[derive(Debug, Clone)]
pub struct Ina219Chip {
    shunt_ohm: f64,
    pointer: u8,
    configuration: u16,
    calibration: u16,
    shunt: i16,
    /// Voltage code, without flags.
    bus: u16,
    current: i16,
    power: u16,
    ready: bool,
    overflow: bool,
    conversion: Option<Conversion>,
    /// The chip is off the bus: its address is not acknowledged. It keeps converting.
    pub absent: bool,
    /// So many of the next transactions it does not acknowledge.
    pub nack_next: u32,
}

/// Nobody acknowledged the address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoAcknowledge;

impl Ina219Chip {
    /// Just powered on.
    pub fn new(shunt_ohm: f64) -> Self {
        let mut chip = Self {
            shunt_ohm,
            pointer: register::CONFIGURATION,
            configuration: CONFIGURATION_RESET,
            calibration: 0,
            shunt: 0,
            bus: 0,
            current: 0,
            power: 0,
            ready: false,
            overflow: false,
            conversion: None,
            absent: false,
            nack_next: 0,
        };
        chip.brown_out();
        chip
    }

    /// The supply broke down and came back: all registers as after power-on.
    pub fn brown_out(&mut self) {
        self.pointer = register::CONFIGURATION;
        self.reset();
    }

    fn reset(&mut self) {
        self.configuration = CONFIGURATION_RESET;
        self.calibration = 0;
        (self.shunt, self.bus, self.current, self.power) = (0, 0, 0, 0);
        (self.ready, self.overflow) = (false, false);
        self.start();
    }

    /// Writes `bytes`, then reads into `answer`: a transaction with either part empty is a plain
    /// read or write.
    ///
    /// # Errors
    /// A fault is switched on. A transaction that is not acknowledged does nothing.
    pub fn transact(&mut self, bytes: &[u8], answer: &mut [u8]) -> Result<(), NoAcknowledge> {
        if self.absent {
            return Err(NoAcknowledge);
        }
        if self.nack_next > 0 {
            self.nack_next -= 1;
            return Err(NoAcknowledge);
        }
        // The first byte is the pointer, which stays; two more are a value (8.5.6).
        if let [pointer, value @ ..] = bytes {
            self.pointer = *pointer;
            if let [high, low, ..] = value {
                self.write(u16::from_be_bytes([*high, *low]));
            }
        }
        // A host that reads on gets the same register again.
        if !answer.is_empty() {
            let value = self.read().to_be_bytes();
            for (byte, value) in answer.iter_mut().zip(value.into_iter().cycle()) {
                *byte = value;
            }
        }
        Ok(())
    }

    fn write(&mut self, value: u16) {
        match self.pointer {
            register::CONFIGURATION if value & RST != 0 => self.reset(),
            register::CONFIGURATION => {
                self.configuration = value & CONFIGURATION_KEPT;
                // Writing a mode other than power-down and ADC off clears CNVR (8.6.3.2).
                self.ready &= matches!(self.mode(), 0 | 4);
                self.start();
            }
            // Bit 0 is void and reads as 0 (8.6.4.1). It counts from the next conversion on.
            register::CALIBRATION => self.calibration = value & !1,
            _ => {}
        }
    }

    fn read(&mut self) -> u16 {
        match self.pointer {
            register::CONFIGURATION => self.configuration,
            register::SHUNT => self.shunt.cast_unsigned(),
            register::BUS => {
                let flag = |set, bit| if set { bit } else { 0 };
                self.bus << 3 | flag(self.ready, CNVR) | flag(self.overflow, OVF)
            }
            register::POWER => {
                self.ready = false;
                self.power
            }
            register::CURRENT => self.current.cast_unsigned(),
            register::CALIBRATION => self.calibration,
            _ => 0,
        }
    }

    /// MODE bits (Table 6).
    fn mode(&self) -> u16 {
        self.configuration & 0b111
    }

    /// Writing the configuration starts a new conversion, even during one (the INA219's sheet is
    /// silent; INA226, 7.1.1).
    fn start(&mut self) {
        let signal = match self.mode() {
            1 | 3 | 5 | 7 => Some(Signal::Shunt),
            2 | 6 => Some(Signal::Bus),
            _ => None,
        };
        self.conversion = signal.map(|signal| self.conversion_of(signal));
    }

    fn conversion_of(&self, signal: Signal) -> Conversion {
        let code = match signal {
            Signal::Shunt => self.configuration >> 3 & 0xF,
            Signal::Bus => self.configuration >> 7 & 0xF,
        };
        let length_us = conversion_us(code);
        Conversion { signal, length_us, remaining_us: length_us, integral: 0.0 }
    }

    /// `span_us` pass while the rail shows `seen`. `noise_a` gives the current noise of one
    /// reading, A.
    pub fn pass(&mut self, span_us: u64, seen: Seen, mut noise_a: impl FnMut() -> f64) {
        let mut remaining_us = span_us;
        while let Some(conversion) = &mut self.conversion
            && remaining_us > 0
        {
            let passed = remaining_us.min(conversion.remaining_us);
            let value = match conversion.signal {
                Signal::Shunt => seen.current_a * self.shunt_ohm,
                Signal::Bus => seen.bus_v,
            };
            conversion.integral += value * passed as f64;
            conversion.remaining_us -= passed;
            remaining_us -= passed;
            if conversion.remaining_us == 0 {
                let done = *conversion;
                self.end(done, &mut noise_a);
            }
        }
    }

    fn end(&mut self, done: Conversion, noise_a: &mut impl FnMut() -> f64) {
        let mean = done.integral / done.length_us as f64;
        match done.signal {
            Signal::Shunt => self.shunt = self.shunt_code(mean + noise_a() * self.shunt_ohm),
            Signal::Bus => self.bus = self.bus_code(mean),
        }
        let bus_follows = done.signal == Signal::Shunt && self.mode() & 0b10 != 0;
        self.conversion = if bus_follows {
            Some(self.conversion_of(Signal::Bus))
        } else {
            self.multiply();
            self.ready = true;
            None
        };
        // Continuous modes have bit 2.
        if self.conversion.is_none() && self.mode() & 0b100 != 0 {
            self.start();
        }
    }

    /// 10 µV a code whatever the amplifier's range, which only clips (8.6.3.1); fewer bits make
    /// larger steps.
    fn shunt_code(&self, volts: f64) -> i16 {
        let full = f64::from(4000_u16 << (self.configuration >> 11 & 0b11));
        let step = step(self.configuration >> 3 & 0xF);
        let code = (volts / SHUNT_LSB_V / step).round() * step;
        code.clamp(-full, full) as i16
    }

    /// 4 mV a code, up to 16 or 32 V (8.6.3.2).
    fn bus_code(&self, volts: f64) -> u16 {
        let full = if self.configuration & 1 << 13 == 0 { 4000.0 } else { 8000.0 };
        let step = step(self.configuration >> 7 & 0xF);
        ((volts / BUS_LSB_V / step).round() * step).clamp(0.0, full) as u16
    }

    /// Current = shunt · calibration / 4096, power = current · bus / 5000 (8.5.2); OVF when either
    /// does not fit (8.6.3.2).
    fn multiply(&mut self) {
        let current = i64::from(self.shunt) * i64::from(self.calibration) / 4096;
        let power = current.abs() * i64::from(self.bus) / 5000;
        self.overflow = i16::try_from(current).is_err() || u16::try_from(power).is_err();
        // What they show then is not documented, and not to be used.
        self.current = current as i16;
        self.power = power as u16;
    }
}

/// Steps of the 12-bit converter that one of `code`'s resolution is (Table 5).
fn step(code: u16) -> f64 {
    match code {
        0b1000.. => 1.0,
        _ => f64::from(8_u16 >> (code & 0b11)),
    }
}

/// Typical time of a conversion, µs, by BADC or SADC (Table 5): 9 to 12 bit, or a mean of 2 to 128
/// of 12 bit.
fn conversion_us(code: u16) -> u64 {
    match code {
        0b1000.. => 532 << (code & 0b111),
        _ => [84, 148, 276, 532][usize::from(code & 0b11)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ±320 mV, 32 V, means of four, both continuously.
    const AVG4: u16 = 0x3D57;

    fn write(chip: &mut Ina219Chip, register: u8, value: u16) {
        let [high, low] = value.to_be_bytes();
        chip.transact(&[register, high, low], &mut []).unwrap();
    }

    fn read(chip: &mut Ina219Chip, register: u8) -> u16 {
        let mut answer = [0; 2];
        chip.transact(&[register], &mut answer).unwrap();
        u16::from_be_bytes(answer)
    }

    fn pass(chip: &mut Ina219Chip, span_us: u64, current_a: f64, bus_v: f64) {
        chip.pass(span_us, Seen { current_a, bus_v }, || 0.0);
    }

    /// 8.6.2.1 (399Fh) and 8.6.1: all others 0.
    #[test]
    fn it_starts_as_the_data_sheet_says() {
        let mut chip = Ina219Chip::new(0.1);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|r| read(&mut chip, r)), [0x399F, 0, 0, 0, 0, 0]);
        write(&mut chip, 0, AVG4);
        write(&mut chip, 5, 0x1001);
        assert_eq!((read(&mut chip, 0), read(&mut chip, 5)), (AVG4, 0x1000));
        write(&mut chip, 0, 0x8000);
        assert_eq!((read(&mut chip, 0), read(&mut chip, 5)), (0x399F, 0));
    }

    /// The data sheet's example (9.2.2.1, Table 8): 10 A through 2 mΩ at 11.98 V, calibration
    /// 5000h: shunt 07D0h, bus 5D98h (with CNVR 5D9Ah), current 2710h, power 1766h.
    #[test]
    fn the_worked_example() {
        let mut chip = Ina219Chip::new(0.002);
        write(&mut chip, 5, 0x5000);
        pass(&mut chip, 2 * 532, 10.0, 11.98);
        assert_eq!([1, 2, 4, 3].map(|r| read(&mut chip, r)), [0x07D0, 0x5D9A, 0x2710, 0x1766]);
        // Reading the power register has cleared CNVR.
        assert_eq!(read(&mut chip, 2), 0x5D98);
    }

    /// Table 5: times of all settings, in µs; twice the same code makes the sum of both.
    #[test]
    fn conversions_take_their_time() {
        let times = [
            (0, 84),
            (1, 148),
            (2, 276),
            (3, 532),
            (8, 532),
            (9, 1064),
            (10, 2128),
            (11, 4256),
            (12, 8512),
            (13, 17_024),
            (14, 34_048),
            (15, 68_096),
        ];
        for (code, time_us) in times {
            let mut chip = Ina219Chip::new(0.1);
            write(&mut chip, 0, 0x3800 | code << 7 | code << 3 | 7);
            pass(&mut chip, 2 * time_us - 1, 0.1, 12.0);
            assert_eq!(read(&mut chip, 2) & CNVR, 0, "{code}");
            pass(&mut chip, 1, 0.1, 12.0);
            assert_eq!(read(&mut chip, 2), 3000 << 3 | CNVR, "{code}");
            read(&mut chip, 3);
            // Continuously: ready again after as long.
            pass(&mut chip, 2 * time_us - 1, 0.1, 12.0);
            assert_eq!(read(&mut chip, 2) & CNVR, 0, "{code}");
            pass(&mut chip, 1, 0.1, 12.0);
            assert_eq!(read(&mut chip, 2) & CNVR, CNVR, "{code}");
        }
    }

    /// Shunt first: only what flows in the first 2.128 ms of a cycle of 4.256 ms counts, in the
    /// share of the time it flows.
    #[test]
    fn a_reading_is_the_mean_over_its_window() {
        let mut chip = Ina219Chip::new(0.1);
        write(&mut chip, 0, AVG4);
        pass(&mut chip, 1064, 1.0, 12.0);
        pass(&mut chip, 1064, 0.0, 12.0);
        assert_eq!(read(&mut chip, 1), 5000);
        pass(&mut chip, 1064, 3.0, 12.0);
        assert_eq!(read(&mut chip, 2), 0, "the bus voltage comes when its own conversion ends");
        pass(&mut chip, 1064, 3.0, 10.0);
        assert_eq!((read(&mut chip, 1), read(&mut chip, 2)), (5000, 2750 << 3 | CNVR));
    }

    #[test]
    fn writing_a_mode_starts_anew_and_clears_the_flag() {
        let mut chip = Ina219Chip::new(0.1);
        pass(&mut chip, 1064 + 1000, 0.1, 12.0);
        assert_eq!(read(&mut chip, 2) & CNVR, CNVR);
        write(&mut chip, 0, 0x399F);
        assert_eq!(read(&mut chip, 2) & CNVR, 0);
        pass(&mut chip, 1063, 0.1, 12.0);
        assert_eq!(read(&mut chip, 2) & CNVR, 0);
        pass(&mut chip, 1, 0.1, 12.0);
        assert_eq!(read(&mut chip, 2) & CNVR, CNVR);
        // Power-down keeps what there is, and converts no more.
        write(&mut chip, 0, 0x3998);
        pass(&mut chip, 100_000, 3.0, 5.0);
        assert_eq!((read(&mut chip, 2), read(&mut chip, 1)), (3000 << 3 | CNVR, 1000));
    }

    /// Modes 1 to 3 convert once (Table 6).
    #[test]
    fn triggered_modes_convert_once() {
        for (mode, time_us, shunt, bus) in [(1, 532, 1000, 0), (2, 532, 0, 3000), (3, 1064, 1000, 3000)] {
            let mut chip = Ina219Chip::new(0.1);
            write(&mut chip, 0, 0x3998 | mode);
            pass(&mut chip, time_us, 0.1, 12.0);
            assert_eq!((read(&mut chip, 1), read(&mut chip, 2)), (shunt, bus << 3 | CNVR));
            read(&mut chip, 3);
            pass(&mut chip, 100_000, 0.2, 11.0);
            assert_eq!((read(&mut chip, 1), read(&mut chip, 2)), (shunt, bus << 3), "mode {mode}");
        }
    }

    /// Modes 5 and 6 convert one of the two, over and over; 0 and 4 none (Table 6).
    #[test]
    fn modes_of_one_voltage_and_of_none() {
        for (mode, first, second, bus) in [(5, 1000, 2000, 0), (6, 0, 0, 2750), (4, 0, 0, 0), (0, 0, 0, 0)] {
            let mut chip = Ina219Chip::new(0.1);
            write(&mut chip, 0, 0x3998 | mode);
            pass(&mut chip, 532, 0.1, 12.0);
            assert_eq!(read(&mut chip, 1), first, "mode {mode}");
            assert_eq!(read(&mut chip, 2) & CNVR != 0, mode == 5 || mode == 6, "mode {mode}");
            pass(&mut chip, 532, 0.2, 11.0);
            assert_eq!((read(&mut chip, 1), read(&mut chip, 2) >> 3), (second, bus), "mode {mode}");
        }
    }

    /// Full scale by PG (8.6.3.1, Figures 20 to 23): ±40, 80, 160, 320 mV are 0FA0h to 7D00h,
    /// negative F060h to 8300h. BRNG: 16 or 32 V.
    #[test]
    fn ranges_clip() {
        let ranges = [(0, 0x0FA0, 0xF060), (1, 0x1F40, 0xE0C0), (2, 0x3E80, 0xC180), (3, 0x7D00, 0x8300)];
        for (pg, positive, negative) in ranges {
            for brng in [0, 1] {
                let mut chip = Ina219Chip::new(0.1);
                write(&mut chip, 0, brng << 13 | pg << 11 | 0x19F);
                pass(&mut chip, 1064, 3.3, 40.0);
                assert_eq!(read(&mut chip, 1), positive);
                assert_eq!(read(&mut chip, 2) >> 3, [4000, 8000][usize::from(brng)]);
                pass(&mut chip, 1064, -3.3, 40.0);
                assert_eq!(read(&mut chip, 1), negative);
            }
        }
    }

    /// 1005.4 codes, in steps of 8, 4, 2 and 1.
    #[test]
    fn fewer_bits_make_larger_steps() {
        for (code, shunt) in [(0, 1008), (1, 1004), (2, 1006), (3, 1005)] {
            let mut chip = Ina219Chip::new(0.1);
            write(&mut chip, 0, 0x3800 | code << 7 | code << 3 | 7);
            pass(&mut chip, 1064, 0.100_54, 12.0);
            assert_eq!(read(&mut chip, 1), shunt, "{code}");
        }
    }

    /// 3.2 A with calibration FFFEh: 32 000 · 65 534 / 4096 = 511 984 does not fit 16 bits.
    #[test]
    fn arithmetic_that_does_not_fit_shows() {
        let mut chip = Ina219Chip::new(0.1);
        write(&mut chip, 5, 0xFFFE);
        pass(&mut chip, 1064, 3.2, 12.0);
        assert_eq!(read(&mut chip, 2) & OVF, OVF);
        pass(&mut chip, 1064, 0.01, 12.0);
        assert_eq!(read(&mut chip, 2) & OVF, 0);
    }

    #[test]
    fn faults() {
        let mut chip = Ina219Chip::new(0.1);
        write(&mut chip, 0, AVG4);
        chip.nack_next = 2;
        assert_eq!(chip.transact(&[0], &mut [0; 2]), Err(NoAcknowledge));
        assert_eq!(chip.transact(&[0, 0, 0], &mut []), Err(NoAcknowledge));
        assert_eq!(read(&mut chip, 0), AVG4);
        chip.absent = true;
        assert_eq!(chip.transact(&[0], &mut [0; 2]), Err(NoAcknowledge));
        chip.absent = false;
        chip.brown_out();
        assert_eq!(read(&mut chip, 0), CONFIGURATION_RESET);
    }

    /// The pointer stays between transactions, and a long read repeats the register (8.5.6.1).
    #[test]
    fn the_pointer_stays() {
        let mut chip = Ina219Chip::new(0.1);
        chip.transact(&[5], &mut []).unwrap();
        let mut answer = [0; 4];
        write(&mut chip, 5, 0x1234);
        chip.transact(&[], &mut answer).unwrap();
        assert_eq!(answer, [0x12, 0x34, 0x12, 0x34]);
    }
}
