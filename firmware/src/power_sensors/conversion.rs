//! From register codes to volts, amperes and watts.

use ina219::measurements::{BusVoltage, ShuntVoltage};

/// Weight of one count of the shunt-voltage register (01h), whatever the amplifier's range
/// (8.6.3.1).
const SHUNT_VOLTS_PER_COUNT: f32 = 10e-6;
/// Weight of one count of the bus-voltage register (02h), bits 15..3 (8.6.3.2).
const BUS_VOLTS_PER_COUNT: f32 = 4e-3;

/// The resistor a rail's current flows through, and how far its measured power is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shunt {
    /// Resistance in Ω, as printed on the part.
    pub ohm: f32,
    /// Manual calibration: true power / measured power, near 1. Covers the resistor's tolerance and
    /// the sensor's gain.
    pub power_factor: f32,
}

/// One conversion of an INA219: the two voltages it measures. Its power register is these two
/// multiplied on the chip with fewer digits: a check, and no measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// Across the shunt; positive when the rail feeds its consumer.
    pub shunt: ShuntVoltage,
    /// At the consumer's side of the shunt.
    pub bus: BusVoltage,
}

impl Reading {
    /// Current in A through `shunt`, uncalibrated.
    #[must_use]
    pub fn current_a(self, shunt: Shunt) -> f32 {
        f32::from(self.shunt.shunt_voltage_10uv()) * SHUNT_VOLTS_PER_COUNT / shunt.ohm
    }

    /// Bus voltage in V.
    #[must_use]
    pub fn bus_v(self) -> f32 {
        f32::from(self.bus.voltage_4mv()) * BUS_VOLTS_PER_COUNT
    }

    /// Power in W that the rail delivers to its consumer; negative when the consumer feeds back.
    #[must_use]
    pub fn power_w(self, shunt: Shunt) -> f32 {
        self.current_a(shunt) * self.bus_v() * shunt.power_factor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(shunt_10uv: i16, bus_mv: u16) -> Reading {
        Reading { shunt: ShuntVoltage::from_10uv(shunt_10uv), bus: BusVoltage::from_mv(bus_mv) }
    }

    /// Each value passes at most four roundings to f32, of ε/2 each.
    fn assert_close(value: f32, expected: f32) {
        let tolerance = 2.0 * f32::EPSILON * expected.abs();
        assert!((value - expected).abs() <= tolerance, "found {value}, expected {expected} ± {tolerance}");
    }

    /// The datasheet's example (9.2.2.1): 10 A through 2 mΩ from a 12 V supply; the sensor sees 20
    /// mV and, behind the shunt, 11.98 V; the power register reads 119.8 W.
    #[test]
    fn datasheet_example() {
        let example = Shunt { ohm: 0.002, power_factor: 1.0 };
        let reading = reading(2000, 11_980);
        assert_close(reading.current_a(example), 10.0);
        assert_close(reading.bus_v(), 11.98);
        assert_close(reading.power_w(example), 119.8);
    }

    /// −320 mV is 8300h (8.6.3.1) in two's complement. A braking motor feeds power back, with its
    /// sign.
    #[test]
    fn reversed_current_is_negative_power() {
        let shunt = Shunt { ohm: 0.1, power_factor: 1.0 };
        let full_scale = i16::from_be_bytes([0x83, 0x00]);
        assert_close(reading(full_scale, 10_000).current_a(shunt), -3.2);
        assert_close(reading(full_scale, 10_000).power_w(shunt), -32.0);
    }

    #[test]
    fn calibration_scales_power_only() {
        let shunt = Shunt { ohm: 0.1, power_factor: 1.002 };
        assert_close(reading(1000, 12_000).current_a(shunt), 0.1);
        assert_close(reading(1000, 12_000).power_w(shunt), 1.2 * 1.002);
    }
}
