//! From the host's bytes to the board's answers.

use super::{FIRMWARE, State, render, write};
use crate::control_table::{BOARD_ID, BOARD_MODEL, END};
use crate::dynamixel::packet::{BROADCAST, Instruction, OVERHEAD, PARAMETERS, Packet, Parser, seal};
use crate::dynamixel::status::Refusal;

/// Bytes of the longest answer: a read of the whole table, with an error byte and all the stuffing
/// there can be.
pub const LONGEST_ANSWER: usize = OVERHEAD + stuffed(1 + 1 + END as usize);

/// Where an answer's data stand: behind its error byte.
const DATA: usize = PARAMETERS + 1;

/// Bytes of the longest instruction that a host needs: a write of the upload window.
pub const LONGEST_INSTRUCTION: usize = 512;

/// One more byte for every three.
const fn stuffed(bytes: usize) -> usize {
    bytes + bytes.div_ceil(3)
}

/// What came of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// An answer stands at the front of the buffer, so many bytes.
    Answer(usize),
    /// None: it was broken, or for somebody else, or for everybody.
    Silence,
}

/// The device side of the link.
///
/// Answers complete instructions for its ID, and pings for any; a write for any ID is carried out
/// without an answer.
pub struct Device {
    parser: Parser<LONGEST_INSTRUCTION>,
}

impl Default for Device {
    fn default() -> Self {
        Self::new()
    }
}

impl Device {
    /// Has received nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { parser: Parser::new() }
    }

    /// Takes as many of the received bytes as fit and says how many; the rest does after
    /// [`Self::answer`] gave `None`.
    pub fn feed(&mut self, bytes: &[u8]) -> usize {
        self.parser.feed(bytes)
    }

    /// The cable was pulled: forgets a packet that had begun.
    pub fn clear(&mut self) {
        self.parser.clear();
    }

    /// Carries out what was received, up to the first instruction that is answered: the answer
    /// stands at the front of `buffer`, so many bytes. `None` when more has to be received. A
    /// `buffer` of [`LONGEST_ANSWER`] suffices; an answer that does not fit becomes a refusal.
    pub fn answer(&mut self, state: &mut State<'_>, buffer: &mut [u8]) -> Option<usize> {
        loop {
            if let Step::Answer(length) = self.step(state, buffer)? {
                return Some(length);
            }
        }
    }

    /// As [`Self::answer`], but of one packet, whole or broken: for who has other work to do
    /// between two of them.
    pub fn step(&mut self, state: &mut State<'_>, buffer: &mut [u8]) -> Option<Step> {
        self.step_with(|work| work(state), buffer)
    }

    /// As [`Self::step`], of a state that others wait for: `with` lends it for what needs it, which
    /// is neither looking for the packet nor encoding the answer.
    pub fn step_with(
        &mut self,
        mut with: impl FnMut(&mut dyn FnMut(&mut State<'_>)),
        buffer: &mut [u8],
    ) -> Option<Step> {
        let Ok(packet) = self.parser.next_packet()? else {
            with(&mut |state| state.counters.link_broken = state.counters.link_broken.saturating_add(1));
            return Some(Step::Silence);
        };
        let is_for_all = packet.id == BROADCAST;
        if (packet.id != BOARD_ID && !is_for_all) || packet.instruction == Instruction::Status as u8 {
            return Some(Step::Silence);
        }
        let mut result = Err(Refusal::Limit);
        with(&mut |state| {
            state.counters.link_packets = state.counters.link_packets.saturating_add(1);
            result = execute(state, &packet, buffer.get_mut(DATA..).unwrap_or(&mut []));
        });
        if is_for_all && packet.instruction != Instruction::Ping as u8 {
            return Some(Step::Silence);
        }
        let length = status(result, buffer).or_else(|| status(Err(Refusal::Limit), buffer));
        Some(length.map_or(Step::Silence, Step::Answer))
    }
}

/// Does what the packet asks for; the answer's data are the first bytes of `data`, so many.
fn execute(state: &mut State<'_>, packet: &Packet<'_>, data: &mut [u8]) -> Result<usize, Refusal> {
    match Instruction::from_code(packet.instruction) {
        Some(Instruction::Ping) => {
            if !packet.parameters.is_empty() {
                return Err(Refusal::Length);
            }
            let [low, high] = BOARD_MODEL.to_le_bytes();
            let place = data.first_chunk_mut().ok_or(Refusal::Limit)?;
            *place = [low, high, FIRMWARE];
            Ok(place.len())
        }
        Some(Instruction::Read) => {
            let [a, b, c, d] = packet.parameters.try_into().map_err(|_| Refusal::Length)?;
            let (address, length) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
            if length == 0 {
                return Err(Refusal::Length);
            }
            if address.checked_add(length).is_none_or(|end| end > END) {
                return Err(Refusal::Range);
            }
            render(state, address, data.get_mut(..usize::from(length)).ok_or(Refusal::Limit)?);
            Ok(usize::from(length))
        }
        Some(Instruction::Write) => {
            let (address, data) = packet.parameters.split_first_chunk().ok_or(Refusal::Length)?;
            write(state, u16::from_le_bytes(*address), data).map(|()| 0)
        }
        _ => Err(Refusal::Instruction),
    }
}

/// Of an answer whose data stand in the buffer from [`DATA`] on, so many bytes.
fn status(result: Result<usize, Refusal>, buffer: &mut [u8]) -> Option<usize> {
    let (error, length) = match result {
        Ok(length) => (0, length),
        Err(refusal) => (refusal as u8, 0),
    };
    *buffer.get_mut(PARAMETERS)? = error;
    seal(BOARD_ID, Instruction::Status, 1 + length, buffer).ok().map(<[u8]>::len)
}

#[cfg(test)]
mod tests;
