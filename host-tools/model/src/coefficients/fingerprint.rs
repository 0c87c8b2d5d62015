//! What tells that a log is no longer what it was: its size, and a checksum of its ends. Logs are
//! long, and grow or are cut at their ends; reading all of a year's rows again would take as long
//! as the fit.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crc::{CRC_32_ISO_HDLC, Crc};

/// Bytes looked at from either end.
const END: u64 = 1 << 16;

/// `size-checksum`, both hexadecimal; `None` for what is no file (a pipe), and cannot be read
/// twice.
///
/// # Errors
/// What the operating system refuses.
pub(super) fn of(log: &Path) -> io::Result<Option<String>> {
    // Asked before it is opened: that would wait for another writer to a pipe.
    let metadata = std::fs::metadata(log)?;
    if !metadata.is_file() {
        return Ok(None);
    }
    let mut file = File::open(log)?;
    let size = metadata.len();
    let mut ends = Vec::new();
    (&mut file).take(END).read_to_end(&mut ends)?;
    file.seek(SeekFrom::Start(size.saturating_sub(END)))?;
    (&mut file).take(END).read_to_end(&mut ends)?;
    Ok(Some(format!("{size:x}-{:08x}", Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&ends))))
}
