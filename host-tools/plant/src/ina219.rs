//! The power sensor TI INA219 (datasheet SBOS448G): conversion to register codes and averaging.

/// One conversion at 12 bit, s (datasheet Table 5, typical).
pub const CONVERSION_S: f64 = 532e-6;

/// Shunt voltage per code, V (register 01h).
pub const SHUNT_LSB_V: f64 = 10e-6;

/// Bus voltage per code, V (register 02h, after the shift by three bits).
pub const BUS_LSB_V: f64 = 4e-3;

/// A sensor with its shunt and settings. The shunt range is ±320 mV (reset state of the PGA bits).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ina219 {
    /// Shunt resistance, Ω.
    pub shunt_ohm: f64,
    /// Current per code of the current register, A; fixes the calibration register.
    pub current_lsb_a: f64,
    /// Conversions averaged in one reading: 1, 2, 4, … 128.
    pub averages: u32,
}

impl Default for Ina219 {
    /// The breakout board's 0.1 Ω and 0.1 mA per code, so that shunt and current codes agree
    /// (calibration 4096).
    fn default() -> Self {
        Self { shunt_ohm: 0.1, current_lsb_a: 1e-4, averages: 1 }
    }
}

/// Codes of the registers after a conversion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    /// Shunt voltage, 10 µV.
    pub shunt: i16,
    /// Bus voltage, 4 mV.
    pub bus: u16,
    /// Current, `current_lsb_a`.
    pub current: i16,
    /// Power, 20 times `current_lsb_a` watts.
    pub power: u16,
}

impl Ina219 {
    /// The calibration register: trunc(0.04096 / (current LSB · shunt)), bit 0 void (datasheet Eq.
    /// 1).
    pub fn calibration(&self) -> u16 {
        ((0.04096 / (self.current_lsb_a * self.shunt_ohm)) as u16) & !1
    }

    /// The most averages of which shunt and bus conversion, one after the other, fit into a period,
    /// s.
    pub fn averages_within(period_s: f64) -> u32 {
        let mut averages = 1;
        while averages < 128 && 2.0 * f64::from(2 * averages) * CONVERSION_S <= period_s {
            averages *= 2;
        }
        averages
    }

    /// Time of one averaged conversion, s; shunt and bus take this long each.
    pub fn conversion_time_s(&self) -> f64 {
        f64::from(self.averages) * CONVERSION_S
    }

    /// Register codes for a current, A, through the shunt and a bus voltage, V.
    pub fn convert(&self, current_a: f64, bus_v: f64) -> Registers {
        let shunt = (current_a * self.shunt_ohm / SHUNT_LSB_V).round().clamp(-32_000.0, 32_000.0) as i16;
        let bus = (bus_v / BUS_LSB_V).round().clamp(0.0, 8000.0) as u16;
        let current = i64::from(shunt) * i64::from(self.calibration()) / 4096;
        let current = current.clamp(i64::from(i16::MIN), i64::from(i16::MAX)) as i16;
        let power = i64::from(current.unsigned_abs()) * i64::from(bus) / 5000;
        Registers { shunt, bus, current, power: power.min(i64::from(u16::MAX)) as u16 }
    }

    /// Power, W, as firmware computes it: current register times bus register. The power register
    /// is coarser (20 current codes) and has no sign.
    pub fn power_w(&self, registers: Registers) -> f64 {
        f64::from(registers.current) * self.current_lsb_a * f64::from(registers.bus) * BUS_LSB_V
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_follow_the_datasheet_formulas() {
        let sensor = Ina219::default();
        assert_eq!(sensor.calibration(), 4096);
        // 0.1 A · 0.1 Ω = 10 mV = 1000 codes; 12 V = 3000 codes; power 1000 · 3000 / 5000 = 600
        // codes of 2 mW.
        let registers = sensor.convert(0.1, 12.0);
        assert_eq!(registers, Registers { shunt: 1000, bus: 3000, current: 1000, power: 600 });
        assert!((sensor.power_w(registers) - 1.2).abs() < 1e-12);
        // Datasheet's worked example (Table 8): 20 mV, 11.98 V, 2 mΩ, 1 mA LSB: cal 20480, current
        // 10 000, bus 2995 codes, power 5990 codes.
        let example = Ina219 { shunt_ohm: 0.002, current_lsb_a: 1e-3, averages: 1 };
        assert_eq!(example.calibration(), 20_480);
        assert_eq!(
            example.convert(10.0, 11.98),
            Registers { shunt: 2000, bus: 2995, current: 10_000, power: 5990 }
        );
    }

    #[test]
    fn the_step_is_0_1_ma_and_4_mv_and_the_range_ends_at_320_mv() {
        let sensor = Ina219::default();
        assert_eq!(sensor.convert(0.000_04, 0.001_9).shunt, 0);
        assert_eq!(sensor.convert(0.000_06, 0.002_1), Registers { shunt: 1, bus: 1, current: 1, power: 0 });
        assert_eq!(sensor.convert(-5.0, 12.0).shunt, -32_000);
    }

    #[test]
    fn averages_fit_the_sample_period() {
        // Two conversions of n · 532 µs: 4 take 4.3 ms, 8 take 8.5 ms, 16 take 17 ms, 64 take 68
        // ms.
        assert_eq!(
            [200.0, 100.0, 20.0, 5.0].map(|rate| Ina219::averages_within(1.0 / rate)),
            [4, 8, 32, 128]
        );
        assert_eq!(Ina219::averages_within(1e-4), 1);
    }
}
