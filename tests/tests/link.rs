//! The link on the board's core: packets of the e-manual (docs/en/dxl/protocol2.md, "Instruction
//! Details"), answers, and uploads that have to be refused.
#![cfg_attr(target_os = "none", no_std, no_main)]

use firmware::control_table::{Item, Reason, UPLOAD_ITEM, UPLOAD_WINDOW, UploadState};
use firmware::dynamixel::packet::{BROADCAST, Instruction, Parser, encode};
use firmware::items::{ItemBytes, RobotIdentity};
use firmware::link::{Device, LONGEST_ANSWER, State, write};
use model_core::coefficients::Coefficients;
use on_target_tests::{Failed, Outcome, ensure, tests};

#[allow(dead_code, clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/image.rs");
}
use reference::IMAGE;

tests!(
    encodes_as_the_manual,
    finds_packets_in_noise,
    answers_a_ping,
    reads_the_whole_table,
    stores_a_good_upload,
    keeps_the_old_set_whichever_bit_flips,
    keeps_the_old_set_wherever_an_upload_ends,
);

const SAMPLE_RATE_HZ: u16 = 200;

const EXAMPLES: [(u8, Instruction, &[u8], &[u8]); 6] = [
    (1, Instruction::Ping, &[], b"\xFF\xFF\xFD\x00\x01\x03\x00\x01\x19\x4E"),
    (1, Instruction::Read, &[0x84, 0, 4, 0], b"\xFF\xFF\xFD\x00\x01\x07\x00\x02\x84\x00\x04\x00\x1D\x15"),
    (
        1,
        Instruction::Write,
        &[0x74, 0, 0, 2, 0, 0],
        b"\xFF\xFF\xFD\x00\x01\x09\x00\x03\x74\x00\x00\x02\x00\x00\xCA\x89",
    ),
    (
        1,
        Instruction::Status,
        &[0, 0xA6, 0, 0, 0],
        b"\xFF\xFF\xFD\x00\x01\x08\x00\x55\x00\xA6\x00\x00\x00\x8C\xC0",
    ),
    (
        BROADCAST,
        Instruction::SyncRead,
        &[0x84, 0, 4, 0, 1, 2],
        b"\xFF\xFF\xFD\x00\xFE\x09\x00\x82\x84\x00\x04\x00\x01\x02\xCE\xFA",
    ),
    (1, Instruction::Reboot, &[], b"\xFF\xFF\xFD\x00\x01\x03\x00\x08\x2F\x4E"),
];

fn encodes_as_the_manual() -> Outcome {
    for (id, instruction, parameters, expected) in EXAMPLES {
        let mut buffer = [0; 32];
        let found = encode(id, instruction, &[parameters], &mut buffer);
        ensure(found == Ok(expected), format_args!("{instruction:?}: {found:02x?}"))?;
    }
    Ok(())
}

fn finds_packets_in_noise() -> Outcome {
    let mut parser = Parser::<64>::new();
    for (id, instruction, parameters, bytes) in EXAMPLES {
        // The beginning of a packet that never ends.
        for piece in [b"\xFF\xFF\xFD\x00\xC8\x30\x00\x03".as_slice(), bytes] {
            ensure(parser.feed(piece) == piece.len(), format_args!("no room"))?;
        }
        let broken = parser.next_packet();
        ensure(matches!(broken, Some(Err(_))), format_args!("{broken:?}"))?;
        let found = parser.next_packet();
        let packet = found.and_then(Result::ok).ok_or(Failed)?;
        ensure(packet.id == id && packet.instruction == instruction as u8, format_args!("{packet:?}"))?;
        ensure(packet.parameters == parameters, format_args!("{packet:?}"))?;
    }
    Ok(())
}

/// Checksums by a bitwise division in Python.
fn answers_a_ping() -> Outcome {
    let (mut device, mut state) = (Device::new(), State::new(SAMPLE_RATE_HZ, 25, &mut []));
    let mut buffer = [0; LONGEST_ANSWER];
    device.feed(b"\xFF\xFF\xFD\x00\xC8\x03\x00\x01\x3B\xFA");
    let length = device.answer(&mut state, &mut buffer).ok_or(Failed)?;
    let found = buffer.get(..length).ok_or(Failed)?;
    let expected = b"\xFF\xFF\xFD\x00\xC8\x07\x00\x55\x00\x00\x50\x01\x57\x37";
    ensure(found == expected, format_args!("{found:02x?}"))
}

