//! Registers of a board over its link: instructions, answers, and a retry where one was lost.

use std::time::Duration;

use firmware::control_table::{self as table, BOARD_ID, BOARD_MODEL, Kind, Register};
use firmware::dynamixel::packet::{self, Instruction, OVERHEAD, Parser};
use firmware::dynamixel::status::{ALERT, Refusal};
use support::error::{Error, Result};
use support::printable;

use super::transport::Transport;

/// The longest packet: a status with the whole table. Every three bytes may need a fourth.
const LONGEST: usize = OVERHEAD + (1 + table::END as usize) * 4 / 3 + 4;

/// How long the first answer is waited for. A board answers within a sample period or two; what an
/// operating system adds is less than this.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(50);
/// Each further answer is waited for twice as long, up to this: the processor stands still while it
/// erases flash.
const LONGEST_TIMEOUT: Duration = Duration::from_millis(800);
/// A board that is silent for so long counts as gone. Erasing both sectors of its store takes less.
const PATIENCE: Duration = Duration::from_secs(5);
/// Broken answers come at once: after this number in a row the line counts as unusable.
const MOST_ATTEMPTS: u32 = 40;
/// After a lost answer it may still be under way: silence for so long says that it is not.
const QUIET: Duration = Duration::from_millis(30);
/// Bytes that are thrown away in wait of silence. A board sends only when asked.
const MOST_STALE: usize = 1 << 16;

/// What an instruction came back with.
enum Answer {
    Data(Vec<u8>),
    Refused(u8),
    /// Nothing came in time.
    Missing,
    /// Something came, with a wrong checksum or length.
    Broken,
}

impl Answer {
    /// What is wrong with an answer that is not the data asked for.
    fn error(&self) -> Error {
        Error::failed(match self {
            Self::Data(_) => "an answer that does not fit".to_owned(),
            Self::Refused(error) => refusal(*error),
            Self::Missing => format!(
                "no answer for {} s: is this the board's port, is the board on, does its firmware run?",
                PATIENCE.as_secs()
            ),
            Self::Broken => {
                "only broken answers: is this the board's port? if so, try another cable".to_owned()
            }
        })
    }
}

/// The host's side of the link.
pub struct Client<T> {
    transport: T,
    parser: Parser<LONGEST>,
    /// An answer to an earlier instruction may still come.
    is_late: bool,
    retries: u64,
}

/// What a board says of itself.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Board {
    /// The robot that it is set up for.
    pub robot: String,
    /// Version of its firmware.
    pub firmware_version: u8,
    /// Samples per second.
    pub sample_rate_hz: u16,
    /// Whether it estimates.
    pub has_coefficients: bool,
    /// Checksum of the coefficients in use; 0 without.
    pub coefficients_crc: u32,
}

/// Registers that were read together.
pub struct Block {
    first: u16,
    bytes: Vec<u8>,
}

/// Type of a register's value.
pub trait Value: Sized + Copy {
    /// As the table names it.
    const KIND: Kind;
    /// `None` unless there are as many bytes as it has.
    fn from_bytes(bytes: &[u8]) -> Option<Self>;
    /// As the link carries it.
    fn to_bytes(self) -> Vec<u8>;
}

macro_rules! values {
    ($($type:ty: $kind:ident),+) => {
        $(impl Value for $type {
            const KIND: Kind = Kind::$kind;
            fn from_bytes(bytes: &[u8]) -> Option<Self> {
                Some(Self::from_le_bytes(bytes.try_into().ok()?))
            }
            fn to_bytes(self) -> Vec<u8> {
                self.to_le_bytes().to_vec()
            }
        })+
    };
}

values!(u8: U8, u16: U16, u32: U32, u64: U64, i32: I32, f32: F32);

impl Block {
    /// The bytes of a register.
    ///
    /// # Errors
    /// It was not read.
    pub fn bytes(&self, register: &Register) -> Result<&[u8]> {
        let start = register.address.checked_sub(self.first).map(usize::from);
        start
            .and_then(|start| self.bytes.get(start..start + usize::from(register.size())))
            .ok_or_else(|| Error::failed(format!("the register {} was not read", register.name)))
    }

    /// The values of a register.
    ///
    /// # Errors
    /// It was not read, or has a different type.
    pub fn all<V: Value>(&self, register: &Register) -> Result<Vec<V>> {
        check_kind::<V>(register)?;
        let bytes = self.bytes(register)?;
        Ok(bytes.chunks_exact(usize::from(V::KIND.size())).filter_map(V::from_bytes).collect())
    }

    /// The first value of a register.
    ///
    /// # Errors
    /// As [`all`](Self::all).
    pub fn get<V: Value>(&self, register: &Register) -> Result<V> {
        let first = self.all(register)?.first().copied();
        first.ok_or_else(|| Error::failed(format!("the register {} is empty", register.name)))
    }
}

