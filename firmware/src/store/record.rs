//! What stands in flash for an item: those bytes that count, and, of coefficients, those before
//! them.
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 2 | bytes of the image that counts, n |
//! | 2 | n | that image |
//! | 2 + n | the rest | the image before it; nothing where there was none |

use crate::control_table::Item;
use crate::items::{ITEM_BYTES, ItemBytes};

/// Most bytes.
pub(super) const VALUE_BYTES: usize = 2 + 2 * ITEM_BYTES;

/// An item and the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Versions {
    pub(super) current: ItemBytes,
    pub(super) previous: ItemBytes,
}

impl Versions {
    pub(super) const NONE: Self = Self { current: ItemBytes::EMPTY, previous: ItemBytes::EMPTY };

    /// `new` counts. Coefficients that it takes the place of are kept; the same once more changes
    /// nothing.
    pub(super) fn with(self, item: Item, new: ItemBytes) -> Self {
        let previous = match item {
            _ if new == self.current => self.previous,
            Item::Coefficients => self.current,
            Item::Calibration | Item::Robot => ItemBytes::EMPTY,
        };
        Self { current: new, previous }
    }

    /// Writes them to the front of `into`: so many bytes.
    pub(super) fn encode(&self, into: &mut [u8; VALUE_BYTES]) -> usize {
        let (current, previous) = (self.current.as_slice(), self.previous.as_slice());
        let head = (current.len() as u16).to_le_bytes();
        let bytes = head.iter().chain(current).chain(previous);
        into.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
        head.len() + current.len() + previous.len()
    }

    /// Nothing where no store has written this.
    pub(super) fn decode(value: &[u8]) -> Self {
        let Some((head, images)) = value.split_first_chunk() else { return Self::NONE };
        let Some((current, previous)) = images.split_at_checked(usize::from(u16::from_le_bytes(*head)))
        else {
            return Self::NONE;
        };
        match (ItemBytes::new(current), ItemBytes::new(previous)) {
            (Some(current), Some(previous)) => Self { current, previous },
            _ => Self::NONE,
        }
    }
}
