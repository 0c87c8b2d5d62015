//! The store's flash, kept by the robot. Writing and erasing take no board time.

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

use super::Robot;
use crate::exchange::Kind;

/// Sectors and words as on the STM32F746.
const SECTOR_BYTES: usize = 32 * 1024;
const SECTORS: usize = 2;
const WORD_BYTES: usize = 16;
/// Most bytes in one exchange.
const CHUNK: usize = 1024;

/// The store's flash, counted from its own beginning.
pub struct StoreFlash(pub(super) &'static Robot);

impl ErrorType for StoreFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for StoreFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        for (start, chunk) in (offset..).step_by(CHUNK).zip(bytes.chunks_mut(CHUNK)) {
            let count = (chunk.len() as u16).to_le_bytes();
            self.0.exchange(Kind::FlashRead, &[&start.to_le_bytes(), &count], |answer| {
                if answer.len() != chunk.len() {
                    return Err(NorFlashErrorKind::OutOfBounds);
                }
                chunk.copy_from_slice(answer);
                Ok(())
            })?;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR_BYTES
    }
}

impl NorFlash for StoreFlash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = SECTOR_BYTES;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        for (start, chunk) in (offset..).step_by(CHUNK).zip(bytes.chunks(CHUNK)) {
            self.0.exchange(Kind::FlashWrite, &[&start.to_le_bytes(), chunk], done)?;
        }
        Ok(())
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.0.exchange(Kind::FlashErase, &[&from.to_le_bytes(), &to.to_le_bytes()], done)
    }
}

fn done(answer: &[u8]) -> Result<(), NorFlashErrorKind> {
    if answer == [0] { Ok(()) } else { Err(NorFlashErrorKind::Other) }
}
