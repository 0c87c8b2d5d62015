//! What the store keeps and the link uploads: coefficients, calibration, and which robot this is.
//!
//! Each is a little-endian image with a magic, a version, its own length and a CRC-32 (ISO-HDLC) at its end. The coefficients'
//! is that of [`model_core::coefficients`]; the other two stand in [`Calibration`] and [`RobotIdentity`].

mod calibration;
mod coefficients;
mod frame;
mod robot;

pub use calibration::{CALIBRATION_BYTES, Calibration};
pub use coefficients::{check_coefficients, checksum};
pub use robot::{ROBOT_BYTES, RobotIdentity};

use crate::control_table::{Item, Reason, UPLOAD_BYTES};

/// Every item there is.
pub const ITEMS: [Item; 3] = [Item::Coefficients, Item::Calibration, Item::Robot];

/// Most bytes of an item.
pub const ITEM_BYTES: usize = UPLOAD_BYTES;

/// The bytes of an item: at most [`ITEM_BYTES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ItemBytes {
    bytes: [u8; ITEM_BYTES],
    length: usize,
}

impl ItemBytes {
    /// No item.
    pub const EMPTY: Self = Self { bytes: [0; ITEM_BYTES], length: 0 };

    /// `None` for more than [`ITEM_BYTES`].
    #[must_use]
    pub fn new(bytes: &[u8]) -> Option<Self> {
        let mut item = Self::EMPTY;
        item.bytes.get_mut(..bytes.len())?.copy_from_slice(bytes);
        item.length = bytes.len();
        Some(item)
    }

    /// Those that count; empty when there is no item.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// Whether the board would take these bytes for that item.
///
/// # Errors
/// The first thing that is wrong with them.
pub fn check(item: Item, bytes: &[u8], robot: &RobotIdentity, sample_rate_hz: u16) -> Result<(), Reason> {
    match item {
        Item::Coefficients => check_coefficients(bytes, robot, sample_rate_hz).map(|_| ()),
        Item::Calibration => Calibration::decode(bytes).map(|_| ()),
        Item::Robot => RobotIdentity::decode(bytes).map(|_| ()),
    }
}
