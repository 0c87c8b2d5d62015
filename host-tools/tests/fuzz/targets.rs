//! What is given arbitrary bytes: every reader of files and packets. None may panic, hang or take
//! memory without bound.
//!
//! Shared by `tests/suite/fuzz.rs`, which mutates a small corpus for some seconds, and by the
//! libFuzzer program in `fuzz/`.

use std::path::Path;

use crc::{CRC_32_ISO_HDLC, Crc};
use firmware::control_table::{Item, UPLOAD_BYTES};
use firmware::dynamixel::packet::{Instruction, Parser, encode};
use firmware::items::{self, ItemBytes, RobotIdentity};
use firmware::link::{Device, LONGEST_ANSWER, State};
use log_formats::Bag;
use log_formats::merge::merge;
use log_formats::table::{Cell, Taker};
use logs::SampleReader;
use logs::foreign::choose;
use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use model_core::coefficients::Coefficients;
use support::context::Context;
use virtual_board::servo_bus::ServoBus;

/// Gets the bytes, and a path to write them to where it reads a file.
pub(crate) type Target = fn(&[u8], &Path);

/// By name.
pub(crate) const TARGETS: [(&str, Target); 14] = [
    ("log", log),
    ("robot", robot),
    ("coefficients", coefficients),
    ("effects", effects),
    ("image", image),
    ("link", link),
    ("servo", servo),
    ("mcap", bag),
    ("sqlite", bag),
    ("ulog", bag),
    ("ros1", bag),
    ("dataflash", bag),
    ("vesc_tool", bag),
    ("parquet", parquet),
];

/// A CSV log, as `fit` and `estimate` read it.
fn log(data: &[u8], path: &Path) {
    std::fs::write(path, data).expect("the folder is there");
    let robot = Robot::named("burger").expect("it is built in");
    let Ok(mut rows) = SampleReader::open(&Context::default(), path, &robot) else { return };
    while let Ok(Some(row)) = rows.next_row() {
        assert!(row.time.is_finite() && row.sample.power.is_finite(), "what is handed out is a number");
    }
}

/// A bag or ULog, cut off or not: its topics, what is chosen of them for this robot, and all rows
/// of that.
fn bag(data: &[u8], path: &Path) {
    std::fs::write(path, data).expect("the folder is there");
    let robot = Robot::named("burger").expect("it is built in");
    let Ok(bag) = Bag::open(path, true) else { return };
    for topic in bag.topics() {
        let _ = log_formats::paths(topic);
    }
    let mut table = Table::default();
    if let Some(topic) = log_formats::table::topic(&bag) {
        let _ = log_formats::table::json_topic(&bag, topic, &mut table);
    }
    let Ok(chosen) = choose(&bag, &robot) else { return };
    let mut last = f64::NEG_INFINITY;
    let _ = merge(&bag, &chosen.request, &mut |time, numbers| {
        assert!(time > last, "time increases");
        last = time;
        chosen.columns.iter().for_each(|column| _ = column.expression.of(numbers));
        Ok(())
    });
}

/// A Parquet file.
fn parquet(data: &[u8], path: &Path) {
    std::fs::write(path, data).expect("the folder is there");
    let _ = log_formats::table::parquet(path, &mut Table::default());
}

/// Counts columns.
#[derive(Default)]
struct Table(usize);

impl Taker for Table {
    fn columns(&mut self, columns: &[String]) -> log_formats::Result<()> {
        self.0 = columns.len();
        Ok(())
    }
    fn row(&mut self, row: &[Cell]) -> log_formats::Result<()> {
        assert_eq!(row.len(), self.0, "a cell a column");
        Ok(())
    }
}

/// A robot's TOML.
fn robot(data: &[u8], _: &Path) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(robot) = Robot::parse(text) {
        assert!(robot.mass_no_load_kg() > 0.0 && robot.mass_full_load_kg() > robot.mass_no_load_kg());
        assert!(robot.gyration_radius_m().is_finite() && robot.wheels() > 0);
    }
}

/// A coefficients.toml, with all that is read of it.
fn coefficients(data: &[u8], path: &Path) {
    std::fs::write(path, data).expect("the folder is there");
    let robot = Robot::named("burger").expect("it is built in");
    if let Ok(read) = CoefficientsFile::read(path, &robot) {
        // As `flash` does.
        let _ = read.coefficients.core::<2>().convert::<f32>().and_then(|single| single.encode());
    }
}

