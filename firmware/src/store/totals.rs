//! The log of totals: records of one size in the second half of a sector, each with a CRC-32, of
//! which the last whole one counts.
//!
//! A log of its own, and not an item, because it is written while the robot drives: it is known
//! where the next record goes, so it costs a few words and no search.

use embedded_storage_async::nor_flash::NorFlash;

use super::log::Log;
use super::{Change, Store, StoreError};
use crate::bytes::CRC;
use crate::totals::TOTALS_BYTES;

/// Bytes of a record: three words of the chip's flash.
pub(super) const RECORD_BYTES: usize = TOTALS_BYTES + 4;

const BLANK: [u8; RECORD_BYTES] = [0xFF; RECORD_BYTES];

/// Records that may be skipped, because a cut or a worn cell spoiled them, before the log counts as
/// full.
const MOST_SKIPS: usize = 4;

/// Some drivers want what they write on a word boundary.
#[repr(align(4))]
struct Record([u8; RECORD_BYTES]);

impl<F: NorFlash> Store<F> {
    /// Records that a sector has room for.
    const SLOTS: usize = F::ERASE_SIZE / 2 / RECORD_BYTES;

    /// The totals that were appended last; `None` where there are none.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn totals(&mut self) -> Result<Option<[u8; TOTALS_BYTES]>, StoreError> {
        let Some(log) = self.log().await? else { return Ok(None) };
        for index in (0..log.next).rev() {
            if let Some(totals) = open(&self.read_record(slot::<F>(log.sector, index)).await?) {
                return Ok(Some(totals));
            }
        }
        Ok(None)
    }

    /// Whether [`append_totals`](Self::append_totals) would have to move to the other sector, which
    /// takes some milliseconds.
    ///
    /// # Errors
    /// The flash cannot be read.
    pub async fn is_log_full(&mut self) -> Result<bool, StoreError> {
        Ok(self.log().await?.is_none_or(|log| log.next >= Self::SLOTS))
    }

    /// Appends totals, reads them back and compares. Whatever happens meanwhile, the old ones or
    /// these are there afterwards, and every item.
    ///
    /// # Errors
    /// After an error, too, the totals are the old ones or these.
    pub async fn append_totals(&mut self, totals: &[u8; TOTALS_BYTES]) -> Result<(), StoreError> {
        if let Some(mut log) = self.log().await? {
            let written = self.write_totals(&mut log, totals).await;
            self.log = Some(log);
            if written.is_ok() {
                return Ok(());
            }
        }
        let current = self.current().await?;
        self.rewrite(current, Change::Totals(totals)).await
    }

    /// Writes a record to the next place that takes it.
    pub(super) async fn write_totals(
        &mut self,
        log: &mut Log,
        totals: &[u8; TOTALS_BYTES],
    ) -> Result<(), StoreError> {
        let record = seal(totals);
        let mut result = Err(StoreError::Flash);
        for _ in 0..MOST_SKIPS {
            if log.next >= Self::SLOTS {
                break;
            }
            let at = slot::<F>(log.sector, log.next);
            log.next += 1;
            result = match self.flash.write(at, &record.0).await {
                Ok(()) if self.read_record(at).await?.0 == record.0 => return Ok(()),
                Ok(()) => Err(StoreError::ReadBack),
                Err(_) => Err(StoreError::Flash),
            };
        }
        result
    }

    /// `None` where no sector counts yet.
    async fn log(&mut self) -> Result<Option<Log>, StoreError> {
        if self.log.is_none()
            && let Some(current) = self.current().await?
        {
            // Behind everything that was ever written, whole or torn.
            let mut next = Self::SLOTS;
            while next > 0 && self.read_record(slot::<F>(current.sector, next - 1)).await?.0 == BLANK {
                next -= 1;
            }
            self.log = Some(Log { sector: current.sector, next });
        }
        Ok(self.log)
    }

    async fn read_record(&mut self, at: u32) -> Result<Record, StoreError> {
        let mut record = Record(BLANK);
        self.flash.read(at, &mut record.0).await.map_err(|_| StoreError::Flash)?;
        Ok(record)
    }
}

/// Where a record is.
fn slot<F: NorFlash>(sector: u32, index: usize) -> u32 {
    sector + (F::ERASE_SIZE / 2 + index * RECORD_BYTES) as u32
}

fn seal(totals: &[u8; TOTALS_BYTES]) -> Record {
    let mut record = Record(BLANK);
    if let Some((body, checksum)) = record.0.split_first_chunk_mut() {
        *body = *totals;
        checksum.copy_from_slice(&CRC.checksum(totals).to_le_bytes());
    }
    record
}

fn open(record: &Record) -> Option<[u8; TOTALS_BYTES]> {
    let (body, checksum) = record.0.split_first_chunk()?;
    (CRC.checksum(body).to_le_bytes() == checksum).then_some(*body)
}