fn check_kind<V: Value>(register: &Register) -> Result<()> {
    if register.kind == V::KIND {
        return Ok(());
    }
    let (held, asked) = (register.kind.name(), V::KIND.name());
    Err(Error::failed(format!("the register {} holds {held}, not {asked}", register.name)))
}

impl<T: Transport> Client<T> {
    /// A client that has not asked yet who is there.
    pub fn new(transport: T) -> Self {
        Self { transport, parser: Parser::default(), is_late: true, retries: 0 }
    }

    /// Finds out whether this is a board whose registers are known here.
    ///
    /// # Errors
    /// Nothing answers, something else does, or the board's table has a different version.
    pub fn connect(transport: T) -> Result<(Self, Board)> {
        let mut client = Self::new(transport);
        let board = client.identify()?;
        Ok((client, board))
    }

    fn identify(&mut self) -> Result<Board> {
        let (model, firmware_version) = self.ping()?;
        if model != BOARD_MODEL {
            return Err(Error::failed(format!(
                "device {BOARD_ID} is of model {model:#06x}; expected {BOARD_MODEL:#06x}, an OpenCR"
            )));
        }
        // The stock firmware answers with zeros or refuses, as its library's version has it.
        let version = match self.attempt(&read(table::TABLE_VERSION.range()), 2)? {
            Answer::Data(bytes) => u16::from_bytes(&bytes).unwrap_or(0),
            Answer::Refused(error) if Refusal::from_error(error) != Some(Refusal::Checksum) => 0,
            silence => return Err(silence.error()),
        };
        if version == 0 {
            return Err(Error::failed(
                "the board runs the stock firmware, or another that does not measure power; expected this project's: \
                 see README.md for how to flash it",
            ));
        }
        if version != table::VERSION {
            return Err(Error::failed(format!(
                "the board's table of registers is version {version}; expected {}: take gmr and firmware of one release",
                table::VERSION
            )));
        }
        let block = self.block(&table::TABLE_VERSION, &table::ROBOT_NAME)?;
        Ok(Board {
            robot: text(block.bytes(&table::ROBOT_NAME)?),
            firmware_version,
            sample_rate_hz: block.get(&table::SAMPLE_RATE)?,
            has_coefficients: block.get::<u8>(&table::COEFFICIENTS_STATE)? == 0,
            coefficients_crc: block.get(&table::COEFFICIENTS_CRC)?,
        })
    }

    /// Model number and firmware version of the answering device.
    ///
    /// # Errors
    /// Nobody does.
    pub fn ping(&mut self) -> Result<(u16, u8)> {
        match self.exchange(&Request { instruction: Instruction::Ping, parameters: Vec::new() }, 3)?[..] {
            [low, high, version] => Ok((u16::from_le_bytes([low, high]), version)),
            _ => Err(Error::failed("an answer of the wrong length")),
        }
    }

    /// Reads a register's first value.
    ///
    /// # Errors
    /// The board does not answer or refuses; `V` is not the register's type.
    pub fn get<V: Value>(&mut self, register: &Register) -> Result<V> {
        self.block(register, register)?.get(register)
    }

    /// Reads all registers between two, both included, at one instant.
    ///
    /// # Errors
    /// The board does not answer or refuses.
    pub fn block(&mut self, first: &Register, last: &Register) -> Result<Block> {
        let range = first.address..last.end();
        let length = usize::from(range.end.saturating_sub(range.start));
        let bytes = self
            .exchange(&read(range), length)
            .map_err(|error| Error::failed(format!("reading {}: {error}", first.name)))?;
        Ok(Block { first: first.address, bytes })
    }

