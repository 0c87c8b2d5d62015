//! Items and totals in flash that survive a power cut at any moment.
//!
//! Two sectors, of which one counts. In its first half the items are a log in the format of the
//! crate `sequential-storage`: a new value is appended, a torn one is skipped. In its second half
//! the totals are a log of their own ([`totals`](self)): records of one size, of which the last
//! whole one counts. When something does not fit, or the flash does not take it, all items and the
//! totals are written to the other sector, and last its generation, one above this sector's: with
//! that the other one counts. Only a sector that does not count is ever erased, so it does not
//! matter what an interrupted erase leaves behind: zeros, ones or anything between. (The crate's
//! own way of moving from page to page relies on the markers at both ends of the page that is being
//! erased.)
//!
//! Erasing takes long, so it is done ahead of time ([`Store::prepare`]): a mark in the spare sector
//! says that its erase has ended. While the robot may drive the store only ever writes
//! ([`Store::allow_erasing`]).
//!
//! The same code works on the board's flash and, in `gmr`, on a copy of it in memory
//! ([`RamFlash`]).

mod log;
mod ram;
mod record;
mod sector;
mod spare;
mod totals;

use core::ops::Range;

use embedded_storage_async::nor_flash::NorFlash;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use crate::control_table::{Item, Reason};
use crate::items::{ITEM_BYTES, ITEMS, ItemBytes};
use crate::totals::TOTALS_BYTES;
use log::Log;
use record::{VALUE_BYTES, Versions};
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
/// Key of the mark that a sector's erase has ended.
const PREPARED: u8 = 255;
/// Key and longest value, in whole words of any flash that `sequential-storage` takes.
const SCRATCH: usize = (1 + VALUE_BYTES).next_multiple_of(32);

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
    /// A sector would have to be erased, which is not allowed now.
    Unprepared,
}

impl From<StoreError> for Reason {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Length => Self::Length,
            StoreError::Range | StoreError::Flash => Self::Flash,
            StoreError::ReadBack => Self::ReadBack,
            StoreError::Unprepared => Self::Erase,
        }
    }
}

/// The items. Owns its flash.
///
/// On the board's chip, whose flash is one bank, erasing and writing stall the core: put items at a
/// standstill. Reading never writes.
pub struct Store<F> {
    flash: F,
    /// Where the sectors begin.
    sectors: [u32; 2],
    scratch: Scratch,
    /// What was read last of a map.
    value: [u8; VALUE_BYTES],
    may_erase: bool,
    /// Whether the spare sector is erased; `None` before anybody looked.
    is_prepared: Option<bool>,
    /// Where the totals go next; `None` before anybody looked.
    log: Option<Log>,
    erases: u32,
}

