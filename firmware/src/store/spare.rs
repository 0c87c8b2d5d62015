//! The sector that does not count, erased ahead of time.

use embedded_storage_async::nor_flash::NorFlash;

use super::{Current, PREPARED, Store, StoreError};

/// What the mark says; any bytes would do.
const MARK: [u8; 4] = *b"free";

/// Words that the mark takes: the page's own, the item's head, key and bytes.
const MARK_WORDS: usize = 3;
/// Shorter words than these leave more of them.
const SHORTEST_WORD: usize = 16;

impl<F: NorFlash> Store<F> {
    /// Erases the spare sector, unless that was done since it counted last. From then on the next
    /// move from sector to sector only writes. An erase that was cut off leaves no mark behind,
    /// however blank the sector looks, and is done again.
    ///
    /// # Errors
    /// [`StoreError::Unprepared`] where it has to be erased and may not be now; the flash fails.
    pub async fn prepare(&mut self) -> Result<(), StoreError> {
        let current = self.current().await?;
        let spare = self.spare(current);
        if self.is_prepared().await? {
            return Ok(());
        }
        if !self.may_erase {
            return Err(StoreError::Unprepared);
        }
        self.erases = self.erases.saturating_add(1);
        let end = spare.saturating_add(F::ERASE_SIZE as u32);
        self.flash.erase(spare, end).await.map_err(|_| StoreError::Flash)?;
        self.append(spare, PREPARED, &MARK).await?;
        self.is_prepared = Some(true);
        Ok(())
    }

    /// Whether the spare sector is erased, and nothing in it but the mark that says so.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn is_prepared(&mut self) -> Result<bool, StoreError> {
        if let Some(known) = self.is_prepared {
            return Ok(known);
        }
        let current = self.current().await?;
        let spare = self.spare(current);
        let length = self.find(spare, PREPARED).await?;
        let is_marked = self.value.get(..length) == Some(&MARK);
        let is_prepared = is_marked && self.is_blank(spare).await?;
        self.is_prepared = Some(is_prepared);
        Ok(is_prepared)
    }

    /// The sector that does not count; the first where none does.
    pub(super) fn spare(&self, current: Option<Current>) -> u32 {
        let [first, second] = self.sectors;
        if current.is_some_and(|current| current.sector == first) { second } else { first }
    }

    /// Whether nothing was written behind the mark.
    async fn is_blank(&mut self, sector: u32) -> Result<bool, StoreError> {
        let mut at = MARK_WORDS * F::WRITE_SIZE.max(SHORTEST_WORD);
        while at < F::ERASE_SIZE {
            let count = self.value.len().min(F::ERASE_SIZE - at);
            let Some(bytes) = self.value.get_mut(..count) else { return Ok(false) };
            self.flash.read(sector + at as u32, bytes).await.map_err(|_| StoreError::Flash)?;
            if bytes.iter().any(|byte| *byte != 0xFF) {
                return Ok(false);
            }
            at += count;
        }
        Ok(true)
    }
}
