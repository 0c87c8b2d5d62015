//! One sample as the link carries it: what was measured, and what the board made of it.
//!
//! Little-endian:
//!
//! | offset | type | what |
//! |---|---|---|
//! | 0 | u32 | sequence number |
//! | 4 | u64 | time since start, µs |
//! | 12 | 2 × f32 | wheel speeds left, right, rad/s |
//! | 20 | 4 × f32 | power of each rail, W |
//! | 36 | f32 | battery voltage, V |
//! | 40 | u16 | [`Flags`] |
//! | 42 | u16 | health of the rails' sensors, four bits each, battery lowest |
//! | 44 | f32 | predicted actuation power, W |
//! | 48 | 3 × f32 | mass and its 95 % interval, kg |
//!
//! A number whose flag is not set means nothing, and is sent as NaN.

use model_core::payload::Mass;

use crate::bytes::{Reader, Writer};
use crate::power_sensors::{Health, RAIL_COUNT};
use crate::wheels::WHEELS;

/// Bytes of a record.
pub const RECORD_BYTES: usize = 60;

/// What of a record is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(u16);

impl Flags {
    /// The wheels answered: the speeds count.
    pub const WHEELS: Self = Self(1);
    /// Rail `i` has a new reading: bit 1 + i.
    const FIRST_RAIL: u16 = 2;
    /// The battery's voltage is known.
    pub const BATTERY: Self = Self(1 << 5);
    /// There are valid coefficients.
    pub const COEFFICIENTS: Self = Self(1 << 6);
    /// The estimator took this sample.
    pub const ESTIMATED: Self = Self(1 << 7);
    /// The predicted power is known.
    pub const POWER: Self = Self(1 << 8);
    /// The mass is known.
    pub const MASS: Self = Self(1 << 9);
    /// With this sample a payload change was noticed.
    pub const CHANGED: Self = Self(1 << 10);
    /// The wheels stand still.
    pub const STANDSTILL: Self = Self(1 << 11);

    /// As sent.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// As received; bits of later versions are kept.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    /// Rail `index` has a new reading.
    #[must_use]
    pub const fn rail(index: usize) -> Self {
        if index < RAIL_COUNT { Self(Self::FIRST_RAIL << index) } else { Self(0) }
    }

    /// Both.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether all of `other` is set.
    #[must_use]
    pub const fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// A sample and its estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Record {
    /// Counts every sample since start.
    pub sequence: u32,
    /// When it was taken, µs since start.
    pub time_us: u64,
    /// Left, right, rad/s; positive forward.
    pub wheel_speed: Option<[f32; WHEELS]>,
    /// W, in the order of [`crate::power_sensors::RAILS`].
    pub rail_power: [Option<f32>; RAIL_COUNT],
    /// V
    pub battery_voltage: Option<f32>,
    /// Of each rail's sensor.
    pub health: [Health; RAIL_COUNT],
    /// There are valid coefficients.
    pub has_coefficients: bool,
    /// The estimator took this sample.
    pub is_estimated: bool,
    /// With this sample a payload change was noticed.
    pub has_changed: bool,
    /// The wheels stand still.
    pub is_standing: bool,
    /// P̂_act, W.
    pub predicted_power: Option<f32>,
    /// Total mass, kg.
    pub mass: Option<Mass<f32>>,
}

impl Record {
    /// As the link carries it.
    #[must_use]
    pub fn encode(&self) -> [u8; RECORD_BYTES] {
        let mut flags = Flags::default();
        let mut set = |known: bool, flag: Flags| {
            if known {
                flags = flags.with(flag);
            }
        };
        set(self.wheel_speed.is_some(), Flags::WHEELS);
        for (index, power) in self.rail_power.iter().enumerate() {
            set(power.is_some(), Flags::rail(index));
        }
        set(self.battery_voltage.is_some(), Flags::BATTERY);
        set(self.has_coefficients, Flags::COEFFICIENTS);
        set(self.is_estimated, Flags::ESTIMATED);
        set(self.predicted_power.is_some(), Flags::POWER);
        set(self.mass.is_some(), Flags::MASS);
        set(self.has_changed, Flags::CHANGED);
        set(self.is_standing, Flags::STANDSTILL);
        let health =
            self.health.iter().rev().fold(0_u16, |codes, health| codes << 4 | u16::from(health.code()));

        let mut bytes = [0; RECORD_BYTES];
        let mut writer = Writer(&mut bytes);
        writer.put(self.sequence.to_le_bytes());
        writer.put(self.time_us.to_le_bytes());
        for speed in self.wheel_speed.unwrap_or([f32::NAN; WHEELS]) {
            writer.put(speed.to_le_bytes());
        }
        for power in self.rail_power {
            writer.put(number(power));
        }
        writer.put(number(self.battery_voltage));
        writer.put(flags.bits().to_le_bytes());
        writer.put(health.to_le_bytes());
        writer.put(number(self.predicted_power));
        writer.put(number(self.mass.map(|mass| mass.mass)));
        writer.put(number(self.mass.map(|mass| mass.low)));
        writer.put(number(self.mass.map(|mass| mass.high)));
        bytes
    }

