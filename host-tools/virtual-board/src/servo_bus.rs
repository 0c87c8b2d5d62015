//! The bus of the wheel servos: packets in, answers and the time they take out.
//!
//! The codec is the firmware's own, on purpose: its tests hold it against the vectors of the
//! e-manual. What is checked here is what the servos make of the packets.

use crc::{CRC_16_UMTS, Crc};
use firmware::dynamixel::packet::{BROADCAST, Instruction, OVERHEAD, Packet, Parser, encode};
use firmware::dynamixel::status::Refusal;
use plant::rails::SERVOS;

use super::lockstep::WheelState;
use super::servo::{FIRMWARE, MODEL, VirtualServo};

/// Time of a byte at 1 Mbit/s, ten bits, µs.
pub const BYTE_US: u32 = 10;
/// A servo forgets a packet that does not go on, µs. The e-manual does not say after how long.
const FORGETS_US: u64 = 1000;
/// Longest packet that a servo takes.
const LONGEST: usize = 512;

/// What comes back on the bus.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ServoAnswer {
    /// From the first byte of the request to the first of the answer, µs.
    pub delay_us: u32,
    /// Empty without an answer. Silences between the answers of several servos are left out.
    pub bytes: Vec<u8>,
}

/// Both servos and their wire.
#[derive(Debug, Clone)]
pub struct ServoBus {
    /// Left, right.
    pub servos: [VirtualServo; SERVOS],
    parser: Parser<LONGEST>,
    last_us: u64,
}

impl Default for ServoBus {
    fn default() -> Self {
        Self {
            servos: [VirtualServo::new(true), VirtualServo::new(false)],
            parser: Parser::default(),
            last_us: 0,
        }
    }
}

impl ServoBus {
    /// The present-value registers become what they show at a time.
    pub fn sense(&mut self, time_us: u64, wheels: [WheelState; SERVOS], supply_v: f64) {
        for (servo, wheel) in self.servos.iter_mut().zip(wheels) {
            servo.sense(time_us, wheel, supply_v);
        }
    }

    /// The board sends `bytes`, the first at `time_us`. [`Self::sense`] comes first.
    pub fn exchange(&mut self, time_us: u64, bytes: &[u8]) -> ServoAnswer {
        if time_us.saturating_sub(self.last_us) > FORGETS_US {
            self.parser.clear();
        }
        self.last_us = time_us;
        let mut answer = ServoAnswer::default();
        let mut unread = bytes;
        while !unread.is_empty() {
            unread = &unread[self.parser.feed(unread)..];
            while let Some(packet) = self.parser.next_packet() {
                // A servo does not answer to what it cannot understand: the ID may be what is
                // broken.
                if let Ok(packet) = packet {
                    obey(&mut self.servos, time_us, packet, &mut answer);
                }
            }
        }
        answer.delay_us += BYTE_US * bytes.len() as u32;
        answer
    }
}

/// All listening servos do what the packet says. `answer` gathers the first delay and all bytes.
fn obey(servos: &mut [VirtualServo; SERVOS], time_us: u64, packet: Packet<'_>, answer: &mut ServoAnswer) {
    for servo in servos.iter_mut().filter(|servo| servo.listens()) {
        servo.hear(time_us);
    }
    match Instruction::from_code(packet.instruction) {
        Some(Instruction::SyncRead) => sync_read(servos, packet, answer),
        Some(Instruction::FastSyncRead) => fast_sync_read(servos, packet, answer),
        Some(Instruction::SyncWrite) => sync_write(servos, packet.parameters),
        Some(Instruction::Status) => {}
        instruction => {
            for servo in servos.iter_mut().filter(|servo| servo.listens()) {
                if packet.id == servo.id() || packet.id == BROADCAST {
                    one(servo, instruction, packet, answer);
                }
            }
        }
    }
}

/// An instruction for one servo, or for each.
fn one(
    servo: &mut VirtualServo,
    instruction: Option<Instruction>,
    packet: Packet<'_>,
    answer: &mut ServoAnswer,
) {
    let is_broadcast = packet.id == BROADCAST;
    let (from_level, result) = match instruction {
        Some(Instruction::Ping) => {
            let [low, high] = MODEL.to_le_bytes();
            (0, Ok(vec![low, high, FIRMWARE]))
        }
        Some(Instruction::Read) if is_broadcast => return,
        Some(Instruction::Read) => (1, read(servo, packet.parameters)),
        Some(Instruction::Write) => (2, write(servo, packet.parameters)),
        Some(Instruction::Reboot) => {
            servo.reboot();
            (2, Ok(Vec::new()))
        }
        _ => (2, Err(Refusal::Instruction)),
    };
    let is_wanted = servo.status_level() >= from_level;
    if is_wanted && (!is_broadcast || instruction == Some(Instruction::Ping)) {
        status(servo, &result, answer);
    }
}

