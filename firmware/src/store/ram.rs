//! Flash in memory: what an image of the store is made in, and what tests write to.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

use super::{SECTOR_BYTES, WORD_BYTES};

/// An operation beyond the memory, or across the sectors' or words' boundaries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfReach;

impl NorFlashError for OutOfReach {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

/// Memory with the words of the chip's flash, and its sectors unless given: writing only clears
/// bits, erasing sets them.
#[derive(Debug)]
pub struct RamFlash<'a, const SECTOR: usize = SECTOR_BYTES>(pub &'a mut [u8]);

impl<'a> RamFlash<'a> {
    /// A copy of the chip's flash, or of a part of it.
    pub fn new(memory: &'a mut [u8]) -> Self {
        Self(memory)
    }
}

impl<'a, const SECTOR: usize> From<&'a mut [u8]> for RamFlash<'a, SECTOR> {
    fn from(memory: &'a mut [u8]) -> Self {
        Self(memory)
    }
}

impl<const SECTOR: usize> RamFlash<'_, SECTOR> {
    fn range(&mut self, from: u32, to: u32, unit: usize) -> Result<&mut [u8], OutOfReach> {
        let (from, to) = (from as usize, to as usize);
        if !from.is_multiple_of(unit) || !to.is_multiple_of(unit) {
            return Err(OutOfReach);
        }
        self.0.get_mut(from..to).ok_or(OutOfReach)
    }
}

/// Where `length` bytes from `offset` on end.
fn end(offset: u32, length: usize) -> Result<u32, OutOfReach> {
    u32::try_from(length).ok().and_then(|length| offset.checked_add(length)).ok_or(OutOfReach)
}

impl<const SECTOR: usize> ErrorType for RamFlash<'_, SECTOR> {
    type Error = OutOfReach;
}

impl<const SECTOR: usize> ReadNorFlash for RamFlash<'_, SECTOR> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfReach> {
        let end = end(offset, bytes.len())?;
        bytes.copy_from_slice(self.range(offset, end, Self::READ_SIZE)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl<const SECTOR: usize> NorFlash for RamFlash<'_, SECTOR> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfReach> {
        self.range(from, to, Self::ERASE_SIZE)?.fill(0xFF);
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfReach> {
        let end = end(offset, bytes.len())?;
        for (cell, byte) in self.range(offset, end, Self::WRITE_SIZE)?.iter_mut().zip(bytes) {
            *cell &= byte;
        }
        Ok(())
    }
}
