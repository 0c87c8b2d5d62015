//! An upload as the host sees it: registers written and read. Whatever is wrong with it, the board
//! keeps what it has and says why.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{SAMPLE_RATE_HZ, burger, image, sealed, with_number};
use embassy_futures::block_on;
use firmware::control_table::{
    self as table, FIFO_ACKNOWLEDGE, Item, Reason, Register, UPLOAD_BYTES, UPLOAD_COMMAND, UPLOAD_ITEM,
    UPLOAD_LENGTH, UPLOAD_WINDOW, UploadState,
};
use firmware::dynamixel::status::Refusal;
use firmware::items::{Calibration, ITEMS, RobotIdentity, SIGNATURE_BYTES};
use firmware::link::{self, render};
use firmware::measurement::DriveSnapshot;
use firmware::store::{BYTES, RamFlash, Store};
use firmware::wheels::DriveState;
use model_core::coefficients::Name;

type State = link::State<'static>;

fn board() -> State {
    State::new(SAMPLE_RATE_HZ, 25, &mut [])
}

fn read(state: &State, register: Register) -> Vec<u8> {
    let mut bytes = vec![0; register.size().into()];
    render(state, register.address, &mut bytes);
    bytes
}

fn write(state: &mut State, register: Register, bytes: &[u8]) -> Result<(), Refusal> {
    link::write(state, register.address, bytes)
}

/// What the host finds.
fn outcome(state: &State) -> (UploadState, Reason) {
    let (code, reason) = (read(state, table::UPLOAD_STATE)[0], read(state, table::UPLOAD_REASON)[0]);
    (UploadState::from_code(code).unwrap(), Reason::from_code(reason).unwrap())
}

/// Item, length and window, then the command.
fn upload(state: &mut State, item: u8, bytes: &[u8]) -> (UploadState, Reason) {
    let mut window = [0xEE; UPLOAD_BYTES];
    let shown = bytes.len().min(UPLOAD_BYTES);
    window[..shown].copy_from_slice(&bytes[..shown]);
    write(state, UPLOAD_WINDOW, &window).unwrap();
    let [low, high] = (bytes.len() as u16).to_le_bytes();
    write(state, UPLOAD_ITEM, &[item, 1, low, high]).unwrap();
    outcome(state)
}

/// As the task that keeps the store does, with a flash that takes everything.
fn keep(state: &mut State) -> Option<Item> {
    let (item, _) = state.take_pending()?;
    state.stored(item, Ok(()));
    Some(item)
}

/// A board at a standstill with coefficients, calibration and robot stored.
fn set_up() -> State {
    let mut state = board();
    state.snapshot.is_standing = true;
    for (item, bytes) in good() {
        assert_eq!(upload(&mut state, item as u8, &bytes), (UploadState::Waiting, Reason::None));
        assert_eq!(keep(&mut state), Some(item));
    }
    state
}

fn good() -> [(Item, Vec<u8>); 3] {
    let calibration = Calibration { power_factors: [1.001, 0.999, 1.002, 0.998] };
    [
        (Item::Coefficients, image(&burger())),
        (Item::Calibration, calibration.encode().to_vec()),
        (Item::Robot, RobotIdentity::BURGER.encode().to_vec()),
    ]
}

#[track_caller]
fn assert_kept(state: &mut State, before: &State) {
    assert_eq!(state.settings(), before.settings());
    assert_eq!(state.take_pending(), None, "nothing may be written");
    for register in
        [table::MODEL, table::COEFFICIENTS_STATE, table::COEFFICIENTS_CRC, table::RAIL_CALIBRATION]
    {
        assert_eq!(read(state, register), read(before, register), "{}", register.name);
    }
}

fn refused(reason: Reason) -> (UploadState, Reason) {
    (UploadState::Refused, reason)
}

const STORED: (UploadState, Reason) = (UploadState::Stored, Reason::None);
const WAITING: (UploadState, Reason) = (UploadState::Waiting, Reason::None);

