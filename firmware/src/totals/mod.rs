//! What the robot has used and driven in its life, kept over resets.
//!
//! Counted since the start, and added to what the flash held then: nothing is read back while the
//! robot drives.

mod ledger;
mod trip;

pub use ledger::{Keeping, Ledger};
pub use trip::Trip;

use crate::bytes::{Reader, Writer};
use crate::power_sensors::RAIL_COUNT;

/// Bytes of [`Totals`] in flash.
pub const TOTALS_BYTES: usize = 8 * RAIL_COUNT + 4 + 4 + 4;

/// Of the board's whole life. All stop at their maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Delivered by each rail, less what was fed back, mJ; never below 0.
    pub energy_mj: [u64; RAIL_COUNT],
    /// Way of the middle between the wheels, forward and back, cm.
    pub distance_cm: u32,
    /// Time in motion with torque on, s.
    pub driving_s: u32,
    /// Time switched on, s.
    pub on_s: u32,
}

impl Totals {
    /// Of a new board.
    pub const NONE: Self = Self { energy_mj: [0; RAIL_COUNT], distance_cm: 0, driving_s: 0, on_s: 0 };

    /// Little-endian, one after the other, in the order of the fields.
    #[must_use]
    pub fn encode(&self) -> [u8; TOTALS_BYTES] {
        let mut bytes = [0; TOTALS_BYTES];
        let mut writer = Writer(&mut bytes);
        self.energy_mj.iter().for_each(|energy| writer.put(energy.to_le_bytes()));
        for number in [self.distance_cm, self.driving_s, self.on_s] {
            writer.put(number.to_le_bytes());
        }
        bytes
    }

    /// Reads them back.
    #[must_use]
    pub fn decode(bytes: &[u8; TOTALS_BYTES]) -> Self {
        let mut reader = Reader(bytes);
        let mut totals = Self::NONE;
        for energy in &mut totals.energy_mj {
            *energy = reader.take().map_or(0, u64::from_le_bytes);
        }
        for number in [&mut totals.distance_cm, &mut totals.driving_s, &mut totals.on_s] {
            *number = reader.take().map_or(0, u32::from_le_bytes);
        }
        totals
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        for (place, more) in sum.energy_mj.iter_mut().zip(other.energy_mj) {
            *place = place.saturating_add(more);
        }
        sum.distance_cm = sum.distance_cm.saturating_add(other.distance_cm);
        sum.driving_s = sum.driving_s.saturating_add(other.driving_s);
        sum.on_s = sum.on_s.saturating_add(other.on_s);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOME: Totals =
        Totals { energy_mj: [1, 1 << 40, 3, u64::MAX], distance_cm: 5, driving_s: 1 << 30, on_s: 7 };

    #[test]
    fn comes_back_from_its_bytes() {
        let bytes = SOME.encode();
        assert_eq!(Totals::decode(&bytes), SOME);
        assert_eq!(bytes[..16], [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0]);
        assert_eq!(bytes[32..], [5, 0, 0, 0, 0, 0, 0, 0x40, 7, 0, 0, 0]);
    }

    #[test]
    fn stops_at_the_end() {
        let sum = SOME.plus(&SOME);
        assert_eq!(sum.energy_mj, [2, 1 << 41, 6, u64::MAX]);
        assert_eq!((sum.distance_cm, sum.driving_s, sum.on_s), (10, 1 << 31, 14));
        assert_eq!(sum.plus(&SOME).plus(&SOME).driving_s, u32::MAX);
    }
}
