//! The servo bus and the wheels on it, against a port that answers by script. Packets: ROBOTIS
//! e-manual, Protocol 2.0.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::cell::Cell;
use core::f64::consts::TAU;
use core::future::pending;

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};
use firmware::dynamixel::bus::{Answer, Bus, BusError, Timing};
use firmware::dynamixel::packet::{Instruction, Parser, encode};
use firmware::dynamixel::status::{ALERT, Refusal};
use firmware::wheels::{WheelHealth, Wheels};
use on_target_tests::{Failed, Outcome, close, ensure, now, tests};

tests!(
    sync_read_of_the_e_manual,
    any_flipped_bit_is_refused,
    silence_ends_in_bounded_time,
    a_silent_servo_costs_its_own_part,
    refusals_and_alerts,
    wheels_turn,
);

const SYNC_READ: &[u8] =
    &[0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA];
const FIRST: &[u8] =
    &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xA6, 0x00, 0x00, 0x00, 0x8C, 0xC0];
const SECOND: &[u8] =
    &[0xFF, 0xFF, 0xFD, 0x00, 0x02, 0x08, 0x00, 0x55, 0x00, 0x1F, 0x08, 0x00, 0x00, 0xBA, 0xBE];
const POSITION: u16 = 132;
const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 500, margin_us: 500 };

/// A time limit that is over when nobody has more to do; adds up what was waited in vain, µs.
struct Patience(Cell<u32>);

impl DelayNs for &Patience {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + ns / 1000);
    }
}

/// A servo bus by a function from what was sent to what comes back.
struct Port<F> {
    sent: [u8; 64],
    sent_length: usize,
    coming: [u8; 128],
    coming_length: usize,
    answer: F,
}

/// Gathers the bytes of an answer.
struct Coming<'a> {
    bytes: &'a mut [u8; 128],
    length: usize,
}

impl Coming<'_> {
    fn put(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = *byte;
                self.length += 1;
            }
        }
    }

    fn status(&mut self, id: u8, error: u8, data: &[u8]) {
        let mut buffer = [0; 64];
        if let Ok(packet) = encode(id, Instruction::Status, &[&[error], data], &mut buffer) {
            self.put(packet);
        }
    }
}

impl<F: FnMut(&[u8], &mut Coming<'_>)> Port<F> {
    fn new(answer: F) -> Self {
        Self { sent: [0; 64], sent_length: 0, coming: [0; 128], coming_length: 0, answer }
    }
}

impl<F> ErrorType for Port<F> {
    type Error = ErrorKind;
}

impl<F: FnMut(&[u8], &mut Coming<'_>)> Write for Port<F> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let end = self.sent_length + bytes.len();
        self.sent.get_mut(self.sent_length..end).ok_or(ErrorKind::OutOfMemory)?.copy_from_slice(bytes);
        self.sent_length = end;
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), ErrorKind> {
        let mut coming = Coming { bytes: &mut self.coming, length: self.coming_length };
        (self.answer)(self.sent.get(..self.sent_length).ok_or(ErrorKind::Other)?, &mut coming);
        self.coming_length = coming.length;
        self.sent_length = 0;
        Ok(())
    }
}

impl<F: FnMut(&[u8], &mut Coming<'_>)> Read for Port<F> {
    async fn read(&mut self, space: &mut [u8]) -> Result<usize, ErrorKind> {
        // Seven bytes at a time: packets come in pieces.
        let count = self.coming_length.min(space.len()).min(7);
        if count == 0 {
            return pending().await;
        }
        for (place, byte) in space.iter_mut().zip(self.coming.iter().take(count)) {
            *place = *byte;
        }
        self.coming.copy_within(count.., 0);
        self.coming_length -= count;
        Ok(count)
    }
}

type Answers = [Option<Result<Answer<4>, BusError>>; 2];

