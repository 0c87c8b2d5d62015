//! Flash whose power is cut: after a given number of words written or sectors erased, in the middle
//! of one.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// Small sectors, so that they fill often; words as the chip's.
pub(super) const SECTOR: usize = 2048;
pub(super) const WORD: usize = 16;
pub(super) const BYTES: usize = 2 * SECTOR;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Failure {
    /// The power is off: nothing works until [`TornFlash::power_up`].
    PowerCut,
    /// The word was written before, and this flash writes none twice.
    WrittenBefore,
    Misuse,
}

impl NorFlashError for Failure {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// What a second write to a word does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rewriting {
    /// Clears more bits, as on the chip here.
    Clears,
    /// Fails, as on chips whose words have a checksum of their own.
    Fails,
}

#[derive(Debug, Clone)]
pub(super) struct TornFlash {
    pub(super) cells: Vec<u8>,
    written: Vec<bool>,
    rewriting: Rewriting,
    /// Operations until the power goes; `None` for never.
    until_cut: Option<u32>,
    is_off: bool,
    random: u64,
}

impl TornFlash {
    pub(super) fn new(rewriting: Rewriting) -> Self {
        Self {
            cells: vec![0xFF; BYTES],
            written: vec![false; BYTES / WORD],
            rewriting,
            until_cut: None,
            is_off: false,
            random: 0,
        }
    }

    /// Power is back, and goes again in the middle of operation `cut` from now; `seed` decides on
    /// the damage.
    pub(super) fn power_up(&mut self, cut: Option<u32>, seed: u64) {
        self.random = seed;
        self.until_cut = cut;
        self.is_off = false;
    }

    pub(super) fn is_off(&self) -> bool {
        self.is_off
    }

    /// SplitMix64.
    fn random(&mut self) -> u64 {
        self.random = self.random.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.random ^ (self.random >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Whether this operation is the one in which the power goes.
    fn is_cut(&mut self) -> bool {
        match &mut self.until_cut {
            Some(0) => {
                self.is_off = true;
                true
            }
            Some(remaining) => {
                *remaining -= 1;
                false
            }
            None => false,
        }
    }

    fn write_word(&mut self, at: usize, word: &[u8]) -> Result<(), Failure> {
        if self.rewriting == Rewriting::Fails && self.written[at / WORD] {
            return Err(Failure::WrittenBefore);
        }
        let is_cut = self.is_cut();
        // Of a torn word each bit is written or not; sometimes hardly any is, sometimes nearly all
        // are.
        let sparse = self.random() & self.random() & self.random() & self.random() & self.random();
        let masks = [self.random(), sparse, !sparse];
        let mask = masks[self.random() as usize % masks.len()].to_le_bytes();
        for (i, (cell, byte)) in self.cells[at..at + WORD].iter_mut().zip(word).enumerate() {
            let kept = if is_cut { mask[i % 8] } else { 0 };
            let before = *cell;
            *cell &= byte | kept;
            self.written[at / WORD] |= *cell != before;
        }
        if is_cut { Err(Failure::PowerCut) } else { Ok(()) }
    }

    /// An erase that is cut may leave anything: cells that are still as they were, programmed to
    /// zero first, as such chips do, or erased, in any mixture.
    fn erase_sector(&mut self, at: usize) -> Result<(), Failure> {
        let is_cut = self.is_cut();
        let way = if is_cut { self.random() % 6 } else { 1 };
        for i in at..at + SECTOR {
            let (noise, sparse) =
                (self.random() as u8, (self.random() & self.random() & self.random()) as u8);
            self.cells[i] = match way {
                0 => 0,
                1 => 0xFF,
                2 => self.cells[i] & noise,
                3 => self.cells[i] | noise,
                4 => self.cells[i] & !sparse,
                _ => self.cells[i] | sparse,
            };
        }
        self.written[at / WORD..(at + SECTOR) / WORD].fill(is_cut);
        if is_cut { Err(Failure::PowerCut) } else { Ok(()) }
    }
}

impl ErrorType for &mut TornFlash {
    type Error = Failure;
}

impl ReadNorFlash for &mut TornFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failure> {
        if self.is_off {
            return Err(Failure::PowerCut);
        }
        let offset = offset as usize;
        bytes.copy_from_slice(self.cells.get(offset..offset + bytes.len()).ok_or(Failure::Misuse)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for &mut TornFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failure> {
        let (from, to) = (from as usize, to as usize);
        if self.is_off {
            return Err(Failure::PowerCut);
        }
        if !from.is_multiple_of(SECTOR) || !to.is_multiple_of(SECTOR) || to > BYTES {
            return Err(Failure::Misuse);
        }
        (from..to).step_by(SECTOR).try_for_each(|at| self.erase_sector(at))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        let offset = offset as usize;
        if self.is_off {
            return Err(Failure::PowerCut);
        }
        let is_whole = offset.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD);
        if !is_whole || offset + bytes.len() > BYTES {
            return Err(Failure::Misuse);
        }
        for (i, word) in bytes.chunks(WORD).enumerate() {
            self.write_word(offset + i * WORD, word)?;
        }
        Ok(())
    }
}
