//! What calibration and robot identity have in common: `magic | version u16 | length u16 | body |
//! CRC-32`.

use crate::bytes::{CRC, Reader, Writer};
use crate::control_table::Reason;

/// Bytes around the body.
pub(super) const FRAME: usize = HEAD + CHECKSUM;

const HEAD: usize = 4 + 2 + 2;
const CHECKSUM: usize = 4;
const VERSION: u16 = 1;

/// An image of `N` bytes; `body` writes what stands between head and checksum.
pub(super) fn seal<const N: usize>(magic: [u8; 4], body: impl FnOnce(&mut Writer<'_>)) -> [u8; N] {
    let mut image = [0; N];
    let mut writer = Writer(&mut image);
    writer.put(magic);
    writer.put(VERSION.to_le_bytes());
    writer.put((N as u16).to_le_bytes());
    body(&mut writer);
    if let Some((body, checksum)) = image.split_last_chunk_mut::<CHECKSUM>() {
        *checksum = CRC.checksum(body).to_le_bytes();
    }
    image
}

/// The body of an image that has this magic, a known version, the length that it says and the
/// checksum that belongs to it.
pub(super) fn open(magic: [u8; 4], image: &[u8]) -> Result<&[u8], Reason> {
    if image.is_empty() {
        return Err(Reason::Empty);
    }
    let mut reader = Reader(image);
    if reader.take().ok_or(Reason::Length)? != magic {
        return Err(Reason::NotAnImage);
    }
    if reader.take().map(u16::from_le_bytes).ok_or(Reason::Length)? != VERSION {
        return Err(Reason::Version);
    }
    let length = reader.take().map(u16::from_le_bytes).ok_or(Reason::Length)?;
    if usize::from(length) != image.len() {
        return Err(Reason::Length);
    }
    let (checked, checksum) = image.split_last_chunk::<CHECKSUM>().ok_or(Reason::Length)?;
    if CRC.checksum(checked) != u32::from_le_bytes(*checksum) {
        return Err(Reason::Checksum);
    }
    checked.get(HEAD..).ok_or(Reason::Length)
}
