//! Servo buses for tests: one that follows a script, and one with servos on it. Nothing waits: when
//! a port has no more to say, the time for saying it is over.

use core::cell::{Cell, RefCell};
use core::future::pending;
use std::collections::VecDeque;

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};

use super::packet::{Instruction, Parser, encode};
use super::status::{ALERT, Refusal};
use super::xl430::{GOAL_VELOCITY, HARDWARE_ERROR, MODEL, PRESENT, PRESENT_BYTES, TORQUE, TRIPPED, WATCHDOG};

/// A time limit that is over as soon as nobody has anything more to do. Adds up what was waited in
/// vain, µs.
#[derive(Default)]
pub(crate) struct Patience(pub(crate) Cell<u64>);

impl DelayNs for &Patience {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + u64::from(ns) / 1000);
    }
}

/// What is expected to be sent, and the chunks in which the answer comes.
pub(crate) type Step<'a> = (&'a [u8], &'a [&'a [u8]]);

/// Plays a script.
pub(crate) struct Script<'a> {
    steps: VecDeque<Step<'a>>,
    sent: Vec<u8>,
    coming: VecDeque<Result<Vec<u8>, ErrorKind>>,
}

impl<'a> Script<'a> {
    pub(crate) fn new(steps: &[Step<'a>]) -> Self {
        Self { steps: steps.iter().copied().collect(), sent: Vec::new(), coming: VecDeque::new() }
    }

    /// Bytes that nobody asked for.
    pub(crate) fn unasked(mut self, bytes: &[u8]) -> Self {
        self.coming.push_back(Ok(bytes.to_vec()));
        self
    }

    /// The next read fails.
    pub(crate) fn failing(mut self) -> Self {
        self.coming.push_back(Err(ErrorKind::Other));
        self
    }

    pub(crate) fn done(self) {
        assert!(self.steps.is_empty(), "not sent: {:02X?}", self.steps);
    }
}

impl ErrorType for Script<'_> {
    type Error = ErrorKind;
}

impl Write for Script<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        // Not all at once, as a port with a small buffer.
        let count = bytes.len().min(5);
        self.sent.extend(&bytes[..count]);
        Ok(count)
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        let (expected, answer) = self.steps.pop_front().expect("the script is over");
        assert_eq!(self.sent, expected, "sent {:02X?}, expected {expected:02X?}", self.sent);
        self.sent.clear();
        self.coming.extend(answer.iter().map(|chunk| Ok(chunk.to_vec())));
        Ok(())
    }
}

