//! Packets of Dynamixel protocol 2.0, encoded and found in a stream of bytes: no I/O, both
//! directions, board and host.
//!
//! `FF FF FD 00 | ID | LEN16 | INST | parameters | CRC16`. A status has the instruction 55h, and
//! its first parameter is the error. Source: ROBOTIS e-manual, Protocol 2.0; DynamixelSDK
//! protocol2_packet_handler.

use super::checksum::checksum;

/// Addresses every device on the bus.
pub const BROADCAST: u8 = 0xFE;

/// Bytes around the parameters, before stuffing: header, ID, length, instruction, checksum.
pub const OVERHEAD: usize = HEADER.len() + 1 + 2 + 1 + 2;

const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];
/// Where these three bytes stand in the part that is stuffed, one more FDh follows them.
const STUFFED: [u8; 3] = [0xFF, 0xFF, LAST_STUFFED];
const LAST_STUFFED: u8 = 0xFD;
/// Before the instruction: header, ID and length.
const PREFIX: usize = HEADER.len() + 1 + 2;
/// Where the parameters begin.
pub const PARAMETERS: usize = PREFIX + 1;

/// What a packet asks for, or that it answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Instruction {
    /// Is anybody there? Answered with model number and firmware version.
    Ping = 0x01,
    /// Address and length, 16 bits each.
    Read = 0x02,
    /// Address, 16 bits, and data.
    Write = 0x03,
    /// Restarts a servo: the only way out of a shutdown.
    Reboot = 0x08,
    /// An answer: error byte, then data.
    Status = 0x55,
    /// The same registers of several devices: address, length, IDs. Each answers with a status of
    /// its own.
    SyncRead = 0x82,
    /// The same registers of several devices: address, length, then ID and data of each.
    SyncWrite = 0x83,
    /// As a sync read, but the devices' answers are one packet.
    FastSyncRead = 0x8A,
}

impl Instruction {
    /// `None` for codes that no device here knows.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0x01 => Self::Ping,
            0x02 => Self::Read,
            0x03 => Self::Write,
            0x08 => Self::Reboot,
            0x55 => Self::Status,
            0x82 => Self::SyncRead,
            0x83 => Self::SyncWrite,
            0x8A => Self::FastSyncRead,
            _ => return None,
        })
    }
}

/// A packet without stuffing, length and checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// To whom, or from whom.
    pub id: u8,
    /// The instruction's code: devices answer to those they do not know.
    pub instruction: u8,
    /// What follows it.
    pub parameters: &'a [u8],
}

/// The packet does not fit the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooLong;

/// Writes a packet into `buffer` and gives the bytes to send.
///
/// # Errors
/// The buffer is too short: [`OVERHEAD`] and four bytes for every three parameters always suffice.
pub fn encode<'b>(
    id: u8,
    instruction: Instruction,
    parameters: &[&[u8]],
    buffer: &'b mut [u8],
) -> Result<&'b [u8], TooLong> {
    let mut count = 0;
    for piece in parameters {
        let place = buffer.get_mut(PARAMETERS + count..).and_then(|rest| rest.get_mut(..piece.len()));
        place.ok_or(TooLong)?.copy_from_slice(piece);
        count += piece.len();
    }
    seal(id, instruction, count, buffer)
}

/// Makes a packet of the `count` parameters that stand in `buffer` from [`PARAMETERS`] on, where
/// they are, and gives the bytes to send.
///
/// # Errors
/// As [`encode`].
pub fn seal(id: u8, instruction: Instruction, count: usize, buffer: &mut [u8]) -> Result<&[u8], TooLong> {
    let [a, b, c, d] = HEADER;
    *buffer.first_chunk_mut().ok_or(TooLong)? = [a, b, c, d, id, 0, 0, instruction as u8];
    let end = PARAMETERS + count;
    let body = buffer.get(PREFIX..end).ok_or(TooLong)?;
    let stuffing = count_stuffed(body);
    let length = end + stuffing;
    let counted = u16::try_from(length - PREFIX + 2).map_err(|_| TooLong)?;
    stuff(buffer.get_mut(PREFIX..length).ok_or(TooLong)?, end - PREFIX);
    if let Some(place) = buffer.get_mut(PREFIX - 2..PREFIX) {
        place.copy_from_slice(&counted.to_le_bytes());
    }
    let sum = checksum(buffer.get(..length).ok_or(TooLong)?);
    buffer.get_mut(length..length + 2).ok_or(TooLong)?.copy_from_slice(&sum.to_le_bytes());
    buffer.get(..length + 2).ok_or(TooLong)
}

/// How many bytes stuffing adds. Of three bytes one is looked at, as long as it is none of the
/// stuffed ones: what lies before it ends there, and what begins behind it ends three on.
fn count_stuffed(body: &[u8]) -> usize {
    let (mut count, mut at) = (0, STUFFED.len() - 1);
    while let Some(byte) = body.get(at) {
        count += usize::from(*byte == LAST_STUFFED && is_stuffed(body, at + 1));
        at += if *byte == 0xFF { 1 } else { STUFFED.len() };
    }
    count
}

/// Whether one more byte follows the first so many.
fn is_stuffed(body: &[u8], count: usize) -> bool {
    body.get(..count).is_some_and(|first| first.ends_with(&STUFFED))
}

/// Moves the first `count` bytes apart until they fill the whole place, from the last one on: each
/// goes behind where it was.
fn stuff(body: &mut [u8], count: usize) {
    let (mut from, mut to) = (count, body.len());
    while from < to && from > 0 {
        let last = body.get(from - 1).copied().unwrap_or(0);
        if is_stuffed(body, from) {
            to -= 1;
            if let Some(place) = body.get_mut(to) {
                *place = last;
            }
        }
        from -= 1;
        to -= 1;
        if let Some(place) = body.get_mut(to) {
            *place = last;
        }
    }
}