/// A file of one's own effects.
fn effects(data: &[u8], path: &Path) {
    std::fs::write(path, data).expect("the folder is there");
    let _ = residuals::user::read(path);
}

/// A coefficients' image and the store's other items: as they are, and with a checksum that is
/// right.
fn image(data: &[u8], _: &Path) {
    decode(data);
    let mut sealed = data.to_vec();
    sealed.truncate(UPLOAD_BYTES - 4);
    if let Some(place) = sealed.get_mut(6..8) {
        let length = (data.len().min(UPLOAD_BYTES - 4) + 4) as u16;
        place.copy_from_slice(&length.to_le_bytes());
    }
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&sealed);
    sealed.extend(checksum.to_le_bytes());
    decode(&sealed);
}

fn decode(bytes: &[u8]) {
    if let Ok(read) = Coefficients::<f32, 2>::decode(bytes) {
        let written = read.encode().expect("what was read can be written");
        let again = Coefficients::<f32, 2>::decode(written.as_bytes()).expect("what was written can be read");
        assert_eq!(format!("{read:?}"), format!("{again:?}"));
    }
    let robot = RobotIdentity::default();
    for item in items::ITEMS {
        let _ = items::check(item, bytes, &robot, 200);
    }
}

/// Bytes of a host, in pieces, as the board gets them: as they are, and as instructions whose
/// checksums are right.
fn link(data: &[u8], _: &Path) {
    let mut state = State::new(200, 25, &mut []);
    let mut device = Device::new();
    let mut answer = [0; LONGEST_ANSWER];
    if let Some(bytes) = ItemBytes::new(data) {
        state.load(Item::Robot, Ok(bytes));
    }
    for piece in [data.to_vec(), packets(data, 200)].iter().flat_map(|bytes| bytes.chunks(64)) {
        let mut rest = piece;
        while !rest.is_empty() {
            let taken = device.feed(rest);
            rest = &rest[taken..];
            let mut answers = 0;
            while let Some(length) = device.answer(&mut state, &mut answer) {
                let mut parser = Parser::<4096>::new();
                assert_eq!(parser.feed(&answer[..length]), length);
                assert!(matches!(parser.next_packet(), Some(Ok(_))), "its answers are packets");
                answers += 1;
            }
            assert!(taken > 0 || answers > 0, "it goes on");
        }
    }
    state.snapshot.is_standing = true;
    if let Some((item, _)) = state.take_pending() {
        state.stored(item, Ok(()));
    }
}

/// Bytes on the servo bus: whatever comes, the servos survive it; packets that are well made are
/// found however they are cut.
fn servo(data: &[u8], _: &Path) {
    let made = packets(data, 1);
    for size in [made.len().max(1), 1, 7] {
        assert_eq!(good_packets(&made, size), good_packets(&made, 64), "in pieces of {size}");
    }
    let _ = good_packets(data, 1);
    for bytes in [data, &made] {
        let mut bus = ServoBus::default();
        for (time_us, piece) in (0..).step_by(100).zip(bytes.chunks(64)) {
            let _ = bus.exchange(time_us, piece);
        }
    }
}

/// The good packets in these bytes, received in pieces of this size.
fn good_packets(bytes: &[u8], size: usize) -> Vec<(u8, u8, Vec<u8>)> {
    let mut parser = Parser::<512>::new();
    let mut packets = Vec::new();
    for mut rest in bytes.chunks(size) {
        while !rest.is_empty() {
            rest = &rest[parser.feed(rest)..];
            while let Some(packet) = parser.next_packet() {
                packets.extend(packet.ok().map(|it| (it.id, it.instruction, it.parameters.to_vec())));
            }
        }
    }
    packets
}

/// Instructions made of the data, stuffed and with their checksums: each piece's first byte chooses
/// the instruction, its second is the length of the parameters.
fn packets(data: &[u8], id: u8) -> Vec<u8> {
    let mut made = Vec::new();
    let mut rest = data;
    while let [choice, length, after @ ..] = rest {
        let (parameters, next) = after.split_at(usize::from(*length).min(after.len()));
        let instruction = Instruction::from_code(*choice).unwrap_or(Instruction::Write);
        let mut buffer = [0; 512];
        made.extend_from_slice(encode(id, instruction, &[parameters], &mut buffer).expect("it fits"));
        rest = next;
    }
    made
}