fn read(servo: &VirtualServo, parameters: &[u8]) -> Result<Vec<u8>, Refusal> {
    let [a, b, c, d] = *parameters else { return Err(Refusal::Length) };
    servo.read(u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])).map(<[u8]>::to_vec)
}

fn write(servo: &mut VirtualServo, parameters: &[u8]) -> Result<Vec<u8>, Refusal> {
    let [a, b, data @ ..] = parameters else { return Err(Refusal::Length) };
    servo.write(u16::from_le_bytes([*a, *b]), data).map(|()| Vec::new())
}

/// A servo's status, after those of others. A fault of the servo may spoil it.
fn status(servo: &mut VirtualServo, result: &Result<Vec<u8>, Refusal>, answer: &mut ServoAnswer) {
    let (error, data) = match result {
        Ok(data) => (servo.alert(), &data[..]),
        Err(refusal) => (servo.alert() | *refusal as u8, &[][..]),
    };
    let mut buffer = [0; 2 * LONGEST];
    let id = servo.id();
    if let Ok(bytes) = encode(id, Instruction::Status, &[&[error], data], &mut buffer) {
        let bytes = bytes.to_vec();
        deliver(servo, bytes, answer);
    }
}

/// Puts an answer on the wire, or what a fault leaves of it.
fn deliver(servo: &mut VirtualServo, mut bytes: Vec<u8>, answer: &mut ServoAnswer) {
    if servo.drop_next > 0 {
        servo.drop_next -= 1;
        return;
    }
    if servo.corrupt_next > 0 {
        servo.corrupt_next -= 1;
        // The last byte of the data, or the error.
        if let Some(byte) = bytes.iter_mut().nth_back(2) {
            *byte ^= 0x10;
        }
    }
    if answer.bytes.is_empty() {
        answer.delay_us = servo.return_delay_us();
    }
    answer.bytes.extend(bytes);
}

/// Address, length and IDs of a sync read; `None` where the packet is too short.
fn sync_request(parameters: &[u8]) -> Option<(u16, u16, &[u8])> {
    let [a, b, c, d, ids @ ..] = parameters else { return None };
    Some((u16::from_le_bytes([*a, *b]), u16::from_le_bytes([*c, *d]), ids))
}

/// Each named servo answers after the one before it, and stays silent if it hears nothing from
/// that.
fn sync_read(servos: &mut [VirtualServo; SERVOS], packet: Packet<'_>, answer: &mut ServoAnswer) {
    let Some((address, count, ids)) = sync_request(packet.parameters) else { return };
    for &id in ids {
        let Some(servo) = servos.iter_mut().find(|servo| servo.id() == id && servo.listens()) else { return };
        if servo.status_level() < 1 {
            return;
        }
        let length = answer.bytes.len();
        let result = servo.read(address, count).map(<[u8]>::to_vec);
        status(servo, &result, answer);
        if answer.bytes.len() == length {
            return;
        }
    }
}

fn sync_write(servos: &mut [VirtualServo; SERVOS], parameters: &[u8]) {
    let Some((address, count, items)) = sync_request(parameters) else { return };
    for item in items.chunks_exact(usize::from(count) + 1) {
        let [id, data @ ..] = item else { return };
        for servo in servos.iter_mut().filter(|servo| servo.id() == *id && servo.listens()) {
            // Nobody hears of a refusal.
            let _ = servo.write(address, data);
        }
    }
}