#[test]
fn a_good_upload_waits_for_standstill_and_is_in_use_when_it_is_stored() {
    let mut state = board();
    let bytes = image(&burger());
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [Reason::Empty as u8]);
    assert_eq!(upload(&mut state, 1, &bytes), WAITING);
    assert_eq!(state.take_pending(), None, "in motion");
    assert!(state.settings().coefficients().is_err());
    state.snapshot.is_standing = true;
    let (item, pending) = state.take_pending().unwrap();
    assert_eq!((item, pending.as_slice()), (Item::Coefficients, bytes.as_slice()));
    assert_eq!(state.take_pending(), None, "once only");
    assert_eq!(outcome(&state), WAITING, "until it is read back");
    let changes = state.settings().changes();
    state.stored(item, Ok(()));
    assert_eq!(outcome(&state), STORED);
    assert_eq!(state.settings().coefficients(), Ok(&burger()));
    assert_ne!(state.settings().changes(), changes);

    assert_eq!(read(&state, table::MODEL), [2]);
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [0]);
    assert_eq!(read(&state, table::COEFFICIENTS_CRC), bytes[bytes.len() - 4..]);
    assert_eq!(read(&state, table::STORED_LENGTH), (bytes.len() as u16).to_le_bytes());
    assert_eq!(read(&state, table::STORED_WINDOW)[..bytes.len()], bytes);
    assert_eq!(read(&state, table::STORE_WRITES), 1_u32.to_le_bytes());
    // Of another item nothing is stored.
    write(&mut state, UPLOAD_ITEM, &[2]).unwrap();
    assert_eq!(read(&state, table::STORED_LENGTH), [0, 0]);
    assert_eq!(read(&state, table::STORED_WINDOW), [0; UPLOAD_BYTES]);
}

#[test]
fn a_calibration_is_in_use_when_it_is_stored() {
    let state = set_up();
    let shown = read(&state, table::RAIL_CALIBRATION);
    assert_eq!(shown, [1.001_f32, 0.999, 1.002, 0.998].map(f32::to_le_bytes).concat());
}

/// Of every item: whichever bit flips, it is refused, for the reason that the bit's place gives.
#[test]
fn every_flipped_bit_is_refused() {
    let before = set_up();
    for (item, bytes) in good() {
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            let mut state = before.without_samples();
            let (upload_state, reason) = upload(&mut state, item as u8, &damaged);
            assert_eq!(upload_state, UploadState::Refused, "{item:?} {bit}");
            let expected: &[Reason] = match bit / 8 {
                0..4 => &[Reason::NotAnImage],
                // One layout's version is a bit away from another's: then the checksum tells.
                4..6 => &[Reason::Version, Reason::Checksum],
                // Where the checksum is looked for depends on the length.
                6..8 => &[Reason::Length, Reason::Checksum],
                _ => &[Reason::Checksum],
            };
            assert!(expected.contains(&reason), "{item:?} {bit}: {reason:?}");
            assert_kept(&mut state, &before);
        }
    }
}

/// Fewer bytes, as `UPLOAD_LENGTH` says it or as it is not said; and more.
#[test]
fn every_truncation_is_refused() {
    let before = set_up();
    for (item, bytes) in good() {
        for length in 0..bytes.len() {
            let mut state = before.without_samples();
            let expected = if length == 0 { Reason::Empty } else { Reason::Length };
            assert_eq!(
                upload(&mut state, item as u8, &bytes[..length]),
                refused(expected),
                "{item:?} {length}"
            );
            assert_kept(&mut state, &before);
        }
        // The window was not filled to its end.
        for length in 8..bytes.len() {
            let mut unfilled = bytes.clone();
            unfilled[length..].fill(0);
            let mut state = before.without_samples();
            assert_eq!(
                upload(&mut state, item as u8, &unfilled),
                refused(Reason::Checksum),
                "{item:?} {length}"
            );
            assert_kept(&mut state, &before);
        }
        for length in [bytes.len() + 1, UPLOAD_BYTES, UPLOAD_BYTES + 1, 0xFFFF] {
            let mut longer = bytes.clone();
            longer.resize(length, 0);
            let mut state = before.without_samples();
            assert_eq!(upload(&mut state, item as u8, &longer), refused(Reason::Length), "{item:?} {length}");
            assert_kept(&mut state, &before);
        }
    }
}

/// Every checksum is right, but not what it stands for.
#[test]
fn what_does_not_fit_this_board_is_refused() {
    let before = set_up();
    let good = image(&burger());
    let mut warthog = burger();
    warthog.robot.name = Name::new("Warthog");
    let patched = |at: usize, byte: u8| {
        let mut image = good.clone();
        image[at] = byte;
        sealed(image)
    };
    for (what, bytes, expected) in [
        ("another robot's name", image(&warthog), Reason::Robot),
        ("another wheel radius", with_number(&good, 136, 0.02), Reason::Robot),
        ("another version", patched(4, 9), Reason::Version),
        ("another model", patched(8, 7), Reason::Model),
        ("four wheels", patched(10, 4), Reason::Wheels),
        ("NaN", with_number(&good, 76, f32::NAN), Reason::Value),
        ("infinity", with_number(&good, 76, f32::INFINITY), Reason::Value),
        ("negative", with_number(&good, 76, -1.0), Reason::Value),
        ("1e38", with_number(&good, 76, 1e38), Reason::Value),
        ("no mass range", with_number(&good, 52, 1.0), Reason::Value),
        ("cutoff 1 MHz", with_number(&good, 44, 1e6), Reason::Cutoff),
    ] {
        let mut state = before.without_samples();
        assert_eq!(upload(&mut state, 1, &bytes), refused(expected), "{what}");
        assert_kept(&mut state, &before);
    }
    for item in [0, 4, 255] {
        let mut state = before.without_samples();
        assert_eq!(upload(&mut state, item, &good), refused(Reason::Item), "item {item}");
        assert_kept(&mut state, &before);
    }
}