/// Both positions, and the time waited in vain, µs.
fn positions(answer: impl FnMut(&[u8], &mut Coming<'_>)) -> Result<(Answers, u32), Failed> {
    let patience = Patience(Cell::new(0));
    let mut bus = Bus::new(Port::new(answer), &patience, TIMING);
    let answers = now(bus.sync_read(POSITION, [Some(1), Some(2)]))?;
    Ok((answers, patience.0.get()))
}

fn position(value: u32) -> Option<Result<Answer<4>, BusError>> {
    Some(Ok(Answer { data: value.to_le_bytes(), alert: false }))
}

fn expect(found: &Answers, expected: &Answers) -> Outcome {
    ensure(found == expected, format_args!("{found:?}, expected {expected:?}"))
}

fn sync_read_of_the_e_manual() -> Outcome {
    let mut is_as_printed = false;
    let (answers, waited) = positions(|sent, coming| {
        is_as_printed = sent == SYNC_READ;
        coming.put(FIRST);
        coming.put(SECOND);
    })?;
    ensure(
        is_as_printed && waited == 0,
        format_args!("sent as printed: {is_as_printed}, waited {waited} µs"),
    )?;
    expect(&answers, &[position(166), position(2079)])
}

fn any_flipped_bit_is_refused() -> Outcome {
    for bit in 0..8 * FIRST.len() {
        let (answers, _) = positions(|sent, coming| {
            for (at, byte) in FIRST.iter().enumerate() {
                coming.put(&[byte ^ if at == bit / 8 { 1 << (bit % 8) } else { 0 }]);
            }
            if sent == SYNC_READ {
                coming.put(SECOND);
            }
        })?;
        ensure(
            matches!(answers[0], Some(Err(BusError::Broken | BusError::Timeout))),
            format_args!("bit {bit}: {answers:?}"),
        )?;
    }
    Ok(())
}

/// 15 bytes and one of stuffing, return delay and margin, for each.
fn silence_ends_in_bounded_time() -> Outcome {
    let (answers, waited) = positions(|_, _| {})?;
    expect(&answers, &[Some(Err(BusError::Timeout)); 2])?;
    ensure(waited == 2 * 1_160, format_args!("waited {waited} µs"))
}

/// Servo 2 waits for servo 1, which is gone; asked alone it answers.
fn a_silent_servo_costs_its_own_part() -> Outcome {
    let (answers, _) = positions(|sent, coming| {
        if sent != SYNC_READ {
            coming.put(SECOND);
        }
    })?;
    expect(&answers, &[Some(Err(BusError::Timeout)), position(2079)])
}

fn refusals_and_alerts() -> Outcome {
    let (answers, _) = positions(|_, coming| {
        coming.status(1, Refusal::Range as u8, &[]);
        coming.status(2, ALERT, &[1, 0, 0, 0]);
    })?;
    let alerted = Answer { data: [1, 0, 0, 0], alert: true };
    expect(&answers, &[Some(Err(BusError::Refused(Refusal::Range))), Some(Ok(alerted))])
}

/// Two servos at 8 and −4 counts a sample, the left one with an overload (register 70, bit 5).
fn wheels_turn() -> Outcome {
    let turned = Cell::new(0_i32);
    let patience = Patience(Cell::new(0));
    let port = Port::new(|sent: &[u8], coming: &mut Coming<'_>| {
        let mut parser = Parser::<64>::default();
        parser.feed(sent);
        let Some(Ok(packet)) = parser.next_packet() else { return };
        let left = packet.id == 1;
        let error = if left { ALERT } else { 0 };
        match Instruction::from_code(packet.instruction) {
            Some(Instruction::Ping) => coming.status(packet.id, error, &[0x24, 0x04, 45]),
            Some(Instruction::Read) => coming.status(packet.id, error, &[0x20]),
            Some(Instruction::SyncRead) => {
                for id in packet.parameters.iter().skip(4) {
                    let (velocity, counts) = if *id == 1 { (102_i32, 8) } else { (-51, -4) };
                    let mut registers = [0; 21];
                    registers[2..6].copy_from_slice(&velocity.to_le_bytes());
                    registers[6..10].copy_from_slice(&(counts * turned.get()).to_le_bytes());
                    coming.status(*id, if *id == 1 { ALERT } else { 0 }, &registers);
                }
            }
            _ => {}
        }
    });
    let mut wheels = Wheels::new(port, &patience);
    let mut speeds = [None; 2];
    for sample in 0..100 {
        turned.set(sample);
        speeds = now(wheels.poll(5_000 * sample as u64))?.map(|reading| reading.map(|reading| reading.speed));
    }
    let [Some(left), Some(right)] = speeds else { return ensure(false, format_args!("{speeds:?}")) };
    // A count is 2π/4096. Four roundings at the most.
    let speed = |counts: f64| counts * TAU / 4096.0 / 0.005;
    close(format_args!("left"), left, speed(8.0), 1e-6)?;
    close(format_args!("right"), right, speed(-4.0), 1e-6)?;
    let [left, right] = wheels.statuses();
    ensure(
        (left.health, right.health) == (WheelHealth::Alert, WheelHealth::Ok) && left.hardware_error == 0x20,
        format_args!("{left:?}, {right:?}"),
    )
}
