//! What is asked, and what is answered.

use proptest::prelude::*;

use super::*;
use crate::control_table::{
    FIFO_ACKNOWLEDGE, FIFO_WINDOW, TABLE_VERSION, UPLOAD_COMMAND, UPLOAD_ITEM, UPLOAD_LENGTH, UPLOAD_STATE,
    UPLOAD_WINDOW,
};
use crate::dynamixel::packet::encode;
use crate::record::Record;

/// A host: sends one packet, and takes every answer apart.
struct Host {
    device: Device,
    state: State<'static>,
}

type Answer = Result<Vec<u8>, u8>;

impl Host {
    fn new() -> Self {
        Self { device: Device::new(), state: State::new(200, 25, Box::leak(Box::new([[0; _]; 20]))) }
    }

    fn receive(&mut self, mut bytes: &[u8]) -> Vec<Answer> {
        let mut answers = Vec::new();
        let mut buffer = [0; LONGEST_ANSWER];
        while !bytes.is_empty() {
            let taken = self.device.feed(bytes);
            bytes = &bytes[taken..];
            while let Some(length) = self.device.answer(&mut self.state, &mut buffer) {
                let mut parser = Parser::<LONGEST_ANSWER>::new();
                assert_eq!(parser.feed(&buffer[..length]), length);
                let packet = parser.next_packet().unwrap().unwrap();
                assert_eq!((packet.id, packet.instruction), (BOARD_ID, 0x55));
                let (error, data) = packet.parameters.split_first().unwrap();
                answers.push(if *error == 0 { Ok(data.to_vec()) } else { Err(*error) });
                assert!(*error == 0 || data.is_empty());
            }
        }
        answers
    }

    fn send(&mut self, id: u8, instruction: Instruction, parameters: &[u8]) -> Option<Answer> {
        let mut buffer = [0; 4000];
        let bytes = encode(id, instruction, &[parameters], &mut buffer).unwrap().to_vec();
        let mut answers = self.receive(&bytes);
        assert!(answers.len() <= 1);
        answers.pop()
    }

    fn read(&mut self, address: u16, length: u16) -> Answer {
        let parameters = [address.to_le_bytes(), length.to_le_bytes()].concat();
        self.send(BOARD_ID, Instruction::Read, &parameters).unwrap()
    }

    fn write(&mut self, address: u16, data: &[u8]) -> Answer {
        self.send(BOARD_ID, Instruction::Write, &[&address.to_le_bytes(), data].concat()).unwrap()
    }
}

const DONE: Answer = Ok(Vec::new());
const INSTRUCTION: u8 = 2;
const RANGE: u8 = 4;
const LENGTH: u8 = 5;
const LIMIT: u8 = 6;
const ACCESS: u8 = 7;

/// Model 5000h and the firmware's version, to our ID and to all.
#[test]
fn ping() {
    let mut host = Host::new();
    assert_eq!(host.send(200, Instruction::Ping, &[]), Some(Ok(vec![0x00, 0x50, 1])));
    assert_eq!(host.send(BROADCAST, Instruction::Ping, &[]), Some(Ok(vec![0x00, 0x50, 1])));
    assert_eq!(host.send(200, Instruction::Ping, &[0]), Some(Err(LENGTH)));
}

/// Byte by byte: a ping of ID 200 and its answer, their checksums by a bitwise division in Python.
#[test]
fn ping_as_bytes() {
    let (mut device, mut state, mut buffer) = (Device::new(), State::new(200, 25, &mut []), [0; 20]);
    assert_eq!(device.feed(b"\xFF\xFF\xFD\x00\xC8\x03\x00\x01\x3B\xFA"), 10);
    let length = device.answer(&mut state, &mut buffer).unwrap();
    assert_eq!(buffer[..length], *b"\xFF\xFF\xFD\x00\xC8\x07\x00\x55\x00\x00\x50\x01\x57\x37");
    assert_eq!(device.answer(&mut state, &mut buffer), None);
}