/// One status for all: error, ID, data and checksum of each servo in turn, every checksum over all
/// before it. Without stuffing, since the first servo could not know the length otherwise.
fn fast_sync_read(servos: &mut [VirtualServo; SERVOS], packet: Packet<'_>, answer: &mut ServoAnswer) {
    let Some((address, count, ids)) = sync_request(packet.parameters) else { return };
    let each = usize::from(count) + 4;
    let Ok(length) = u16::try_from(1 + ids.len() * each) else { return };
    let mut bytes = Vec::with_capacity(OVERHEAD + ids.len() * each);
    bytes.extend([0xFF, 0xFF, 0xFD, 0x00, BROADCAST]);
    bytes.extend(length.to_le_bytes());
    bytes.push(Instruction::Status as u8);
    let mut delay_us = None;
    for &id in ids {
        let servo = servos.iter_mut().find(|servo| servo.id() == id && servo.listens());
        // The others wait for their place, in vain.
        let Some(servo) = servo.filter(|servo| servo.status_level() >= 1) else { break };
        let (error, data) = match servo.read(address, count) {
            Ok(data) => (0, data.to_vec()),
            Err(refusal) => (refusal as u8, vec![0; usize::from(count)]),
        };
        bytes.extend([error | servo.alert(), id]);
        bytes.extend(data);
        bytes.extend(Crc::<u16>::new(&CRC_16_UMTS).checksum(&bytes).to_le_bytes());
        let before = answer.bytes.len();
        deliver(servo, std::mem::take(&mut bytes), answer);
        if answer.bytes.len() == before {
            break;
        }
        // Later checksums cover what has been sent.
        bytes.extend(answer.bytes.drain(before..));
        delay_us.get_or_insert(servo.return_delay_us());
    }
    if let Some(delay_us) = delay_us {
        answer.delay_us = delay_us;
        answer.bytes.extend(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEEL: WheelState = WheelState { angle_rad: 1.0, speed_rad_s: 6.0, duty: 0.5, current_a: 0.1 };

    fn bus() -> ServoBus {
        let mut bus = ServoBus::default();
        bus.sense(0, [WHEEL; 2], 12.0);
        bus
    }

    fn send(bus: &mut ServoBus, id: u8, instruction: Instruction, parameters: &[u8]) -> ServoAnswer {
        let mut buffer = [0; 256];
        let bytes = encode(id, instruction, &[parameters], &mut buffer).unwrap().to_vec();
        bus.exchange(1_000_000, &bytes)
    }

    /// (id, error, data) of each status.
    fn statuses(bytes: &[u8]) -> Vec<(u8, u8, Vec<u8>)> {
        let mut parser = Parser::<512>::default();
        parser.feed(bytes);
        let mut statuses = Vec::new();
        while let Some(packet) = parser.next_packet() {
            let Ok(packet) = packet else { continue };
            assert_eq!(packet.instruction, 0x55);
            statuses.push((packet.id, packet.parameters[0], packet.parameters[1..].to_vec()));
        }
        statuses
    }

    /// The e-manual's examples of ping (Protocol 2.0, 5.1): to ID 1, and to all. Its answers are of
    /// model 1030 with firmware 26h; here 1060 with firmware 46. The request of ten bytes takes 100
    /// µs, the return delay 500 µs.
    #[test]
    fn ping() {
        let request = [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E];
        let answer = bus().exchange(0, &request);
        assert_eq!(answer.delay_us, 600);
        assert_eq!(answer.bytes[..12], [0xFF, 0xFF, 0xFD, 0x00, 1, 7, 0, 0x55, 0, 0x24, 0x04, 46]);
        let all = [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x03, 0x00, 0x01, 0x31, 0x42];
        let ids: Vec<u8> = statuses(&bus().exchange(0, &all).bytes).iter().map(|status| status.0).collect();
        assert_eq!(ids, [1, 2]);
    }

    /// The e-manual's example of a sync read of the present position (132, 4 bytes) from 1 and 2
    /// (Protocol 2.0, 5.10).
    #[test]
    fn sync_read_as_the_manual_has_it() {
        let request =
            [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA];
        let answer = bus().exchange(0, &request);
        assert_eq!(answer.delay_us, 160 + 500);
        // 1 rad is 651.9 ticks.
        let position = 651_i32.to_le_bytes().to_vec();
        assert_eq!(statuses(&answer.bytes), [(1, 0, position.clone()), (2, 0, position)]);
    }

    /// What the board reads at each sample: load to temperature, 21 bytes.
    #[test]
    fn all_present_values_in_one_read() {
        let answer = send(&mut bus(), BROADCAST, Instruction::SyncRead, &[126, 0, 21, 0, 1, 2]);
        let statuses = statuses(&answer.bytes);
        assert_eq!(statuses.len(), 2);
        let (_, error, data) = &statuses[0];
        assert_eq!((*error, data.len()), (0, 21));
        assert_eq!(i16::from_le_bytes([data[0], data[1]]), 77, "0.1 A of 1.3 A");
        assert_eq!(data[2..6], 250_i32.to_le_bytes());
        assert_eq!(data[18..], [120, 0, 32]);
    }

    /// A servo that hears nothing from the one before it does not answer either.
    #[test]
    fn faults_cost_what_they_cost_on_the_wire() {
        let read = |bus: &mut ServoBus| {
            let answer = send(bus, BROADCAST, Instruction::SyncRead, &[132, 0, 4, 0, 1, 2]);
            statuses(&answer.bytes).iter().map(|status| (status.0, status.1)).collect::<Vec<_>>()
        };
        let mut broken = bus();
        broken.servos[1].dead = true;
        assert_eq!(read(&mut broken), [(1, 0)]);
        broken.servos[0].drop_next = 1;
        broken.servos[1].dead = false;
        assert_eq!(read(&mut broken), []);
        broken.servos[0].corrupt_next = 1;
        assert_eq!(read(&mut broken), [(2, 0)]);
        broken.servos[1].fail(super::super::servo::OVERLOAD);
        assert_eq!(read(&mut broken), [(1, 0), (2, 0x80)]);
        assert_eq!(statuses(&send(&mut broken, 2, Instruction::Reboot, &[]).bytes), [(2, 0, vec![])]);
        assert_eq!(read(&mut broken), [(1, 0), (2, 0)]);
    }

    #[test]
    fn writes_and_refusals() {
        let mut bus = bus();
        let error = |answer: ServoAnswer| statuses(&answer.bytes).first().map(|status| status.1);
        assert_eq!(error(send(&mut bus, 1, Instruction::Write, &[64, 0, 1])), Some(0));
        assert_eq!(error(send(&mut bus, 1, Instruction::Write, &[9, 0, 1])), Some(7));
        assert_eq!(error(send(&mut bus, 1, Instruction::Read, &[0, 2, 4, 0])), Some(7));
        assert_eq!(error(send(&mut bus, 1, Instruction::Read, &[0, 0, 4])), Some(5));
        assert_eq!(error(send(&mut bus, 3, Instruction::Ping, &[])), None);
        // Status level 1: no answer to writes. To all: never one.
        assert_eq!(error(send(&mut bus, 1, Instruction::Write, &[68, 0, 1])), None);
        assert_eq!(error(send(&mut bus, 1, Instruction::Read, &[68, 0, 1, 0])), Some(0));
        assert_eq!(error(send(&mut bus, BROADCAST, Instruction::Write, &[65, 0, 1])), None);
        assert_eq!(bus.servos[1].read(65, 1), Ok(&[1][..]));
        let speeds =
            [&[104, 0, 4, 0, 1][..], &100_i32.to_le_bytes(), &[2], &(-50_i32).to_le_bytes()].concat();
        assert_eq!(error(send(&mut bus, BROADCAST, Instruction::SyncWrite, &speeds)), None);
        assert_eq!(bus.servos[0].read(104, 4), Ok(&[100, 0, 0, 0][..]));
        assert_eq!(bus.servos[1].read(104, 4), Ok(&[0xCE, 0xFF, 0xFF, 0xFF][..]));
    }

    /// Error, ID, data and checksum of each, the last checksum that of the packet (e-manual,
    /// Protocol 2.0, 5.12).
    #[test]
    fn fast_sync_read() {
        let answer = send(&mut bus(), BROADCAST, Instruction::FastSyncRead, &[132, 0, 4, 0, 1, 2]);
        let bytes = &answer.bytes;
        assert_eq!(answer.delay_us, 160 + 500);
        assert_eq!(bytes[..8], [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 17, 0, 0x55]);
        assert_eq!(
            (bytes[8..14].to_vec(), bytes[16..22].to_vec()),
            (vec![0, 1, 139, 2, 0, 0], vec![0, 2, 139, 2, 0, 0])
        );
        assert_eq!(bytes.len(), 24);
        // The codec accepts it: length and last checksum fit.
        let mut parser = Parser::<64>::default();
        parser.feed(bytes);
        assert!(parser.next_packet().unwrap().is_ok());
    }

    /// Half a packet is forgotten after a silence, and does not spoil the next.
    #[test]
    fn a_truncated_packet_does_not_spoil_the_next() {
        let mut bus = bus();
        assert!(bus.exchange(0, &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x40]).bytes.is_empty());
        assert_eq!(statuses(&send(&mut bus, 1, Instruction::Ping, &[]).bytes).len(), 1);
    }
}
