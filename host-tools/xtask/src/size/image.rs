//! How much of the board's memories an image fills.

use std::ops::Range;

use object::{Object, ObjectSegment};

/// Static RAM: SRAM1 and SRAM2 (memory.x).
const RAM: Range<u64> = 0x2001_0000..0x2005_0000;

/// Bytes of an image by where they are.
#[derive(Debug, Default, PartialEq, Eq, Clone, Copy)]
pub(super) struct Usage {
    /// Code, constants, and what `.data` starts with: what a programmer writes.
    pub(super) flash: u64,
    /// `.data`, `.bss` and `.uninit`.
    pub(super) ram: u64,
}

/// Reads it from the loadable segments of an ELF.
pub(super) fn usage(elf: &[u8]) -> Result<Usage, object::Error> {
    let file = object::File::parse(elf)?;
    let flash = file.segments().map(|segment| segment.file_range().1).sum();
    let ram = file
        .segments()
        .filter(|segment| RAM.contains(&segment.address()))
        .map(|segment| segment.size())
        .sum();
    Ok(Usage { flash, ram })
}