/// What is new in a sector that is to count.
#[derive(Clone, Copy)]
enum Change<'a> {
    Item(Item, &'a Versions),
    Totals(&'a [u8; TOTALS_BYTES]),
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
        Ok(Self {
            flash,
            sectors: [range.start, second],
            scratch: Scratch([0; SCRATCH]),
            value: [0; VALUE_BYTES],
            may_erase: true,
            is_prepared: None,
            log: None,
            erases: 0,
        })
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }

    /// Whether a sector may be erased from now on, as it may at first: what needs it is refused
    /// otherwise ([`StoreError::Unprepared`]).
    pub fn allow_erasing(&mut self, allowed: bool) {
        self.may_erase = allowed;
    }

    /// Sectors erased so far.
    pub const fn erases(&self) -> u32 {
        self.erases
    }

    /// The item's bytes, [`ItemBytes::EMPTY`] when there is none. Flash that holds something else
    /// than a store, such as the stock firmware's settings, has no items.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn get(&mut self, item: Item) -> Result<ItemBytes, StoreError> {
        Ok(self.versions(item).await?.current)
    }

    /// The coefficients that were in use before those that are; [`ItemBytes::EMPTY`] when there are
    /// none.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn previous(&mut self) -> Result<ItemBytes, StoreError> {
        Ok(self.versions(Item::Coefficients).await?.previous)
    }

    async fn versions(&mut self, item: Item) -> Result<Versions, StoreError> {
        match self.current().await? {
            Some(current) => {
                let length = self.find(current.sector, item as u8).await?;
                Ok(Versions::decode(self.value.get(..length).unwrap_or(&[])))
            }
            None => Ok(Versions::NONE),
        }
    }

    /// Copies the item to the front of `into` and gives its length; `None` when there is none.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn fetch(
        &mut self,
        item: Item,
        into: &mut [u8; ITEM_BYTES],
    ) -> Result<Option<usize>, StoreError> {
        let stored = self.get(item).await?;
        let bytes = stored.as_slice();
        if let Some(place) = into.get_mut(..bytes.len()) {
            place.copy_from_slice(bytes);
        }
        Ok((!bytes.is_empty()).then_some(bytes.len()))
    }

    /// Writes the item, reads it back and compares. Whatever happens meanwhile, the old bytes or
    /// the new ones are there afterwards, and every other item. Coefficients that it takes the
    /// place of are the [`previous`](Self::previous) ones from then on: both are one value, so a
    /// power cut cannot part them.
    ///
    /// # Errors
    /// After an error, too, the item is the old one or the new one.
    pub async fn put(&mut self, item: Item, bytes: &[u8]) -> Result<(), StoreError> {
        if bytes.is_empty() {
            return Err(StoreError::Length);
        }
        let versions = self.versions(item).await?;
        let versions = versions.with(item, ItemBytes::new(bytes).ok_or(StoreError::Length)?);
        let current = self.current().await?;
        if let Some(current) = current
            && self.append_item(current.sector, item, &versions).await.is_ok()
        {
            return Ok(());
        }
        self.rewrite(current, Change::Item(item, &versions)).await
    }

    async fn append_item(&mut self, sector: u32, item: Item, versions: &Versions) -> Result<(), StoreError> {
        let mut bytes = [0; VALUE_BYTES];
        let length = versions.encode(&mut bytes);
        self.append(sector, item as u8, bytes.get(..length).ok_or(StoreError::Length)?).await
    }

    /// Writes all items and the totals, what is new among them, to the sector that does not count,
    /// and makes it the one that does.
    async fn rewrite(&mut self, current: Option<Current>, change: Change<'_>) -> Result<(), StoreError> {
        let target = self.spare(current);
        let generation = current.map_or(0, |current| current.generation.wrapping_add(1));
        let totals = match change {
            Change::Totals(new) => Some(*new),
            Change::Item(..) => self.totals().await?,
        };
        self.prepare().await?;
        // From here on it has to be erased again before it can be used, unless it becomes the one
        // that counts.
        (self.is_prepared, self.log) = (Some(false), None);
        for item in ITEMS {
            let mut bytes = [0; VALUE_BYTES];
            let length = match (change, current) {
                (Change::Item(changed, new), _) if item == changed => new.encode(&mut bytes),
                (_, Some(current)) => {
                    let length = self.find(current.sector, item as u8).await?;
                    bytes = self.value;
                    length
                }
                (_, None) => 0,
            };
            let value = bytes.get(..length).ok_or(StoreError::Length)?;
            if !value.is_empty() {
                self.append(target, item as u8, value).await?;
            }
        }
        let mut log = Log::new(target);
        if let Some(totals) = totals {
            self.write_totals(&mut log, &totals).await?;
        }
        self.append(target, GENERATION, &generation.to_le_bytes()).await?;
        self.log = Some(log);
        Ok(())
    }

    /// The sector that counts; `None` where there is no store yet.
    async fn current(&mut self) -> Result<Option<Current>, StoreError> {
        let mut newest: Option<Current> = None;
        for sector in self.sectors {
            let length = self.find(sector, GENERATION).await?;
            let bytes = self.value.get(..length).unwrap_or(&[]);
            let Ok(generation) = bytes.try_into().map(u32::from_le_bytes) else { continue };
            // They differ by one, and may wrap.
            if newest.is_none_or(|other| generation == other.generation.wrapping_add(1)) {
                newest = Some(Current { sector, generation });
            }
        }
        Ok(newest)
    }

    /// Reads a value of the sector's map to the front of `self.value`, so many bytes; 0 where there
    /// is none.
    async fn find(&mut self, sector: u32, key: u8) -> Result<usize, StoreError> {
        let mut map = map(&mut self.flash, sector)?;
        match map.fetch_item::<&[u8]>(&mut self.scratch.0, &key).await {
            Ok(value) => {
                let value = value.unwrap_or(&[]);
                let Some(place) = self.value.get_mut(..value.len()) else { return Ok(0) };
                place.copy_from_slice(value);
                Ok(value.len())
            }
            Err(Error::Storage { value: sector::Refused::ByFlash, .. }) => Err(StoreError::Flash),
            // No store has written this.
            Err(_) => Ok(0),
        }
    }

    async fn append(&mut self, sector: u32, key: u8, bytes: &[u8]) -> Result<(), StoreError> {
        let mut map = map(&mut self.flash, sector)?;
        let written = map.store_item(&mut self.scratch.0, &key, &bytes).await;
        written.map_err(|_| StoreError::Flash)?;
        let length = self.find(sector, key).await?;
        if self.value.get(..length) == Some(bytes) { Ok(()) } else { Err(StoreError::ReadBack) }
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
#[cfg(test)]
mod totals_tests;