fn reads_the_whole_table() -> Outcome {
    let (mut device, mut state) = (Device::new(), State::new(SAMPLE_RATE_HZ, 25, &mut []));
    let (mut request, mut buffer) = ([0; 32], [0; LONGEST_ANSWER]);
    let [low, high] = firmware::control_table::END.to_le_bytes();
    let read = Instruction::Read;
    device.feed(encode(200, read, &[&[0, 0, low, high]], &mut request).map_err(|_| Failed)?);
    let length = device.answer(&mut state, &mut buffer).ok_or(Failed)?;
    let mut parser = Parser::<LONGEST_ANSWER>::new();
    parser.feed(buffer.get(..length).ok_or(Failed)?);
    let packet = parser.next_packet().and_then(Result::ok).ok_or(Failed)?;
    ensure(
        packet.parameters.len() == 1 + usize::from(firmware::control_table::END),
        format_args!("{} bytes", packet.parameters.len()),
    )
}

/// A board of the robot that the reference image is for.
fn board() -> Result<State<'static>, Failed> {
    let mut state = State::new(SAMPLE_RATE_HZ, 25, &mut []);
    let coefficients = Coefficients::<f32, 2>::decode(&IMAGE).map_err(|_| Failed)?;
    let robot = RobotIdentity::of(&coefficients.robot).encode();
    state.load(Item::Robot, Ok(ItemBytes::new(&robot).ok_or(Failed)?));
    state.snapshot.is_standing = true;
    Ok(state)
}

fn upload(state: &mut State<'static>, bytes: &[u8]) -> Result<(UploadState, Reason), Failed> {
    write(state, UPLOAD_WINDOW.address, bytes).map_err(|_| Failed)?;
    let [low, high] = (bytes.len() as u16).to_le_bytes();
    write(state, UPLOAD_ITEM.address, &[Item::Coefficients as u8, 1, low, high]).map_err(|_| Failed)?;
    Ok((state.upload().state(), state.upload().reason()))
}

/// A board with the reference image in use.
fn set_up() -> Result<State<'static>, Failed> {
    let mut state = board()?;
    let found = upload(&mut state, &IMAGE)?;
    ensure(found == (UploadState::Waiting, Reason::None), format_args!("{found:?}"))?;
    let (item, pending) = state.take_pending().ok_or(Failed)?;
    ensure(pending.as_slice() == IMAGE, format_args!("{pending:?}"))?;
    state.stored(item, Ok(()));
    Ok(state)
}

fn stores_a_good_upload() -> Outcome {
    let state = set_up()?;
    let coefficients = Coefficients::<f32, 2>::decode(&IMAGE).map_err(|_| Failed)?;
    let found = state.settings().coefficients();
    ensure(found == Ok(&coefficients), format_args!("{found:?}"))
}

fn ensure_refused(state: &mut State<'static>, bytes: &[u8]) -> Outcome {
    let before = state.settings().clone();
    let (found, reason) = upload(state, bytes)?;
    ensure(found == UploadState::Refused && reason != Reason::None, format_args!("{found:?}, {reason:?}"))?;
    ensure(state.take_pending().is_none(), format_args!("to be written all the same"))?;
    ensure(*state.settings() == before, format_args!("the old set is gone"))
}

fn keeps_the_old_set_whichever_bit_flips() -> Outcome {
    let mut state = set_up()?;
    for bit in 0..8 * IMAGE.len() {
        let mut damaged = IMAGE;
        if let Some(byte) = damaged.get_mut(bit / 8) {
            *byte ^= 1 << (bit % 8);
        }
        ensure_refused(&mut state, &damaged)?;
    }
    Ok(())
}

fn keeps_the_old_set_wherever_an_upload_ends() -> Outcome {
    let mut state = set_up()?;
    for length in 1..IMAGE.len() {
        ensure_refused(&mut state, IMAGE.get(..length).unwrap_or(&[]))?;
    }
    Ok(())
}
