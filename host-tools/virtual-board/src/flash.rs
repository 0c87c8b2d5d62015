//! The flash sectors of the virtual board's store, with the rules of NOR flash.
//!
//! Kept in a file, every change is made in place and in order: a process killed at any time leaves
//! what a power cut would.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use support::error::{Error, Result};

/// Sectors 2 and 3 of the STM32F746 (RM0385, Table 3).
pub const FLASH_BYTES: usize = 2 * SECTOR_BYTES;
/// What is erased at once.
pub const SECTOR_BYTES: usize = 32 * 1024;
/// What is written at once: a flash word of embassy-stm32's driver.
pub const WORD_BYTES: usize = 16;

/// What an erased byte reads as.
const ERASED: u8 = 0xFF;

/// Why the flash did nothing: an address beyond it, or not on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused;

/// The two sectors.
#[derive(Debug)]
pub struct VirtualFlash {
    bytes: Vec<u8>,
    file: Option<(File, PathBuf)>,
}

impl Default for VirtualFlash {
    /// Erased, and forgotten at the end.
    fn default() -> Self {
        Self { bytes: vec![ERASED; FLASH_BYTES], file: None }
    }
}

impl VirtualFlash {
    /// The content of `path`, and of it when the board writes. A file that does not exist yet is an
    /// erased flash.
    ///
    /// # Errors
    /// The file cannot be read and written, or has not the size of the flash.
    pub fn open(path: &Path) -> Result<Self> {
        let refused = |error: io::Error| Error::io(path, &error);
        let mut file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(refused)?;
        let mut bytes = Vec::with_capacity(FLASH_BYTES);
        file.read_to_end(&mut bytes).map_err(refused)?;
        if bytes.is_empty() {
            bytes = vec![ERASED; FLASH_BYTES];
            file.write_all(&bytes).map_err(refused)?;
        }
        if bytes.len() != FLASH_BYTES {
            let message =
                format!("{} bytes; expected the {FLASH_BYTES} of a virtual board's flash", bytes.len());
            return Err(Error::failed(message).in_file(path));
        }
        Ok(Self { bytes, file: Some((file, path.to_owned())) })
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Some bytes.
    ///
    /// # Errors
    /// They lie beyond the end.
    pub fn read(&self, offset: u32, count: usize) -> std::result::Result<&[u8], Refused> {
        let from = usize::try_from(offset).map_err(|_| Refused)?;
        let to = from.checked_add(count).ok_or(Refused)?;
        self.bytes.get(from..to).ok_or(Refused)
    }

    /// Programs whole words. Bits only go from 1 to 0: a 1 leaves what is there. `Ok(Err)`: not on
    /// the grid.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, offset: u32, data: &[u8]) -> Result<std::result::Result<(), Refused>> {
        let from = offset as usize;
        let to = from.saturating_add(data.len());
        if !from.is_multiple_of(WORD_BYTES) || !data.len().is_multiple_of(WORD_BYTES) || to > FLASH_BYTES {
            return Ok(Err(Refused));
        }
        for (cell, byte) in self.bytes[from..to].iter_mut().zip(data) {
            *cell &= byte;
        }
        // Word by word, as the chip does: what is cut off is the end.
        for word in (from..to).step_by(WORD_BYTES) {
            self.keep(word, word + WORD_BYTES)?;
        }
        Ok(Ok(()))
    }

    /// Erases the sectors between two addresses. `Ok(Err)`: not on the grid.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn erase(&mut self, from: u32, to: u32) -> Result<std::result::Result<(), Refused>> {
        let (from, to) = (from as usize, to as usize);
        let on_grid = from.is_multiple_of(SECTOR_BYTES) && to.is_multiple_of(SECTOR_BYTES);
        if !on_grid || from > to || to > FLASH_BYTES {
            return Ok(Err(Refused));
        }
        self.bytes[from..to].fill(ERASED);
        for sector in (from..to).step_by(SECTOR_BYTES) {
            self.keep(sector, sector + SECTOR_BYTES)?;
        }
        Ok(Ok(()))
    }

    fn keep(&mut self, from: usize, to: usize) -> Result<()> {
        let Some((file, path)) = &mut self.file else { return Ok(()) };
        file.seek(SeekFrom::Start(from as u64))
            .and_then(|_| file.write_all(&self.bytes[from..to]))
            .map_err(|error| Error::io(path, &error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_only_go_down_until_their_sector_is_erased() {
        let mut flash = VirtualFlash::default();
        assert_eq!(flash.read(0, FLASH_BYTES).unwrap(), [0xFF; FLASH_BYTES]);
        flash.write(32_752, &[0xF0; 32]).unwrap().unwrap();
        flash.write(32_752, &[0x3C; 16]).unwrap().unwrap();
        assert_eq!(flash.read(32_752, 32).unwrap(), [[0x30; 16], [0xF0; 16]].concat());
        flash.erase(32_768, 65_536).unwrap().unwrap();
        assert_eq!(flash.read(32_752, 32).unwrap(), [[0x30; 16], [0xFF; 16]].concat());
    }

    #[test]
    fn what_is_off_the_grid_is_refused_and_changes_nothing() {
        let mut flash = VirtualFlash::default();
        assert_eq!(flash.write(8, &[0; 16]).unwrap(), Err(Refused));
        assert_eq!(flash.write(0, &[0; 8]).unwrap(), Err(Refused));
        assert_eq!(flash.write(65_536, &[0; 16]).unwrap(), Err(Refused));
        flash.write(0, &[0; 16]).unwrap().unwrap();
        assert_eq!(flash.erase(0, 16_384).unwrap(), Err(Refused));
        assert_eq!(flash.erase(32_768, 98_304).unwrap(), Err(Refused));
        assert_eq!(flash.erase(32_768, 0).unwrap(), Err(Refused));
        assert_eq!(flash.read(0, 17).unwrap(), [&[0; 16][..], &[0xFF]].concat());
        assert_eq!(flash.read(65_530, 7), Err(Refused));
    }

    #[test]
    fn a_file_holds_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash.bin");
        let mut flash = VirtualFlash::open(&path).unwrap();
        flash.write(48, &[0x5A; 32]).unwrap().unwrap();
        flash.write(40_000 / 16 * 16, &[0; 16]).unwrap().unwrap();
        flash.erase(32_768, 65_536).unwrap().unwrap();
        // Not closed: what a killed process leaves.
        let again = VirtualFlash::open(&path).unwrap();
        assert_eq!(again.bytes(), flash.bytes());
        assert_eq!(again.read(48, 33).unwrap(), [&[0x5A; 32][..], &[0xFF]].concat());
        std::fs::write(&path, [0; 100]).unwrap();
        assert!(VirtualFlash::open(&path).unwrap_err().to_string().contains("expected the 65536"));
    }
}
