//! The items' half of a sector, as `sequential-storage` is to see it: its first page, followed by
//! an erased one that it never gets to.

use core::ops::Range;

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

pub(super) struct Sector<'f, F> {
    pub(super) flash: &'f mut F,
    /// Of the sector within the flash.
    pub(super) start: u32,
}

/// Why an operation was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refused {
    /// The flash reported an error.
    ByFlash,
    /// It would close the sector, go beyond it or erase it: the sector is full, or holds what no
    /// store has written.
    HasToStay,
}

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl<F: NorFlash> Sector<'_, F> {
    /// Bytes of a page: the other half of the sector is the totals'.
    pub(super) const PAGE: usize = F::ERASE_SIZE / 2;
    const SIZE: u32 = Self::PAGE as u32;
    /// Both pages.
    pub(super) const RANGE: Range<u32> = 0..2 * Self::SIZE;

    /// Whether an operation ends within the first page, less the last `margin` bytes.
    fn is_inside(offset: u32, length: usize, margin: usize) -> bool {
        offset as usize + length + margin <= Self::PAGE
    }
}

impl<F: NorFlash> ErrorType for Sector<'_, F> {
    type Error = Refused;
}

impl<F: NorFlash> ReadNorFlash for Sector<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        if Self::is_inside(offset, bytes.len(), 0) {
            self.flash.read(self.start + offset, bytes).await.map_err(|_| Refused::ByFlash)
        } else {
            bytes.fill(0xFF);
            Ok(())
        }
    }

    fn capacity(&self) -> usize {
        2 * Self::PAGE
    }
}

impl<F: NorFlash> NorFlash for Sector<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = Self::PAGE;

    async fn erase(&mut self, _from: u32, _to: u32) -> Result<(), Refused> {
        Err(Refused::HasToStay)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        // The last word of a page is the mark that it is full.
        if Self::is_inside(offset, bytes.len(), F::WRITE_SIZE.max(F::READ_SIZE)) {
            self.flash.write(self.start + offset, bytes).await.map_err(|_| Refused::ByFlash)
        } else {
            Err(Refused::HasToStay)
        }
    }
}