/// Coefficients belong to a robot: set up for another, the board no longer uses those it has, and
/// takes the other's.
#[test]
fn another_robot_needs_other_coefficients() {
    let mut state = set_up();
    let mut other = burger();
    other.robot.name = Name::new("Waffle");
    assert_eq!(upload(&mut state, 1, &image(&other)), refused(Reason::Robot));
    assert_eq!(upload(&mut state, 3, &RobotIdentity::of(&other.robot).encode()), WAITING);
    assert_eq!(keep(&mut state), Some(Item::Robot));
    assert_eq!(read(&state, table::ROBOT_NAME)[..7], *b"Waffle\0");
    assert_eq!(state.settings().coefficients(), Err(Reason::Robot));
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [Reason::Robot as u8]);
    assert_eq!((read(&state, table::MODEL), read(&state, table::COEFFICIENTS_CRC)), (vec![255], vec![0; 4]));
    assert_eq!(upload(&mut state, 1, &image(&other)), WAITING);
    assert_eq!(keep(&mut state), Some(Item::Coefficients));
    assert_eq!(state.settings().coefficients(), Ok(&other));
}

/// Between check and writing nothing of it can be changed; saying the command twice does no harm.
#[test]
fn what_was_checked_is_what_is_written() {
    let mut state = board();
    let bytes = image(&burger());
    assert_eq!(upload(&mut state, 1, &bytes), WAITING);
    assert_eq!(write(&mut state, UPLOAD_WINDOW, &[0; UPLOAD_BYTES]), Err(Refusal::Access));
    assert_eq!(write(&mut state, UPLOAD_ITEM, &[2]), Err(Refusal::Access));
    assert_eq!(write(&mut state, UPLOAD_LENGTH, &[1, 0]), Err(Refusal::Access));
    assert_eq!(write(&mut state, UPLOAD_COMMAND, &[1]), Ok(()));
    assert_eq!(write(&mut state, FIFO_ACKNOWLEDGE, &[0; 4]), Ok(()), "others go on");
    state.snapshot.is_standing = true;
    let (_, pending) = state.take_pending().unwrap();
    assert_eq!(pending.as_slice(), bytes);
    assert_eq!(write(&mut state, UPLOAD_COMMAND, &[2]), Err(Refusal::Access), "too late");
    assert_eq!(write(&mut state, UPLOAD_COMMAND, &[1]), Ok(()));
    assert_eq!(state.take_pending(), None);
}

#[test]
fn an_upload_that_waits_can_be_forgotten() {
    let mut state = board();
    assert_eq!(upload(&mut state, 1, &image(&burger())), WAITING);
    write(&mut state, UPLOAD_COMMAND, &[2]).unwrap();
    assert_eq!(outcome(&state), (UploadState::Idle, Reason::None));
    state.snapshot.is_standing = true;
    assert_eq!(state.take_pending(), None);
}

#[test]
fn what_is_stored_already_is_not_written_again() {
    let mut state = set_up();
    for (item, bytes) in good() {
        assert_eq!(upload(&mut state, item as u8, &bytes), STORED);
        assert_eq!(state.take_pending(), None);
    }
}

#[test]
fn a_flash_that_fails_leaves_what_was() {
    let before = set_up();
    let mut other = burger();
    other.robot.dead_band = 0.03;
    for reason in [Reason::Flash, Reason::ReadBack] {
        let mut state = before.without_samples();
        assert_eq!(upload(&mut state, 1, &image(&other)), WAITING);
        let (item, _) = state.take_pending().unwrap();
        state.stored(item, Err(reason));
        assert_eq!(outcome(&state), refused(reason));
        assert_kept(&mut state, &before);
    }
}

/// Another set for the same robot.
fn other() -> Vec<u8> {
    let mut other = burger();
    other.robot.dead_band = 0.03;
    image(&other)
}

fn crc(bytes: &[u8]) -> [u8; 4] {
    *bytes.last_chunk().unwrap()
}