#[test]
fn others_packets_and_answers_are_not_answered() {
    let mut host = Host::new();
    for id in [0, 1, 199, 201, 0xFD] {
        assert_eq!(host.send(id, Instruction::Ping, &[]), None);
    }
    assert_eq!(host.state.counters.link_packets, 0);
    // Some ports echo what is sent.
    assert_eq!(host.send(200, Instruction::Status, &[0]), None);
    assert_eq!(host.send(BROADCAST, Instruction::Status, &[0]), None);
    assert_eq!(host.state.counters.link_packets, 0);
}

/// "No status is returned to a broadcast" but for pings. What it asks to be written is.
#[test]
fn broadcasts_are_carried_out_without_an_answer() {
    let mut host = Host::new();
    assert_eq!(host.send(BROADCAST, Instruction::Read, &[0, 0, 2, 0]), None);
    assert_eq!(host.send(BROADCAST, Instruction::SyncRead, &[0, 0, 2, 0, 200]), None);
    assert_eq!(host.send(BROADCAST, Instruction::Write, &[66, 3, 9, 0]), None);
    assert_eq!(host.read(UPLOAD_LENGTH.address, 2), Ok(vec![9, 0]));
}

#[test]
fn unknown_instructions_are_refused() {
    let mut host = Host::new();
    for instruction in [Instruction::Reboot, Instruction::SyncRead, Instruction::SyncWrite] {
        assert_eq!(host.send(200, instruction, &[0, 0, 2, 0]), Some(Err(INSTRUCTION)));
    }
    // Factory reset (06h) is none of the codec's.
    let bytes = b"\xFF\xFF\xFD\x00\xC8\x03\x00\x06\x2A\x7A";
    assert_eq!(host.receive(bytes), [Err(INSTRUCTION)]);
}

#[test]
fn reads() {
    let mut host = Host::new();
    assert_eq!(host.read(0, 2), Ok(vec![0x00, 0x50]));
    assert_eq!(host.read(TABLE_VERSION.address, 4), Ok(vec![5, 0, 200, 0]));
    // In the middle of a register, across a gap, unmapped.
    assert_eq!(host.read(1, 1), Ok(vec![0x50]));
    assert_eq!(host.read(6, 6), Ok(vec![1, 200, 0, 0, 0, 0]));
    assert_eq!(host.read(300, 3), Ok(vec![0, 0, 0]));
    assert_eq!(host.read(0, END).map(|bytes| bytes.len()), Ok(END.into()));
    assert_eq!(host.read(END - 1, 1).map(|bytes| bytes.len()), Ok(1));

    assert_eq!(host.read(END - 1, 2), Err(RANGE));
    assert_eq!(host.read(END, 1), Err(RANGE));
    assert_eq!(host.read(0xFFFF, 0xFFFF), Err(RANGE));
    assert_eq!(host.read(0, 0), Err(LENGTH));
    assert_eq!(host.send(200, Instruction::Read, &[0, 0, 2]), Some(Err(LENGTH)));
    assert_eq!(host.send(200, Instruction::Read, &[0, 0, 2, 0, 0]), Some(Err(LENGTH)));
}

/// What ROS 2's turtlebot3_node does, with the values that it writes: it reads 10..182 in one go,
/// and finds what it wrote there.
#[test]
fn the_node_is_read_to_and_obeyed() {
    let mut host = Host::new();
    assert_eq!(host.read(0, 2), Ok(vec![0x00, 0x50]));
    assert_eq!(host.write(59, &[1]), Ok(Vec::new()));
    assert_eq!(host.read(10, 172).map(|bytes| bytes.len()), Ok(172));
    let command: Vec<u8> = [10_i32, 0, 0, 0, 0, -50].iter().flat_map(|value| value.to_le_bytes()).collect();
    // Before the heartbeat has changed, commands are not taken.
    assert_eq!(host.write(150, &command), Ok(Vec::new()));
    assert_eq!(host.read(150, 24), Ok(vec![0; 24]));
    for beat in [0, 1] {
        assert_eq!(host.write(19, &[beat]), Ok(Vec::new()));
    }
    assert_eq!(host.write(150, &command), Ok(Vec::new()));
    assert_eq!(host.read(150, 24), Ok(command));
    let profile: Vec<u8> = [20_i32, 30].iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!(host.write(174, &profile), Ok(Vec::new()));
    assert_eq!(host.read(174, 8), Ok(profile));
    assert_eq!(host.write(149, &[0]), Ok(Vec::new()));
    let [status, beat, torque] = [18, 19, 149].map(|address| host.read(address, 1).unwrap()[0]);
    assert_eq!((status, beat, torque), (0xFF, 1, 0));
    // Nobody is told that something is done where several registers are missing, or one behind a
    // gap.
    assert_eq!(host.write(300, &[1, 2, 3]), Err(ACCESS));
    assert_eq!(host.write(130, &[1, 2]), Err(ACCESS));
}