    /// Writes a register's first value.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub fn set<V: Value>(&mut self, register: &Register, value: V) -> Result<()> {
        check_kind::<V>(register)?;
        self.set_bytes(register, &value.to_bytes())
    }

    /// Writes a register from its beginning.
    ///
    /// # Errors
    /// The board does not answer or refuses; the register has fewer bytes.
    pub fn set_bytes(&mut self, register: &Register, bytes: &[u8]) -> Result<()> {
        if bytes.len() > usize::from(register.size()) {
            let (length, room) = (bytes.len(), register.size());
            return Err(Error::failed(format!("{length} bytes for {}; it holds {room}", register.name)));
        }
        let mut parameters = register.address.to_le_bytes().to_vec();
        parameters.extend_from_slice(bytes);
        self.exchange(&Request { instruction: Instruction::Write, parameters }, 0)
            .map_err(|error| Error::failed(format!("writing {}: {error}", register.name)))?;
        Ok(())
    }

    /// Lets time pass. What comes meanwhile answers nothing any more.
    ///
    /// # Errors
    /// The other side is gone.
    pub fn wait(&mut self, time: Duration) -> Result<()> {
        let mut unused = [0; 256];
        let end = self.transport.now() + time;
        loop {
            let now = self.transport.now();
            let remaining = end.saturating_sub(now);
            if remaining.is_zero()
                || self.transport.receive(&mut unused, remaining)? == 0 && self.transport.now() <= now
            {
                return Ok(());
            }
        }
    }

    /// Time as the board counts it.
    pub fn now(&self) -> Duration {
        self.transport.now()
    }

    /// Instructions sent again since the beginning, because an answer was lost or broken.
    pub fn retries(&self) -> u64 {
        self.retries
    }

    /// The link itself.
    pub fn transport(&mut self) -> &mut T {
        &mut self.transport
    }

    /// Gives the link back.
    pub fn into_transport(self) -> T {
        self.transport
    }

    /// Data of the answer. Only for instructions that may be carried out twice, as reading and
    /// writing registers.
    fn exchange(&mut self, request: &Request, expected: usize) -> Result<Vec<u8>> {
        match self.attempt(request, expected)? {
            Answer::Data(data) => Ok(data),
            other => Err(other.error()),
        }
    }

    /// Sends until there is an answer or no hope of one. The right answer has `expected` bytes.
    fn attempt(&mut self, request: &Request, expected: usize) -> Result<Answer> {
        let mut buffer = [0; LONGEST];
        let parameters: &[&[u8]] = &[&request.parameters];
        let packet = packet::encode(BOARD_ID, request.instruction, parameters, &mut buffer)
            .map_err(|_| Error::failed("a packet that is too long"))?;
        let begun = self.transport.now();
        let (mut attempts, mut timeout) = (1, ANSWER_TIMEOUT);
        loop {
            self.discard_stale()?;
            self.transport.send(packet)?;
            let answer = self.answer(expected, timeout)?;
            let is_answer = match answer {
                Answer::Data(_) => true,
                Answer::Refused(error) => Refusal::from_error(error) != Some(Refusal::Checksum),
                Answer::Missing | Answer::Broken => false,
            };
            let is_over = self.transport.now().saturating_sub(begun) >= PATIENCE || attempts >= MOST_ATTEMPTS;
            self.is_late = !is_answer;
            if is_answer || is_over {
                return Ok(answer);
            }
            attempts += 1;
            timeout = (2 * timeout).min(LONGEST_TIMEOUT);
            self.retries += 1;
        }
    }

    /// The answer to what was just sent.
    fn answer(&mut self, expected: usize, timeout: Duration) -> Result<Answer> {
        let deadline = self.transport.now() + timeout;
        loop {
            while let Some(packet) = self.parser.next_packet() {
                let Ok(packet) = packet else { return Ok(Answer::Broken) };
                if packet.id != BOARD_ID || packet.instruction != Instruction::Status as u8 {
                    continue;
                }
                match packet.parameters {
                    [error, data @ ..] if error & !ALERT == 0 => {
                        // With a different length it answers an earlier request.
                        if data.len() == expected {
                            return Ok(Answer::Data(data.to_vec()));
                        }
                    }
                    [error, ..] => return Ok(Answer::Refused(*error)),
                    [] => return Ok(Answer::Broken),
                }
            }
            let now = self.transport.now();
            let remaining = deadline.saturating_sub(now);
            let count = self.transport.receive(self.parser.space(), remaining)?;
            self.parser.received(count);
            if count == 0 && (remaining.is_zero() || self.transport.now() <= now) {
                return Ok(Answer::Missing);
            }
        }
    }

    /// Throws away what came before anything was asked.
    fn discard_stale(&mut self) -> Result<()> {
        let limit = if self.is_late { QUIET } else { Duration::ZERO };
        let mut unused = [0; 1024];
        let mut discarded = 0;
        self.parser.clear();
        loop {
            match self.transport.receive(&mut unused, limit)? {
                0 => return Ok(()),
                count => discarded += count,
            }
            if discarded > MOST_STALE {
                return Err(Error::failed(
                    "the port sends without end; expected a board, which answers only",
                ));
            }
        }
    }
}

/// An instruction and its parameters.
struct Request {
    instruction: Instruction,
    parameters: Vec<u8>,
}

fn read(range: std::ops::Range<u16>) -> Request {
    let length = range.end.saturating_sub(range.start);
    let parameters = [range.start.to_le_bytes(), length.to_le_bytes()].concat();
    Request { instruction: Instruction::Read, parameters }
}

/// A status' error in words.
fn refusal(error: u8) -> String {
    let why = match Refusal::from_error(error) {
        Some(Refusal::Result) => "it failed",
        Some(Refusal::Instruction) => "there is no such instruction",
        Some(Refusal::Checksum) => "the instruction arrives broken each time",
        Some(Refusal::Range) => "a value or address is outside its range",
        Some(Refusal::Length) => "fewer or more bytes than the registers have",
        Some(Refusal::Limit) => "a value is beyond its limit",
        Some(Refusal::Access) => "it cannot be written, or not now",
        None => return format!("the board refuses, with the unknown error {error:#04x}"),
    };
    format!("the board refuses: {why}")
}

/// Text that is padded with zeros, made printable: the other end of the link wrote it.
pub(super) fn text(bytes: &[u8]) -> String {
    let length = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    printable::name(&String::from_utf8_lossy(&bytes[..length]))
}
