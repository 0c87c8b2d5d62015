//! Cursors over bytes: what does not fit is not written, what is missing is not read. And the
//! checksum of what is kept.

use crc::{CRC_32_ISO_HDLC, Crc};

/// Of items and totals; its table is in the image once.
pub(crate) static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Writes one after the other what fits.
pub(crate) struct Writer<'a>(pub(crate) &'a mut [u8]);

impl Writer<'_> {
    pub(crate) fn put<const N: usize>(&mut self, value: [u8; N]) {
        let rest = core::mem::take(&mut self.0);
        if let Some((place, rest)) = rest.split_first_chunk_mut::<N>() {
            *place = value;
            self.0 = rest;
        }
    }
}

/// Takes one after the other while there are enough.
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(crate) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (value, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*value)
    }
}