/// The worst there is to stuff: the longest answer still fits its buffer.
#[test]
fn the_longest_answer_fits() {
    let worst: Vec<u8> = [0xFF, 0xFF, 0xFD].into_iter().cycle().take(usize::from(END) + 1).collect();
    let mut buffer = [0; LONGEST_ANSWER];
    assert!(encode(BOARD_ID, Instruction::Status, &[&worst], &mut buffer).is_ok());
}

#[test]
fn an_answer_that_does_not_fit_becomes_a_refusal() {
    let (mut device, mut state) = (Device::new(), State::new(200, 25, &mut []));
    let mut request = [0; 20];
    let request = encode(200, Instruction::Read, &[&[0, 0, 200, 0]], &mut request).unwrap();
    let mut buffer = [0; 64];
    device.feed(request);
    let length = device.answer(&mut state, &mut buffer).unwrap();
    assert_eq!((length, buffer[8]), (11, LIMIT));
}

#[test]
fn writes() {
    let mut host = Host::new();
    let all = [&[1_u8, 0][..], &300_u16.to_le_bytes()].concat();
    assert_eq!(host.write(UPLOAD_ITEM.address, &all), DONE);
    assert_eq!(host.read(UPLOAD_ITEM.address, 4), Ok(vec![1, 0, 44, 1]));
    // Any part of an array of bytes.
    assert_eq!(host.write(UPLOAD_WINDOW.address + 5, &[7, 8]), DONE);
    assert_eq!(host.read(UPLOAD_WINDOW.address + 4, 4), Ok(vec![0, 7, 8, 0]));
    assert_eq!(host.write(UPLOAD_WINDOW.address + 254, &[5, 6]), DONE);
    assert_eq!(host.read(UPLOAD_WINDOW.address + 253, 4), Ok(vec![0, 5, 6, 0]));
    assert_eq!(host.write(UPLOAD_WINDOW.address, &[9; 256]), DONE);
    assert_eq!(host.read(UPLOAD_WINDOW.address, 256), Ok(vec![9; 256]));
}

/// Nothing of a refused write is done.
#[test]
fn writes_are_done_whole_or_not_at_all() {
    let mut host = Host::new();
    // A register that only the board changes: alone, behind one that may be written, and before
    // one.
    assert_eq!(host.write(0, &[1, 2]), Err(ACCESS));
    assert_eq!(host.write(UPLOAD_ITEM.address, &[3, 0, 9, 0, 2]), Err(ACCESS));
    assert_eq!(host.write(UPLOAD_STATE.address, &[0, 0, 0, 0, 9]), Err(ACCESS));
    // Parts of numbers.
    assert_eq!(host.write(UPLOAD_ITEM.address, &[3, 0, 9]), Err(LENGTH));
    assert_eq!(host.write(UPLOAD_LENGTH.address + 1, &[9]), Err(LENGTH));
    assert_eq!(host.write(FIFO_ACKNOWLEDGE.address, &[0, 0, 0]), Err(LENGTH));
    // An unknown command, records yet to come, beyond the table.
    assert_eq!(host.write(UPLOAD_ITEM.address, &[3, 3, 9, 0]), Err(RANGE));
    assert_eq!(host.write(FIFO_ACKNOWLEDGE.address, &[1, 0, 0, 0]), Err(RANGE));
    assert_eq!(host.write(END, &[0]), Err(RANGE));
    assert_eq!(host.write(0xFFFF, &[0, 0]), Err(RANGE));
    // No data, no address.
    assert_eq!(host.write(UPLOAD_ITEM.address, &[]), Err(LENGTH));
    assert_eq!(host.send(200, Instruction::Write, &[64]), Some(Err(LENGTH)));

    let fresh = Host::new();
    let counters = host.state.counters;
    assert_eq!(counters.link_packets, 12);
    host.state.counters = fresh.state.counters;
    assert_eq!(host.state, fresh.state);
    assert_eq!(host.read(UPLOAD_COMMAND.address, 1), Ok(vec![0]));
}

