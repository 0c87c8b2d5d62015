//! What the store keeps and the link uploads: coefficients, calibration, and which robot this is.
//!
//! Each is a little-endian image with a magic, a version, its own length and a CRC-32 (ISO-HDLC) at
//! its end. The coefficients' is that of [`model_core::coefficients`]; the other two stand in
//! [`Calibration`] and [`RobotIdentity`].

mod calibration;
mod coefficients;
mod frame;
mod robot;
mod signature;

pub use calibration::{CALIBRATION_BYTES, Calibration};
pub use coefficients::{check_coefficients, checksum};
pub use robot::{ROBOT_BYTES, RobotIdentity};

#[cfg(feature = "signed")]
pub use signature::is_signed_by;
pub use signature::{PublicKey, SIGNATURE_BYTES, Verify, check_signature, key_of_hex, parts};

use crate::control_table::{Item, Reason, UPLOAD_BYTES};

/// Every item there is.
pub const ITEMS: [Item; 3] = [Item::Coefficients, Item::Calibration, Item::Robot];

/// Most bytes of an item: an image, and the signature behind it.
pub const ITEM_BYTES: usize = UPLOAD_BYTES + SIGNATURE_BYTES;

/// The bytes of any item.
pub type ItemBytes = Bytes<ITEM_BYTES>;

/// The bytes of an item that has `N` at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bytes<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Bytes<N> {
    /// No item.
    pub const EMPTY: Self = Self { bytes: [0; N], length: 0 };

    /// `None` for more than `N`.
    #[must_use]
    pub fn new(bytes: &[u8]) -> Option<Self> {
        let mut item = Self::EMPTY;
        item.bytes.get_mut(..bytes.len())?.copy_from_slice(bytes);
        item.length = bytes.len();
        Some(item)
    }

    /// The same and more behind it; `None` where that is too long.
    #[must_use]
    pub fn with(mut self, more: &[u8]) -> Option<Self> {
        let end = self.length + more.len();
        self.bytes.get_mut(self.length..end)?.copy_from_slice(more);
        self.length = end;
        Some(self)
    }

    /// Without the signature behind it, if there is one.
    #[must_use]
    pub fn image(&self) -> &[u8] {
        parts(self.as_slice()).0
    }

    /// Those that count; empty when there is no item.
    #[must_use]
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

/// Whether the board would take these bytes for that item. The signature is not looked at.
///
/// # Errors
/// The first thing that is wrong with them.
pub fn check(item: Item, bytes: &[u8], robot: &RobotIdentity, sample_rate_hz: u16) -> Result<(), Reason> {
    match item {
        Item::Coefficients => check_coefficients(parts(bytes).0, robot, sample_rate_hz).map(|_| ()),
        Item::Calibration => Calibration::decode(bytes).map(|_| ()),
        Item::Robot => RobotIdentity::decode(bytes).map(|_| ()),
    }
}
