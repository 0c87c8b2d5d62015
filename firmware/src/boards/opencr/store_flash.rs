//! The two flash sectors that hold the store: 2 and 3, where the stock firmware emulates an EEPROM.

use core::ops::Range;

use embassy_stm32::Peri;
use embassy_stm32::flash::{BANK1_REGION1, Bank1Region1, Blocking, Flash};
use embassy_stm32::peripherals::FLASH;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

use super::erase;

/// Where the store is in the first flash region, which begins with the bootloader.
const STORE: Range<u32> = 0x1_0000..0x2_0000;

/// The store's flash, counted from its own beginning.
///
/// The chip has one bank: while it erases or writes, which happens with interrupts masked, nothing
/// else runs. Erasing a sector of 32 KB takes a quarter of a second and more.
pub struct StoreFlash(Bank1Region1<'static, Blocking>);

/// Beyond the store, not aligned, or refused by the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoreFlashError(NorFlashErrorKind);

impl NorFlashError for StoreFlashError {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl StoreFlash {
    pub(super) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new_blocking(flash).into_blocking_regions().bank1_region1)
    }

    /// `count` bytes from `offset` of the store, in the region's counting; the bootloader before it
    /// is out of reach.
    fn place(offset: u32, count: usize) -> Result<Range<u32>, StoreFlashError> {
        let outside = StoreFlashError(NorFlashErrorKind::OutOfBounds);
        let count = u32::try_from(count).map_err(|_| outside)?;
        let start = STORE.start.checked_add(offset).ok_or(outside)?;
        let end = start.checked_add(count).ok_or(outside)?;
        if end > STORE.end { Err(outside) } else { Ok(start..end) }
    }
}

impl From<embassy_stm32::flash::Error> for StoreFlashError {
    fn from(error: embassy_stm32::flash::Error) -> Self {
        defmt::warn!("flash: {}", error);
        Self(NorFlashError::kind(&error))
    }
}

impl ErrorType for StoreFlash {
    type Error = StoreFlashError;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let place = Self::place(offset, bytes.len())?;
        Ok(self.0.blocking_read(place.start, bytes)?)
    }

    fn capacity(&self) -> usize {
        STORE.len()
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = embassy_stm32::flash::WRITE_SIZE;
    const ERASE_SIZE: usize = BANK1_REGION1.erase_size as usize;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        let place = Self::place(offset, bytes.len())?;
        check_supply()?;
        Ok(self.0.blocking_write(place.start, bytes)?)
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        let outside = StoreFlashError(NorFlashErrorKind::OutOfBounds);
        let count = to.checked_sub(from).ok_or(outside)?;
        let place = Self::place(from, count as usize)?;
        check_supply()?;
        let size = BANK1_REGION1.erase_size;
        if !place.start.is_multiple_of(size) || !place.end.is_multiple_of(size) {
            return Err(StoreFlashError(NorFlashErrorKind::NotAligned));
        }
        let sectors = place.start / size..place.end / size;
        let erased = sectors.into_iter().all(erase::erase);
        if erased { Ok(()) } else { Err(StoreFlashError(NorFlashErrorKind::Other)) }
    }
}

/// With too little the flash would hold what cannot be read back for long.
fn check_supply() -> Result<(), StoreFlashError> {
    if erase::has_supply() { Ok(()) } else { Err(StoreFlashError(NorFlashErrorKind::Other)) }
}