/// Why bytes that began like a packet are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Broken {
    /// The checksum does not match: a bit has flipped.
    Checksum,
    /// Longer than the buffer, or too short to have an instruction and a checksum.
    Length,
}

/// Finds packets in a stream. `N` is the longest packet, stuffing included, that it takes.
///
/// It looks for the header at every byte: what is lost in a broken packet is that packet. The one
/// that follows is found even if the broken one's length pointed beyond it, and as soon as its
/// header is there: stuffing keeps headers out of packets.
#[derive(Debug, Clone)]
pub struct Parser<const N: usize> {
    buffer: [u8; N],
    filled: usize,
    /// Bytes at the front that have been handed out, or found to be none of a packet.
    consumed: usize,
}

impl<const N: usize> Default for Parser<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Parser<N> {
    /// Has received nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { buffer: [0; N], filled: 0, consumed: 0 }
    }

    /// Forgets what it has.
    pub fn clear(&mut self) {
        self.filled = 0;
        self.consumed = 0;
    }

    /// Where received bytes go; [`Self::received`] says how many came. Never empty.
    pub fn space(&mut self) -> &mut [u8] {
        self.discard(0);
        if self.filled >= N {
            // Cannot be a packet: those too long are refused as soon as their length is known.
            self.clear();
        }
        self.buffer.get_mut(self.filled..).unwrap_or(&mut [])
    }

    /// `count` bytes were written to [`Self::space`].
    pub fn received(&mut self, count: usize) {
        self.filled = (self.filled + count).min(N);
    }

    /// Takes as many of `bytes` as fit and says how many. Those that did not fit do after
    /// [`Self::next_packet`] gave `None`.
    pub fn feed(&mut self, bytes: &[u8]) -> usize {
        let space = self.space();
        let count = bytes.len().min(space.len());
        if let (Some(place), Some(bytes)) = (space.get_mut(..count), bytes.get(..count)) {
            place.copy_from_slice(bytes);
        }
        self.received(count);
        count
    }

    /// The next packet, or that there was a broken one; `None` when more bytes are needed.
    pub fn next_packet(&mut self) -> Option<Result<Packet<'_>, Broken>> {
        self.discard(0);
        let start = self.find_header();
        self.discard(start);
        let length = match self.buffer.get(..self.filled)? {
            [0xFF, 0xFF, 0xFD, 0x00, _, low, high, ..] => usize::from(u16::from_le_bytes([*low, *high])),
            _ => return None,
        };
        let end = PREFIX + length;
        if length < 3 || end > N {
            self.consumed = HEADER.len();
            return Some(Err(Broken::Length));
        }
        if self.filled < end {
            // Another header before its end: what began here was cut short. Waiting for the rest
            // would hold up the next packet.
            self.consumed = self.next_header()?;
            return Some(Err(Broken::Length));
        }
        let (body, sum) = self.buffer.get(..end)?.split_last_chunk::<2>()?;
        if checksum(body) != u16::from_le_bytes(*sum) {
            // Its length may be what is broken: only the header is known not to begin a packet.
            self.consumed = HEADER.len();
            return Some(Err(Broken::Checksum));
        }
        self.consumed = end;
        let id = *self.buffer.get(HEADER.len())?;
        let instruction = *self.buffer.get(PREFIX)?;
        let length = unstuff(self.buffer.get_mut(PREFIX..end - 2)?);
        let parameters = self.buffer.get(PREFIX + 1..PREFIX + length)?;
        Some(Ok(Packet { id, instruction, parameters }))
    }

    /// Where the next header begins or may begin.
    fn find_header(&self) -> usize {
        let bytes = self.buffer.get(..self.filled).unwrap_or(&[]);
        let begins = |at: &usize| {
            let rest = bytes.get(*at..).unwrap_or(&[]);
            rest.iter().zip(&HEADER).all(|(byte, expected)| byte == expected)
        };
        (0..bytes.len()).find(begins).unwrap_or(bytes.len())
    }

    /// Where behind the first header a whole one begins.
    fn next_header(&self) -> Option<usize> {
        let bytes = self.buffer.get(HEADER.len()..self.filled)?;
        bytes.windows(HEADER.len()).position(|window| window == HEADER).map(|at| at + HEADER.len())
    }

    /// Moves what follows the consumed bytes and `more` to the front.
    fn discard(&mut self, more: usize) {
        // Always the filled part: said so that the compiler sees that nothing here can panic.
        let filled = self.buffer.get_mut(..self.filled).unwrap_or_default();
        let count = self.consumed.saturating_add(more).min(filled.len());
        self.consumed = 0;
        if count > 0 {
            filled.copy_within(count.., 0);
            self.filled -= count;
        }
    }
}

/// Takes the stuffing out, in place, and gives the length that is left.
fn unstuff(bytes: &mut [u8]) -> usize {
    // Most have no such byte, and are as they are.
    if !bytes.contains(&LAST_STUFFED) {
        return bytes.len();
    }
    let mut follows = false;
    let mut kept = 0;
    for at in 0..bytes.len() {
        let Some(&byte) = bytes.get(at) else { break };
        if core::mem::take(&mut follows) && byte == LAST_STUFFED {
            continue;
        }
        if let Some(place) = bytes.get_mut(kept) {
            *place = byte;
        }
        kept += 1;
        follows = byte == LAST_STUFFED && is_stuffed(bytes, kept);
    }
    kept
}

#[cfg(test)]
mod tests;
