//! Items in flash that survive a power cut at any moment.
//!
//! Two sectors, of which one counts. Within it the items are a log in the format of the crate `sequential-storage`: a new value is
//! appended, a torn one is skipped. When an item does not fit, or the flash does not take it, all items are written to the other
//! sector, erased first, and last its generation, one above this sector's: with that the other one counts. Only a sector that
//! does not count is ever erased, so it does not matter what an interrupted erase leaves behind: zeros, ones or anything between. (The
//! crate's own way of moving from page to page relies on the markers at both ends of the page that is being erased.)
//!
//! The same code works on the board's flash and, in `gmr`, on a copy of it in memory ([`RamFlash`]).

mod ram;
mod sector;

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use crate::control_table::{Item, Reason, UPLOAD_BYTES};
use crate::items::{ITEMS, ItemBytes};
use sector::Sector;

pub use ram::{OutOfReach, RamFlash};

/// Where the two sectors begin in the chip's address space: sectors 2 and 3 of the STM32F746.
pub const ADDRESS: u32 = 0x0801_0000;
/// The same within the chip's flash.
pub const OFFSET: u32 = 0x1_0000;
/// Bytes of the store.
pub const BYTES: usize = 2 * SECTOR_BYTES;
/// Bytes that are erased together.
pub const SECTOR_BYTES: usize = 32 * 1024;
/// Bytes that are written together: as the driver of the chip's flash has it.
pub const WORD_BYTES: usize = 16;

/// Key of a sector's generation, beside those of the items.
const GENERATION: u8 = 0;
/// Key and longest item, in whole words of any flash that `sequential-storage` takes.
const SCRATCH: usize = (1 + UPLOAD_BYTES).next_multiple_of(32);

/// Some drivers want what they write on a word boundary.
#[repr(align(4))]
struct Scratch([u8; SCRATCH]);

/// Why an item is not there, or not what it was to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreError {
    /// The range is not two whole sectors.
    Range,
    /// More bytes than an item has, or none.
    Length,
    /// The flash reported an error.
    Flash,
    /// What was read back is not what was written.
    ReadBack,
}

impl From<StoreError> for Reason {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Length => Self::Length,
            StoreError::Range | StoreError::Flash => Self::Flash,
            StoreError::ReadBack => Self::ReadBack,
        }
    }
}

/// The items. Owns its flash.
///
/// On the board's chip, whose flash is one bank, erasing and writing stall the core: put items at a standstill. Reading never writes.
pub struct Store<F> {
    flash: F,
    /// Where the sectors begin.
    sectors: [u32; 2],
    scratch: Scratch,
}

impl<F: NorFlash> Store<F> {
    /// The store in `range` of `flash`.
    ///
    /// # Errors
    /// A range that is not two whole sectors.
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, StoreError> {
        let size = u32::try_from(F::ERASE_SIZE).map_err(|_| StoreError::Range)?;
        let second = range.start.checked_add(size).ok_or(StoreError::Range)?;
        if !range.start.is_multiple_of(size) || second.checked_add(size) != Some(range.end) {
            return Err(StoreError::Range);
        }
        Ok(Self { flash, sectors: [range.start, second], scratch: Scratch([0; SCRATCH]) })
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }

    /// The item's bytes, [`ItemBytes::EMPTY`] when there is none. Flash that holds something else than a store, such as the stock
    /// firmware's settings, has no items.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn get(&mut self, item: Item) -> Result<ItemBytes, StoreError> {
        match self.current().await? {
            Some(current) => self.find(current.sector, item as u8).await,
            None => Ok(ItemBytes::EMPTY),
        }
    }

    /// Copies the item to the front of `into` and gives its length; `None` when there is none.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn fetch(
        &mut self,
        item: Item,
        into: &mut [u8; UPLOAD_BYTES],
    ) -> Result<Option<usize>, StoreError> {
        let found = self.get(item).await?;
        let bytes = found.as_slice();
        if let Some(place) = into.get_mut(..bytes.len()) {
            place.copy_from_slice(bytes);
        }
        Ok((!bytes.is_empty()).then_some(bytes.len()))
    }

    /// Writes the item, reads it back and compares. Whatever happens meanwhile, the old bytes or the new ones are there
    /// afterwards, and every other item.
    ///
    /// # Errors
    /// After an error, too, the item is the old one or the new one.
    pub async fn put(&mut self, item: Item, bytes: &[u8]) -> Result<(), StoreError> {
        let new = ItemBytes::new(bytes).filter(|_| !bytes.is_empty()).ok_or(StoreError::Length)?;
        let current = self.current().await?;
        if let Some(current) = current
            && self.append(current.sector, item as u8, &new).await.is_ok()
        {
            return Ok(());
        }
        self.rewrite(current, item, &new).await
    }

    /// Writes all items, `new` among them, to the sector that does not count, and makes it the one that does.
    async fn rewrite(
        &mut self,
        current: Option<Current>,
        item: Item,
        new: &ItemBytes,
    ) -> Result<(), StoreError> {
        let [first, second] = self.sectors;
        let (target, generation) = match current {
            Some(current) if current.sector == first => (second, current.generation.wrapping_add(1)),
            Some(current) => (first, current.generation.wrapping_add(1)),
            None => (first, 0),
        };
        let end = target.saturating_add(F::ERASE_SIZE as u32);
        self.flash.erase(target, end).await.map_err(|_| StoreError::Flash)?;
        for other in ITEMS {
            let kept = match current {
                _ if other == item => *new,
                Some(current) => self.find(current.sector, other as u8).await?,
                None => ItemBytes::EMPTY,
            };
            if !kept.as_slice().is_empty() {
                self.append(target, other as u8, &kept).await?;
            }
        }
        let generation = ItemBytes::new(&generation.to_le_bytes()).ok_or(StoreError::Length)?;
        self.append(target, GENERATION, &generation).await
    }

    /// The sector that counts; `None` where there is no store yet.
    async fn current(&mut self) -> Result<Option<Current>, StoreError> {
        let mut newest: Option<Current> = None;
        for sector in self.sectors {
            let found = self.find(sector, GENERATION).await?;
            let Ok(generation) = found.as_slice().try_into().map(u32::from_le_bytes) else { continue };
            // They differ by one, and may wrap.
            if newest.is_none_or(|other| generation == other.generation.wrapping_add(1)) {
                newest = Some(Current { sector, generation });
            }
        }
        Ok(newest)
    }

    async fn find(&mut self, sector: u32, key: u8) -> Result<ItemBytes, StoreError> {
        let mut map = map(&mut self.flash, sector)?;
        match map.fetch_item::<&[u8]>(&mut self.scratch.0, &key).await {
            Ok(found) => Ok(found.and_then(ItemBytes::new).unwrap_or(ItemBytes::EMPTY)),
            Err(Error::Storage { value: sector::Refused::ByFlash, .. }) => Err(StoreError::Flash),
            // No store has written this.
            Err(_) => Ok(ItemBytes::EMPTY),
        }
    }

    async fn append(&mut self, sector: u32, key: u8, bytes: &ItemBytes) -> Result<(), StoreError> {
        let mut map = map(&mut self.flash, sector)?;
        let written = map.store_item(&mut self.scratch.0, &key, &bytes.as_slice()).await;
        written.map_err(|_| StoreError::Flash)?;
        if self.find(sector, key).await? == *bytes { Ok(()) } else { Err(StoreError::ReadBack) }
    }
}

/// The sector that counts.
#[derive(Debug, Clone, Copy)]
struct Current {
    sector: u32,
    generation: u32,
}

type Map<'f, F> = MapStorage<u8, Sector<'f, F>, Cache<Uncached, Uncached, Uncached, u8>>;

fn map<F: NorFlash>(flash: &mut F, start: u32) -> Result<Map<'_, F>, StoreError> {
    let config = MapConfig::try_new(Sector::<F>::RANGE).map_err(|_| StoreError::Range)?;
    // No cache: items are read once at start and put by hand.
    Ok(MapStorage::new(Sector { flash, start }, config, Cache::new_uncached()))
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod torn;