fn previous(state: &State) -> (Vec<u8>, Reason) {
    let reason = Reason::from_code(read(state, table::PREVIOUS_STATE)[0]).unwrap();
    (read(state, table::PREVIOUS_CRC), reason)
}

/// There and back again, each time at a standstill; what is said twice, because an answer got lost,
/// is done once.
#[test]
fn the_coefficients_before_come_back_into_use() {
    let mut state = set_up();
    let (first, second) = (image(&burger()), other());
    assert_eq!(previous(&state), (vec![0; 4], Reason::Empty));
    // Nothing is there to go back to.
    write(&mut state, table::PREVIOUS_CRC, &[0; 4]).unwrap();
    assert_eq!(outcome(&state), refused(Reason::Empty));
    assert_eq!(upload(&mut state, 1, &second), WAITING);
    assert_eq!(keep(&mut state), Some(Item::Coefficients));
    for (from, to) in [(&second, &first), (&first, &second)] {
        assert_eq!(previous(&state), (crc(to).to_vec(), Reason::None));
        assert_eq!(read(&state, table::COEFFICIENTS_CRC), crc(from));
        state.snapshot.is_standing = false;
        for _ in 0..2 {
            write(&mut state, table::PREVIOUS_CRC, &crc(to)).unwrap();
            assert_eq!((outcome(&state), keep(&mut state)), (WAITING, None), "in motion");
        }
        assert_eq!(write(&mut state, table::PREVIOUS_CRC, &crc(from)), Err(Refusal::Access));
        state.snapshot.is_standing = true;
        assert_eq!(keep(&mut state), Some(Item::Coefficients));
        assert_eq!(read(&state, table::COEFFICIENTS_CRC), crc(to));
        write(&mut state, table::PREVIOUS_CRC, &crc(to)).unwrap();
        assert_eq!((outcome(&state), keep(&mut state)), (STORED, None));
    }
    assert_eq!(read(&state, table::STORE_WRITES), 6_u32.to_le_bytes());
}

/// Coefficients of a robot that the board is no longer set up for do not come back.
#[test]
fn coefficients_before_are_checked_as_an_upload_is() {
    let mut state = set_up();
    let mut waffle = burger();
    waffle.robot.name = Name::new("Waffle");
    upload(&mut state, 3, &RobotIdentity::of(&waffle.robot).encode());
    keep(&mut state);
    upload(&mut state, 1, &image(&waffle));
    keep(&mut state);
    assert_eq!(previous(&state), (crc(&image(&burger())).to_vec(), Reason::Robot));
    let before = state.without_samples();
    write(&mut state, table::PREVIOUS_CRC, &crc(&image(&burger()))).unwrap();
    assert_eq!(outcome(&state), refused(Reason::Robot));
    assert_kept(&mut state, &before);
}

/// Behind the image, in the flash too; a board that asks for none takes it with one. A signature of
/// another item does not get there.
#[test]
fn a_signature_goes_with_the_coefficients() {
    let mut state = set_up();
    let signature = [0xA5; SIGNATURE_BYTES];
    write(&mut state, table::UPLOAD_SIGNATURE, &signature).unwrap();
    assert_eq!(upload(&mut state, 1, &other()), WAITING);
    assert_eq!(write(&mut state, table::UPLOAD_SIGNATURE, &[0]), Err(Refusal::Access));
    let (item, pending) = state.take_pending().unwrap();
    assert_eq!(pending.as_slice(), [&other()[..], &signature].concat());
    assert_eq!(pending.image(), other());
    state.stored(item, Ok(()));
    assert_eq!((outcome(&state), read(&state, table::COEFFICIENTS_STATE)), (STORED, vec![0]));
    assert_eq!(read(&state, table::COEFFICIENTS_CRC), crc(&other()));
    assert_eq!(read(&state, table::STORED_LENGTH), (other().len() as u16).to_le_bytes());
    // Back to a set without one, and again to this one, its signature with it.
    for (set, expected) in [(image(&burger()), [0; SIGNATURE_BYTES]), (other(), signature)] {
        write(&mut state, table::PREVIOUS_CRC, &crc(&set)).unwrap();
        assert_eq!(keep(&mut state), Some(Item::Coefficients));
        assert_eq!(read(&state, table::COEFFICIENTS_CRC), crc(&set));
        assert_eq!(read(&state, table::UPLOAD_SIGNATURE), expected);
    }
    assert_eq!(upload(&mut state, 2, &Calibration { power_factors: [1.5; 4] }.encode()), WAITING);
    assert_eq!(state.take_pending().unwrap().1.as_slice().len(), 28);
}