    /// `None` where a sensor's health is none that this version knows.
    #[must_use]
    pub fn decode(bytes: &[u8; RECORD_BYTES]) -> Option<Self> {
        let mut reader = Reader(bytes);
        let sequence = u32::from_le_bytes(reader.take()?);
        let time_us = u64::from_le_bytes(reader.take()?);
        let mut wheel_speed = [0.0; WHEELS];
        for speed in &mut wheel_speed {
            *speed = f32::from_le_bytes(reader.take()?);
        }
        let mut rail_power = [None; RAIL_COUNT];
        let mut powers = [0.0; RAIL_COUNT];
        for power in &mut powers {
            *power = f32::from_le_bytes(reader.take()?);
        }
        let battery_voltage = f32::from_le_bytes(reader.take()?);
        let flags = Flags::from_bits(u16::from_le_bytes(reader.take()?));
        let mut codes = u16::from_le_bytes(reader.take()?);
        let mut health = [Health::Absent; RAIL_COUNT];
        for (index, health) in health.iter_mut().enumerate() {
            *health = Health::from_code((codes & 0xF) as u8)?;
            codes >>= 4;
            if let (Some(power), Some(value)) = (rail_power.get_mut(index), powers.get(index)) {
                *power = flags.has(Flags::rail(index)).then_some(*value);
            }
        }
        let predicted_power = f32::from_le_bytes(reader.take()?);
        let mass = Mass {
            mass: f32::from_le_bytes(reader.take()?),
            low: f32::from_le_bytes(reader.take()?),
            high: f32::from_le_bytes(reader.take()?),
        };
        Some(Self {
            sequence,
            time_us,
            wheel_speed: flags.has(Flags::WHEELS).then_some(wheel_speed),
            rail_power,
            battery_voltage: flags.has(Flags::BATTERY).then_some(battery_voltage),
            health,
            has_coefficients: flags.has(Flags::COEFFICIENTS),
            is_estimated: flags.has(Flags::ESTIMATED),
            has_changed: flags.has(Flags::CHANGED),
            is_standing: flags.has(Flags::STANDSTILL),
            predicted_power: flags.has(Flags::POWER).then_some(predicted_power),
            mass: flags.has(Flags::MASS).then_some(mass),
        })
    }
}

fn number(value: Option<f32>) -> [u8; 4] {
    value.unwrap_or(f32::NAN).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full() -> Record {
        Record {
            sequence: 7,
            time_us: 5_000_000_000,
            wheel_speed: Some([1.5, -2.25]),
            rail_power: [Some(1.0), Some(2.0), Some(3.0), Some(4.0)],
            battery_voltage: Some(11.5),
            health: [Health::Ok, Health::Stale, Health::Overflow, Health::LostCalibration],
            has_coefficients: true,
            is_estimated: true,
            has_changed: true,
            is_standing: true,
            predicted_power: Some(2.5),
            mass: Some(Mass { mass: 3.0, low: 2.5, high: 3.5 }),
        }
    }

    #[test]
    fn comes_back_as_it_was() {
        let nothing = Record { sequence: u32::MAX, ..Record::default() };
        let mut one_rail = full();
        one_rail.rail_power = [None, None, Some(0.5), None];
        one_rail.mass = None;
        for record in [full(), nothing, one_rail] {
            assert_eq!(Record::decode(&record.encode()), Some(record));
        }
    }

    /// The layout that the module's documentation gives.
    #[test]
    fn stands_where_it_is_said_to() {
        let bytes = full().encode();
        let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(bytes[..4], 7_u32.to_le_bytes());
        assert_eq!(bytes[4..12], 5_000_000_000_u64.to_le_bytes());
        assert_eq!([float(12), float(16), float(20), float(36), float(44)], [1.5, -2.25, 1.0, 11.5, 2.5]);
        assert_eq!([float(48), float(52), float(56)], [3.0, 2.5, 3.5]);
        assert_eq!(bytes[40..42], 0x0FFF_u16.to_le_bytes());
        // Battery lowest: 0 ok, 1 stale, 2 overflow, 4 lost calibration.
        assert_eq!(bytes[42..44], 0x4210_u16.to_le_bytes());
    }

    #[test]
    fn what_is_unknown_is_no_number() {
        let bytes = Record::default().encode();
        for at in [12, 16, 20, 24, 28, 32, 36, 44, 48, 52, 56] {
            assert!(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()).is_nan(), "{at}");
        }
    }
}