impl Read for Script<'_> {
    async fn read(&mut self, space: &mut [u8]) -> Result<usize, ErrorKind> {
        let Some(chunk) = self.coming.pop_front() else { return pending().await };
        let mut chunk = chunk?;
        let count = chunk.len().min(space.len());
        space[..count].copy_from_slice(&chunk[..count]);
        if count < chunk.len() {
            self.coming.push_front(Ok(chunk.split_off(count)));
        }
        Ok(count)
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Servo {
    pub(crate) is_present: bool,
    pub(crate) model: u16,
    pub(crate) velocity: i32,
    pub(crate) position: i32,
    pub(crate) hardware_error: u8,
    /// So many answers come with a flipped bit.
    pub(crate) broken: u32,
    /// So many writes are not heard.
    pub(crate) deaf: u32,
    /// What can be written, and what is set up at the factory.
    pub(crate) table: [u8; 147],
}

impl Servo {
    /// With its drive mode.
    fn new(drive_mode: u8) -> Self {
        let mut table = [0; 147];
        (table[9], table[10], table[11], table[68]) = (250, drive_mode, 1, 2);
        table[44..48].copy_from_slice(&265_i32.to_le_bytes());
        Self {
            is_present: true,
            model: MODEL,
            velocity: 0,
            position: 0,
            hardware_error: 0,
            broken: 0,
            deaf: 0,
            table,
        }
    }

    pub(crate) fn goal(&self) -> i32 {
        let at = usize::from(GOAL_VELOCITY);
        i32::from_le_bytes(self.table[at..at + 4].try_into().unwrap())
    }

    pub(crate) fn has_torque(&self) -> bool {
        self.table[usize::from(TORQUE)] != 0
    }

    fn write(&mut self, address: u16, data: &[u8]) -> Result<Vec<u8>, Refusal> {
        if self.deaf > 0 {
            self.deaf -= 1;
            return Ok(Vec::new());
        }
        if address == GOAL_VELOCITY && self.table[usize::from(WATCHDOG)] == TRIPPED {
            return Err(Refusal::Access);
        }
        let at = usize::from(address);
        self.table[at..at + data.len()].copy_from_slice(data);
        if self.hardware_error != 0 {
            self.table[usize::from(TORQUE)] = 0;
        }
        Ok(Vec::new())
    }

    /// Volatile registers as after power-on.
    pub(crate) fn restart(&mut self) {
        let level = self.table[68];
        self.table[64..].fill(0);
        self.table[68] = level;
        self.hardware_error = 0;
        self.position = self.position.rem_euclid(4096);
    }
}

/// Servos 1 and 2 on a bus.
pub(crate) struct Servos {
    pub(crate) servos: RefCell<[Servo; 2]>,
    sent: RefCell<Vec<u8>>,
    coming: RefCell<VecDeque<u8>>,
    /// Codes of the instructions they got.
    pub(crate) instructions: RefCell<Vec<u8>>,
    pub(crate) patience: Patience,
}

impl Servos {
    pub(crate) fn new() -> Self {
        Self {
            servos: RefCell::new([Servo::new(0), Servo::new(1)]),
            sent: RefCell::default(),
            coming: RefCell::default(),
            instructions: RefCell::default(),
            patience: Patience::default(),
        }
    }

    /// Turns them by these angles, in position codes, and leaves them at these speeds, in velocity
    /// codes.
    pub(crate) fn advance(&self, velocities: [i32; 2], angles: [i32; 2]) {
        for ((servo, velocity), angle) in self.servos.borrow_mut().iter_mut().zip(velocities).zip(angles) {
            servo.velocity = velocity;
            servo.position = servo.position.wrapping_add(angle);
        }
    }

    fn registers(servo: &Servo, address: u16, count: u16) -> Vec<u8> {
        let mut table = [0; 256];
        table[..servo.table.len()].copy_from_slice(&servo.table);
        table[usize::from(HARDWARE_ERROR)] = servo.hardware_error;
        let present = usize::from(PRESENT);
        table[present + 2..present + 6].copy_from_slice(&servo.velocity.to_le_bytes());
        table[present + 6..present + 10].copy_from_slice(&servo.position.to_le_bytes());
        table[present + PRESENT_BYTES - 3] = 120;
        table[usize::from(address)..usize::from(address + count)].to_vec()
    }

    /// Whether the servo answered.
    fn answer(&self, id: u8, data: impl FnOnce(&mut Servo) -> Result<Vec<u8>, Refusal>) -> bool {
        let mut servos = self.servos.borrow_mut();
        let Some(servo) = servos.get_mut(usize::from(id) - 1).filter(|servo| servo.is_present) else {
            return false;
        };
        let (mut error, data) = match data(servo) {
            Ok(data) => (0, data),
            Err(refusal) => (refusal as u8, Vec::new()),
        };
        error |= if servo.hardware_error == 0 { 0 } else { ALERT };
        let mut buffer = [0; 64];
        let mut packet = encode(id, Instruction::Status, &[&[error], &data], &mut buffer).unwrap().to_vec();
        if servo.broken > 0 {
            servo.broken -= 1;
            packet[9] ^= 1;
        }
        self.coming.borrow_mut().extend(packet);
        true
    }

    fn obey(&self, id: u8, instruction: u8, parameters: &[u8]) {
        self.instructions.borrow_mut().push(instruction);
        let word = |at: usize| u16::from_le_bytes([parameters[at], parameters[at + 1]]);
        match Instruction::from_code(instruction) {
            Some(Instruction::Ping) => {
                self.answer(id, |servo| Ok([&servo.model.to_le_bytes()[..], &[45]].concat()));
            }
            Some(Instruction::Read) => {
                self.answer(id, |servo| Ok(Self::registers(servo, word(0), word(2))));
            }
            // Each waits for the one before it.
            Some(Instruction::SyncRead) => {
                let _ = parameters[4..]
                    .iter()
                    .all(|id| self.answer(*id, |servo| Ok(Self::registers(servo, word(0), word(2)))));
            }
            Some(Instruction::Write) => {
                self.answer(id, |servo| servo.write(word(0), &parameters[2..]));
            }
            Some(Instruction::SyncWrite) => {
                for item in parameters[4..].chunks(1 + usize::from(word(2))) {
                    let mut servos = self.servos.borrow_mut();
                    if let Some(servo) =
                        servos.get_mut(usize::from(item[0]) - 1).filter(|servo| servo.is_present)
                    {
                        let _ = servo.write(word(0), &item[1..]);
                    }
                }
            }
            Some(Instruction::Reboot) => {
                self.answer(id, |servo| {
                    servo.restart();
                    Ok(Vec::new())
                });
            }
            _ => {
                self.answer(id, |_| Err(Refusal::Instruction));
            }
        }
    }
}

impl ErrorType for &Servos {
    type Error = ErrorKind;
}

impl Write for &Servos {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        self.sent.borrow_mut().extend(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        let mut parser = Parser::<64>::default();
        parser.feed(&self.sent.take());
        while let Some(packet) = parser.next_packet() {
            let packet = packet.expect("the bus sends whole packets");
            self.obey(packet.id, packet.instruction, packet.parameters);
        }
        Ok(())
    }
}

impl Read for &Servos {
    async fn read(&mut self, space: &mut [u8]) -> Result<usize, ErrorKind> {
        if self.coming.borrow().is_empty() {
            return pending().await;
        }
        let mut coming = self.coming.borrow_mut();
        let count = coming.len().min(space.len());
        for (place, byte) in space.iter_mut().zip(coming.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }
}
