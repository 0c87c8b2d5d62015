//! How far each rail's measured power is off.
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 4 | magic `GMRK` |
//! | 4 | 2 | format version, 1 |
//! | 6 | 2 | length of the image, checksum included: 28 |
//! | 8 | 4 × 4 | true power over measured power, f32: battery, motors, computer, lidar |
//! | 24 | 4 | CRC-32 (ISO-HDLC) of all before |

use super::frame::{FRAME, open, seal};
use crate::bytes::Reader;
use crate::control_table::Reason;
use crate::power_sensors::RAIL_COUNT;

/// Bytes of the image.
pub const CALIBRATION_BYTES: usize = FRAME + 4 * RAIL_COUNT;

const MAGIC: [u8; 4] = *b"GMRK";

/// Shunts are off by percents at most. What is further off than this is a wrong shunt, not a
/// calibration.
const PLAUSIBLE: core::ops::RangeInclusive<f32> = 0.5..=2.0;

/// Manual calibration of the power measurement against a reference meter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// True power over measured power, 0.5 … 2, in the order of [`crate::power_sensors::RAILS`].
    pub power_factors: [f32; RAIL_COUNT],
}

impl Default for Calibration {
    /// [`Self::NONE`]
    fn default() -> Self {
        Self::NONE
    }
}

impl Calibration {
    /// Measured power is taken as it is.
    pub const NONE: Self = Self { power_factors: [1.0; RAIL_COUNT] };

    /// The image.
    #[must_use]
    pub fn encode(&self) -> [u8; CALIBRATION_BYTES] {
        seal(MAGIC, |body| self.power_factors.iter().for_each(|factor| body.put(factor.to_le_bytes())))
    }

    /// Reads an image back.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn decode(image: &[u8]) -> Result<Self, Reason> {
        let mut body = Reader(open(MAGIC, image)?);
        let mut power_factors = [0.0; RAIL_COUNT];
        for factor in &mut power_factors {
            *factor = body.take().map(f32::from_le_bytes).ok_or(Reason::Length)?;
            if !PLAUSIBLE.contains(factor) {
                return Err(Reason::Value);
            }
        }
        if body.0.is_empty() { Ok(Self { power_factors }) } else { Err(Reason::Length) }
    }
}