/// Writes of up to 65,535 bytes and addresses beyond all: refused or done, never a panic.
#[test]
fn extreme_writes() {
    let mut state = State::new(200, 25, &mut []);
    assert_eq!(write(&mut state, 0xFFFF, &vec![0; 70_000]), Err(Refusal::Range));
    assert_eq!(write(&mut state, 0, &vec![0; END.into()]), Err(Refusal::Access));
}

/// The procedure of docs/link.md: acknowledge, read count and records in one packet.
#[test]
fn records_are_read_and_acknowledged() {
    let mut host = Host::new();
    (0..18).for_each(|time_us| _ = host.state.fifo.push(Record { time_us, ..Record::default() }));
    let mut received = Vec::new();
    for _ in 0..3 {
        let count = usize::from(host.read(1364, 2).unwrap()[0]);
        let bytes = host.read(FIFO_WINDOW.address, 60 * count as u16);
        for record in bytes.unwrap_or_default().as_chunks::<60>().0 {
            received.push(Record::decode(record).unwrap());
        }
        let next = received.last().map_or(0, |record| record.sequence + 1);
        assert_eq!(host.write(FIFO_ACKNOWLEDGE.address, &next.to_le_bytes()), DONE);
    }
    let times: Vec<u64> = received.iter().map(|record| record.time_us).collect();
    assert_eq!(times, (0..18).collect::<Vec<_>>());
}

#[test]
fn packets_and_broken_ones_are_counted() {
    let mut host = Host::new();
    host.send(200, Instruction::Ping, &[]);
    assert_eq!(host.receive(b"\xFF\xFF\xFD\x00\xC8\x03\x00\x01\x3B\xFB"), []);
    assert_eq!(host.receive(b"noise"), []);
    host.send(200, Instruction::Ping, &[]);
    assert_eq!((host.state.counters.link_packets, host.state.counters.link_broken), (2, 1));
}

proptest! {
    /// Whatever comes, and in whatever pieces: no panic, and the next good packet is answered.
    #[test]
    fn a_ping_after_anything(
        pieces in proptest::collection::vec(proptest::collection::vec(
            prop_oneof![Just(0xFF_u8), Just(0xFD), Just(0), Just(200), Just(3), any::<u8>()], 0..100), 0..20),
    ) {
        let mut host = Host::new();
        for piece in pieces {
            host.receive(&piece);
        }
        prop_assert_eq!(host.send(200, Instruction::Ping, &[]), Some(Ok(vec![0x00, 0x50, 1])));
    }

    /// Any instruction with any parameters gets exactly one answer.
    #[test]
    fn every_instruction_is_answered_once(
        code in prop::sample::select(vec![1_u8, 2, 3, 8, 0x82, 0x83, 0x8A]),
        address in prop_oneof![0..2400_u16, any::<u16>()],
        data in proptest::collection::vec(any::<u8>(), 0..300),
    ) {
        let mut host = Host::new();
        let instruction = Instruction::from_code(code).unwrap();
        let parameters = [&address.to_le_bytes()[..], &data].concat();
        prop_assert!(host.send(200, instruction, &parameters).is_some());
    }
}