/// Both sectors full: the upload waits until no servo holds a torque, and says so.
#[test]
fn what_needs_an_erase_waits_until_torque_is_off() {
    let mut state = set_up();
    state.snapshot.drive =
        DriveSnapshot { state: DriveState::Ready, has_torque: true, are_off: [false; 2], goals: [0; 2] };
    assert_eq!(upload(&mut state, 1, &other()), WAITING);
    let (item, _) = state.take_pending().unwrap();
    state.stored(item, Err(Reason::Erase));
    assert_eq!((outcome(&state), state.take_pending()), ((UploadState::Waiting, Reason::Erase), None));
    // Off by order, but the servos do not know yet.
    state.snapshot.drive.state = DriveState::Off;
    assert_eq!(state.take_pending(), None);
    // Each servo by itself: one that is off does not speak for the other.
    state.snapshot.drive.has_torque = false;
    for are_off in [[true, false], [false, true]] {
        state.snapshot.drive.are_off = are_off;
        assert_eq!(state.take_pending(), None);
        state.snapshot.drive.state = DriveState::Unfit;
        assert!(!state.may_erase(), "{are_off:?}");
        state.snapshot.drive.state = DriveState::Off;
    }
    state.snapshot.drive.are_off = [true; 2];
    assert_eq!(keep(&mut state), Some(Item::Coefficients));
    assert_eq!((outcome(&state), read(&state, table::COEFFICIENTS_CRC)), (STORED, crc(&other()).to_vec()));
    // A servo that has just started has no torque yet, and is about to get one.
    for (drive, expected) in [
        (DriveState::Ready, false),
        (DriveState::Preparing, false),
        (DriveState::Lost, false),
        (DriveState::CutOff, true),
        (DriveState::Unfit, true),
    ] {
        state.snapshot.drive.state = drive;
        assert_eq!(state.may_erase(), expected, "{drive:?}");
    }
    state.snapshot.drive.state = DriveState::Off;
    assert!(state.may_erase());
    state.snapshot.is_standing = false;
    assert!(!state.may_erase());
}

/// From the link through the flash to the next start.
#[test]
fn survives_a_restart() {
    let mut flash = vec![0xFF; BYTES];
    let mut state = board();
    state.snapshot.is_standing = true;
    for (item, bytes) in good() {
        let mut store = Store::new(RamFlash::new(&mut flash), 0..BYTES as u32).unwrap();
        upload(&mut state, item as u8, &bytes);
        let (item, pending) = state.take_pending().unwrap();
        let result = block_on(store.put(item, pending.as_slice()));
        state.stored(item, result.map_err(Reason::from));
        assert_eq!(outcome(&state), STORED);
    }
    let mut restarted = board();
    let mut store = Store::new(RamFlash::new(&mut flash), 0..BYTES as u32).unwrap();
    for item in ITEMS {
        restarted.load(item, block_on(store.get(item)).map_err(Reason::from));
    }
    assert_eq!(restarted.settings().coefficients(), Ok(&burger()));
    assert_eq!(restarted.settings().calibration().power_factors, [1.001, 0.999, 1.002, 0.998]);
    for (item, bytes) in good() {
        assert_eq!(restarted.settings().stored(item), bytes);
    }
}

/// What is stored may have been for another version of this firmware, or the flash may fail: no
/// coefficients, and the reason.
#[test]
fn what_is_stored_is_checked_at_start() {
    let mut state = board();
    state.load(Item::Coefficients, Err(Reason::Flash));
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [Reason::Flash as u8]);
    // The other items do not hide that.
    state.load(Item::Robot, Err(Reason::Flash));
    state.load(Item::Calibration, Err(Reason::Flash));
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [Reason::Flash as u8]);
    assert_eq!(state.settings().robot(), &RobotIdentity::BURGER);
    assert_eq!(state.settings().calibration(), &Calibration::NONE);
    let item = firmware::items::ItemBytes::new(&with_number(&image(&burger()), 76, f32::NAN)).unwrap();
    state.load(Item::Coefficients, Ok(item));
    assert_eq!(read(&state, table::COEFFICIENTS_STATE), [Reason::Value as u8]);
    assert_eq!(state.settings().stored(Item::Coefficients), item.as_slice());
}

/// `docs/link.md` and hosts print these.
#[test]
fn reasons_have_codes_and_words() {
    let reasons: Vec<Reason> = (0..=255).map_while(Reason::from_code).collect();
    assert_eq!(reasons.len(), 21);
    for (code, reason) in (0..).zip(&reasons) {
        assert_eq!(*reason as u8, code);
        assert!(reasons.iter().all(|other| other == reason || other.text() != reason.text()));
    }
}
