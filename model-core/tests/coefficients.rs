//! The coefficient image: what goes in comes out, and what is wrong is named.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{coefficients, servo};
use crc::{CRC_32_ISO_HDLC, Crc};
use model_core::coefficients::{
    Coefficients, DecodeError, LONGEST_IMAGE, NAME_BYTES, Name, Robot, VERSION, VERSION_WITH_EFFECTS,
};
use model_core::conditioning::Conditioning;
use model_core::effects::{Cause, Column, Columns, InvalidColumns, MOST_COLUMNS, Side, Term};
use model_core::eq18::Gate;
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::payload::Noise;
use model_core::slip::SlipMemory;
use model_core::torque::{Drive, PARAMETERS, TorqueModel};
use proptest::prelude::*;

type Two = Coefficients<f64, 2>;

fn bytes() -> Vec<u8> {
    coefficients().encode().unwrap().as_bytes().to_vec()
}

/// The image with other bytes and the checksum that belongs to them.
fn forged(change: impl FnOnce(&mut [u8])) -> Vec<u8> {
    let mut bytes = bytes();
    change(&mut bytes);
    let body = bytes.len() - 4;
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes[..body]);
    bytes[body..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

fn with_number(offset: usize, value: f32) -> Vec<u8> {
    forged(|bytes| bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes()))
}

/// Numbers that single precision holds.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0_f32), 1e-20..1e9_f32, 1e-3..1e3_f32]
}

fn model() -> impl Strategy<Value = Model<f32>> {
    let beta = || proptest::array::uniform15(number());
    let torque = || proptest::array::uniform::<_, PARAMETERS>(number()).prop_map(TorqueModel::from_array);
    prop_oneof![
        beta().prop_map(|beta| Model::Eq18 { gate: Gate::Published, beta }),
        beta().prop_map(|beta| Model::Eq18 { gate: Gate::Corrected, beta }),
        torque().prop_map(|torque| Model::Signed { torque, drive: Drive::Dissipative }),
        torque().prop_map(|torque| Model::Signed { torque, drive: Drive::Regenerative }),
    ]
}

fn any_coefficients<const N: usize>() -> impl Strategy<Value = Coefficients<f32, N>> {
    let rows = proptest::array::uniform3(proptest::array::uniform::<_, N>(-2.0..2.0_f32));
    let robot = (
        ".{0,30}",
        rows,
        0.01..2.0_f32,
        0.0..0.1_f32,
        0.1..50.0_f32,
        0.1..100.0_f32,
        0.1..100.0_f32,
        -9.0..99.0_f32,
    );
    let flags = (proptest::bool::ANY, proptest::bool::ANY);
    (robot, model(), [(); 4].map(|()| number()), flags).prop_map(
        |(
            (name, rows, gyration_radius, dead_band, cutoff_hz, empty, payload, static_power),
            model,
            [density, model_std, tail, residual_std],
            (identifies_mass, ground_adapts),
        )| {
            let kinematics = Kinematics::from_rows(rows).unwrap();
            Coefficients {
                robot: Robot {
                    name: Name::new(&name),
                    kinematics,
                    gyration_radius,
                    mass_matrix: kinematics.mass_matrix(gyration_radius).unwrap(),
                    dead_band,
                    cutoff_hz,
                    conditioning: Conditioning::PLAIN,
                    range: MassRange::new(empty, empty + payload).unwrap(),
                    static_power,
                },
                model,
                noise: Noise { density, model_std, tail, residual_std },
                columns: Columns::NONE,
                identifies_mass,
                ground_adapts: ground_adapts && matches!(model, Model::Signed { .. }),
            }
        },
    )
}

fn assert_round_trip<const N: usize>(single: &Coefficients<f32, N>) -> Result<(), TestCaseError> {
    let image = single.encode().unwrap();
    prop_assert!(image.as_bytes().len() <= LONGEST_IMAGE);
    prop_assert_eq!(image.as_bytes().len(), 140 + 12 * N);
    prop_assert_eq!(&Coefficients::decode(image.as_bytes()).unwrap(), single);
    // Flash after the image is erased, not part of it.
    let mut flash = image.as_bytes().to_vec();
    flash.extend([0xff; 100]);
    prop_assert_eq!(&Coefficients::decode(&flash).unwrap(), single);
    // In double precision the numbers are the same; M'' is computed from them and may be more
    // exact.
    let double = Coefficients::<f64, N>::decode(image.as_bytes()).unwrap();
    prop_assert_eq!(&double, &single.convert::<f64>().unwrap());
    prop_assert_eq!(&double.convert::<f32>().unwrap(), single);
    prop_assert_eq!(double.encode().unwrap(), image);
    Ok(())
}

proptest! {
    #[test]
    fn decode_of_encode_is_the_same(
        two in any_coefficients::<2>(), three in any_coefficients::<3>(), six in any_coefficients::<6>(),
    ) {
        assert_round_trip(&two)?;
        assert_round_trip(&three)?;
        assert_round_trip(&six)?;
    }

    #[test]
    fn any_bytes_are_no_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(Two::decode(&bytes).is_err());
    }

    /// With a true header and checksum around whatever else.
    #[test]
    fn any_fields_are_no_panic(fields in proptest::array::uniform::<_, 144>(any::<u8>())) {
        let bytes = forged(|bytes| bytes[8..152].copy_from_slice(&fields));
        if let Ok(decoded) = Two::decode(&bytes) {
            prop_assert!(decoded.model.is_sound());
        }
        let mut bytes = bytes;
        bytes[10] = 2;
        let bytes = forged(|forged| forged[8..152].copy_from_slice(&bytes[8..152]));
        if let Ok(decoded) = Two::decode(&bytes) {
            prop_assert!(decoded.model.is_sound() && decoded.robot.cutoff_hz > 0.0);
        }
    }

    /// A name is the longest part of it that fits and ends with a character.
    #[test]
    fn names_end_with_a_character(name in "[a-zäß€𝄞]{0,30}") {
        let kept = Name::new(&name).as_str().to_owned();
        prop_assert!(name.starts_with(&kept) && kept.len() <= NAME_BYTES);
        if let Some(next) = name[kept.len()..].chars().next() {
            prop_assert!(kept.len() + next.len_utf8() > NAME_BYTES);
        }
    }
}

#[test]
fn every_flipped_bit_is_noticed() {
    let good = bytes();
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(Two::decode(&bad).is_err(), "bit {bit}");
        // In flash, where the image's length may point past its end.
        bad.extend([0xff; 70_000]);
        assert!(Two::decode(&bad).is_err(), "bit {bit} in flash");
    }
}

#[test]
fn every_truncation_is_noticed() {
    let good = bytes();
    for length in 0..good.len() {
        assert_eq!(Two::decode(&good[..length]), Err(DecodeError::Truncated), "{length}");
        // Cut in flash: zeros or ones after it.
        for fill in [0x00, 0xff] {
            let mut cut = good[..length].to_vec();
            cut.resize(good.len(), fill);
            assert!(cut == good || Two::decode(&cut).is_err(), "{length} {fill}");
        }
    }
    assert!(Two::decode(&good).is_ok());
}

#[test]
fn what_is_wrong_is_named() {
    assert_eq!(Two::decode(b"GMRX and more"), Err(DecodeError::NotAnImage));
    assert_eq!(Two::decode(&forged(|b| b[4] = 9)), Err(DecodeError::Version { version: 9 }));
    assert_ne!(VERSION, 9);
    assert_eq!(Two::decode(&forged(|b| b[8] = 7)), Err(DecodeError::UnknownModel { id: 7 }));
    assert_eq!(Two::decode(&forged(|b| b[9] = 2)), Err(DecodeError::Field("drive")));
    assert_eq!(Two::decode(&forged(|b| b[10] = 5)), Err(DecodeError::WheelCount { count: 5 }));
    assert_eq!(Coefficients::<f64, 4>::decode(&bytes()), Err(DecodeError::WheelCount { count: 2 }));
    let mut bad = bytes();
    bad[60] ^= 0x10;
    assert_eq!(Two::decode(&bad), Err(DecodeError::Checksum));
}

#[test]
fn impossible_numbers_are_refused() {
    let fields: [(usize, &str, &[f32]); 11] = [
        (36, "gyration_radius_m", &[0.0, -1.0]),
        (40, "speed_dead_band_rad_s", &[-1.0]),
        (44, "filter_cutoff_hz", &[0.0, -1.0]),
        (48, "mass_no_load_kg", &[0.0, -1.0, 100.0]),
        (52, "mass_full_load_kg", &[]),
        (56, "static_power_w", &[]),
        (60, "noise", &[-1.0]),
        (64, "noise", &[-1.0]),
        (68, "noise", &[-1.0]),
        (72, "noise", &[-1.0]),
        (136, "kinematics", &[]),
    ];
    for (offset, name, values) in fields {
        for value in values.iter().chain(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY]) {
            let decoded = Two::decode(&with_number(offset, *value));
            assert_eq!(decoded, Err(DecodeError::Field(name)), "{value} at {offset}");
        }
    }
    for coefficient in 0..PARAMETERS {
        for value in [-1e-6, f32::NAN, f32::INFINITY] {
            let decoded = Two::decode(&with_number(76 + 4 * coefficient, value));
            assert_eq!(
                decoded,
                Err(DecodeError::Field("coefficients")),
                "{value} as coefficient {coefficient}"
            );
        }
    }
    for flags in [16, 32, 0xf0] {
        assert_eq!(Two::decode(&forged(|b| b[11] = flags)), Err(DecodeError::Field("kinematics")), "{flags}");
    }
    // A usual residual is said to be there.
    assert_eq!(Two::decode(&forged(|b| b[11] |= 8)), Err(DecodeError::Field("noise")));
    let no_wheels = forged(|bytes| bytes[136..160].fill(0));
    assert_eq!(Two::decode(&no_wheels), Err(DecodeError::Field("kinematics")));
}

/// Images from before told a weight in the place of the usual residual.
#[test]
fn a_usual_residual_needs_its_flag() {
    let residual = |bytes: &[u8]| Two::decode(bytes).unwrap().noise.residual_std;
    assert_eq!(residual(&with_number(68, 0.25)), 0.0);
    let noise = Noise { residual_std: 0.25, ..coefficients().noise };
    assert_eq!(residual(Two { noise, ..coefficients() }.encode().unwrap().as_bytes()), 0.25);
}

/// What is not finite in single precision, or not allowed, does not survive the round trip as
/// something else.
#[test]
fn what_no_board_could_run_does_not_come_back() {
    let with = |torque| Two { model: Model::Signed { torque, drive: Drive::Dissipative }, ..coefficients() };
    for value in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
        let image = with(TorqueModel { viscous: value, ..servo() }).encode().unwrap();
        assert_eq!(Two::decode(image.as_bytes()), Err(DecodeError::Field("coefficients")), "{value}");
    }
    let ungated = Two { model: Model::Eq18 { gate: Gate::Signed, beta: servo().expand() }, ..coefficients() };
    assert_eq!(ungated.encode(), None);
    let kinematics = Kinematics::<f64, 7>::from_rows([[1.0; 7]; 3]).unwrap();
    let two = coefficients();
    let seven = Coefficients {
        robot: Robot {
            name: two.robot.name,
            kinematics,
            gyration_radius: 1.0,
            mass_matrix: kinematics.mass_matrix(1.0).unwrap(),
            dead_band: 0.0,
            cutoff_hz: 1.0,
            conditioning: Conditioning::PLAIN,
            range: two.robot.range,
            static_power: 0.0,
        },
        model: two.model,
        noise: two.noise,
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    };
    assert_eq!(seven.encode(), None);
}

#[test]
fn names_that_are_no_text_are_empty() {
    let decoded = Two::decode(&forged(|bytes| bytes[12..36].fill(0xff))).unwrap();
    assert_eq!(decoded.robot.name.as_str(), "");
    assert_eq!(Name::new("Burger").as_str(), "Burger");
    assert_eq!(Name::new("").as_str(), "");
    // 23 bytes and a character of two.
    assert_eq!(Name::new("abcdefghijklmnopqrstuvwä").as_str(), "abcdefghijklmnopqrstuvw");
}

/// One of each kind.
fn causes() -> Vec<Cause<f32>> {
    let terms = [
        Term::GradeByPitch,
        Term::GradeAhead,
        Term::GradeAlong([1.0, 0.0]),
        Term::GradeAlong([0.0, 1.0]),
        Term::Windage,
        Term::Stribeck(0.25),
        Term::Viscous,
        Term::WarmUp(60.0),
        Term::Rolling,
        Term::RollingFrom(12.5),
        Term::Offset,
        Term::Drag(1),
        Term::Scrub,
        Term::ScrubPerKg,
        Term::Sliding(0.5),
        Term::OffCentre(1.0),
        Term::GearLoad,
        Term::GearShare,
        Term::Sag(0.0),
        Term::Return,
        Term::Gain(0.0),
        Term::Constant,
        Term::StepAt(0.0),
        Term::WithMotion(1.5),
        Term::WithMotion(f32::INFINITY),
        Term::Driver,
    ];
    let warm = [Cause::Hot, Cause::Heat(90.0), Cause::Warming(40.0), Cause::Temperature(-5.0)];
    let others = [Cause::Delay, Cause::HalfSlip];
    let sides = [Side::Both, Side::Left, Side::Right].map(Cause::Scale);
    terms.into_iter().map(Cause::Term).chain(warm).chain(others).chain(sides).collect()
}

fn with_columns<const N: usize>(columns: &[Column<f32>]) -> Coefficients<f32, N> {
    let two: Coefficients<f32, 2> = coefficients().convert().unwrap();
    let kinematics = Kinematics::from_rows([[0.01; N], [0.0; N], [0.2; N]]).unwrap();
    let robot = Robot {
        name: two.robot.name,
        kinematics,
        gyration_radius: two.robot.gyration_radius,
        mass_matrix: kinematics.mass_matrix(two.robot.gyration_radius).unwrap(),
        dead_band: two.robot.dead_band,
        cutoff_hz: two.robot.cutoff_hz,
        conditioning: Conditioning::PLAIN,
        range: two.robot.range,
        static_power: two.robot.static_power,
    };
    let columns = Columns::new(columns, N).unwrap();
    Coefficients {
        robot,
        model: two.model,
        noise: two.noise,
        columns,
        identifies_mass: true,
        ground_adapts: false,
    }
}

fn columns_of(causes: &[Cause<f32>]) -> Vec<Column<f32>> {
    causes.iter().map(|cause| Column { cause: *cause, coefficient: 0.25 }).collect()
}

#[test]
fn every_effect_comes_back() {
    for cause in causes() {
        let single = with_columns::<2>(&columns_of(&[cause]));
        let image = single.encode().unwrap();
        assert_eq!(image.as_bytes()[4], 2);
        assert_eq!(image.as_bytes().len(), 140 + 24 + 4 + 10, "{cause:?}");
        assert_eq!(Coefficients::decode(image.as_bytes()).unwrap(), single, "{cause:?}");
        let double = Coefficients::<f64, 2>::decode(image.as_bytes()).unwrap();
        assert_eq!(double, single.convert::<f64>().unwrap());
        assert_eq!(double.encode().unwrap(), image);
    }
    // Ids are for good: what was flashed keeps its meaning.
    let ids: Vec<u8> = causes()
        .into_iter()
        .map(|cause| with_columns::<2>(&columns_of(&[cause])).encode().unwrap().as_bytes()[164])
        .collect();
    let expected = [
        1, 2, 3, 3, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 28, 30, 17, 27, 18, 19, 20, 21, 22, 23, 23, 24, 4,
        5, 31, 6, 25, 29, 26, 26, 26,
    ];
    assert_eq!(ids, expected);
}

/// The board's upload window has 256 bytes: all columns fit with all wheels.
#[test]
fn the_longest_image_fits_the_upload_window() {
    let four =
        columns_of(&[Cause::Hot, Cause::Delay, Cause::Term(Term::Sag(0.0)), Cause::Term(Term::StepAt(7.5))]);
    assert_eq!(four.len(), MOST_COLUMNS);
    let six = with_columns::<6>(&four);
    let image = six.encode().unwrap();
    assert_eq!(image.as_bytes().len(), LONGEST_IMAGE);
    assert_eq!(LONGEST_IMAGE, 256);
    assert_eq!(Coefficients::decode(image.as_bytes()).unwrap(), six);
}

fn with_traits(columns: &[Column<f32>]) -> Coefficients<f32, 2> {
    let base = with_columns::<2>(columns);
    let Model::Signed { torque, drive } = base.model else { panic!("signed") };
    let slip = SlipMemory { half_slip: 0.126, relaxation: 1.79, rest: 0.03 };
    Coefficients {
        robot: Robot {
            conditioning: Conditioning { slip, delay: -0.25, ..Conditioning::PLAIN },
            ..base.robot
        },
        model: Model::Signed {
            torque: TorqueModel {
                imbalance: -0.02,
                gear_loss: 0.09,
                bridge_drop: 0.2,
                wheel_friction_share: 1.0,
                ..torque
            },
            drive,
        },
        ..base
    }
}

/// Sides, gear, bridge, slip memory and delay come back one by one and together, with effects and without;
/// images without them stay what they were.
#[test]
fn every_trait_comes_back() {
    let all = with_traits(&[]);
    let with = |slip, delay, has_traits| {
        let Model::Signed { torque, drive } = all.model else { panic!("signed") };
        let torque = if has_traits { torque } else { TorqueModel::from_array(torque.to_array()) };
        Coefficients {
            robot: Robot { conditioning: Conditioning { slip, delay, ..Conditioning::PLAIN }, ..all.robot },
            model: Model::Signed { torque, drive },
            ..all
        }
    };
    let slip = |half_slip, relaxation| SlipMemory { half_slip, relaxation, ..SlipMemory::OFF };
    let losing = |gear_loss, bridge_drop| {
        let plain = with(SlipMemory::OFF, 0.0, false);
        let Model::Signed { torque, drive } = plain.model else { panic!("signed") };
        Coefficients {
            model: Model::Signed { torque: TorqueModel { gear_loss, bridge_drop, ..torque }, drive },
            ..plain
        }
    };
    let through = |gear_loss, wheel_friction_share| {
        let losing = losing(gear_loss, 0.0);
        let Model::Signed { torque, drive } = losing.model else { panic!("signed") };
        let torque = TorqueModel { wheel_friction_share, ..torque };
        Coefficients { model: Model::Signed { torque, drive }, ..losing }
    };
    for single in [
        with(SlipMemory::OFF, 0.0, true),
        with(slip(0.5, 0.0), 0.0, false),
        with(slip(0.0, 2.0), 0.0, false),
        with(SlipMemory::OFF, 0.3, false),
        with(SlipMemory { rest: 0.1, ..slip(0.5, 0.0) }, 0.0, false),
        losing(0.25, 0.0),
        losing(0.0, 0.14),
        through(0.25, 1.0),
        through(0.25, 0.5),
        all,
        with_traits(&columns_of(&[Cause::Hot, Cause::Delay])),
    ] {
        let image = single.encode().unwrap();
        assert_eq!(image.as_bytes()[4], 3);
        assert_eq!(image.as_bytes().len(), 140 + 24 + 4 + 10 * single.columns.len());
        assert_eq!(Coefficients::decode(image.as_bytes()).unwrap(), single);
        let double = Coefficients::<f64, 2>::decode(image.as_bytes()).unwrap();
        assert_eq!(double, single.convert::<f64>().unwrap());
        assert_eq!(double.encode().unwrap(), image);
    }
    assert_eq!(with(SlipMemory::OFF, 0.0, false).encode().unwrap().as_bytes()[4], 1);
    // Friction passes no gear that has no loss: it makes no difference.
    let lossless = through(0.0, 1.0).encode().unwrap();
    assert_eq!(Coefficients::decode(lossless.as_bytes()).unwrap(), with(SlipMemory::OFF, 0.0, false));
    // A gear that takes all of its load, or gives some beside, is none; a bridge that gives is none.
    for none in [losing(1.0, 0.0), losing(-0.1, 0.0), losing(0.0, -0.1), through(0.2, 1.1)] {
        let image = none.encode().unwrap();
        assert_eq!(Coefficients::<f32, 2>::decode(image.as_bytes()), Err(DecodeError::Field("coefficients")));
    }
    // Less than single precision holds is nothing.
    let Model::Signed { torque, drive } = coefficients().model else { panic!("signed") };
    let tiny = Model::Signed { torque: TorqueModel { imbalance: 1e-60, ..torque }, drive };
    assert_eq!(Two { model: tiny, ..coefficients() }.encode().unwrap().as_bytes(), bytes());
    // The paper's models have no room for them.
    let beta = Model::Eq18 { gate: Gate::Corrected, beta: [0.1; 15] };
    assert_eq!(Coefficients { model: beta, ..all }.encode(), None);
}

#[test]
fn traits_that_are_wrong_are_named() {
    let good = with_traits(&columns_of(&[Cause::Delay])).encode().unwrap().as_bytes().to_vec();
    let forged = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        let body = bytes.len() - 4;
        let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes[..body]);
        bytes[body..].copy_from_slice(&checksum.to_le_bytes());
        Two::decode(&bytes)
    };
    assert!(forged(&|_| ()).is_ok());
    let wrong = Err(DecodeError::Field("coefficients"));
    let put =
        |offset: usize, value: f32| forged(&|b| b[offset..offset + 4].copy_from_slice(&value.to_le_bytes()));
    for offset in (104..136).step_by(4) {
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(put(offset, value), wrong, "{value} at {offset}");
        }
    }
    // Slip and relaxation are not negative; no more friction passes the gear than there is, and
    // without its loss none; traits that are none are no traits.
    for offset in [108, 112, 120, 124, 128, 132] {
        assert_eq!(put(offset, -0.5), wrong, "{offset}");
    }
    assert!(put(104, -0.5).is_ok() && put(116, 0.5).is_ok() && put(132, 0.5).is_ok());
    assert_eq!((put(132, 1.5), put(120, 0.0)), (wrong, wrong));
    assert_eq!(forged(&|b| b[104..136].fill(0)), wrong);
    // Older versions say nothing there.
    let plain = bytes();
    let read = forged(&|b| b[4] = 2).unwrap();
    assert_eq!(read.robot.conditioning, Conditioning::PLAIN);
    assert!(Two::decode(&plain).unwrap().robot.conditioning == Conditioning::PLAIN);
    // Of the paper's models they would be coefficients.
    assert_eq!(forged(&|b| b[8] = 1), wrong);
    for count in [0, 2] {
        assert_eq!(forged(&|b| b[160] = count), Err(DecodeError::Truncated));
    }
    assert_eq!(forged(&|b| b[160] = 5), Err(DecodeError::Field("effects")));
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(Two::decode(&bad).is_err(), "bit {bit}");
    }
    for length in 0..good.len() {
        assert!(Two::decode(&good[..length]).is_err(), "{length}");
    }
}

/// Robots in the field have images of the first version: without effects nothing else is written.
#[test]
fn without_effects_the_image_is_what_it_was() {
    assert_eq!(bytes()[4], VERSION as u8);
    assert_ne!(VERSION, VERSION_WITH_EFFECTS);
    assert!(Two::decode(&bytes()).unwrap().columns.is_empty());
}

#[test]
fn effects_that_are_wrong_are_named() {
    let column = |cause, coefficient| Column { cause, coefficient };
    let good =
        with_columns::<2>(&[column(Cause::Term(Term::Stribeck(0.25)), 0.1), column(Cause::Delay, 0.02)]);
    let good = good.encode().unwrap().as_bytes().to_vec();
    let forged = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        let body = bytes.len() - 4;
        let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes[..body]);
        bytes[body..].copy_from_slice(&checksum.to_le_bytes());
        Two::decode(&bytes)
    };
    // Columns begin at 136 + 24: their number, three zeros, then ten bytes each.
    assert!(forged(&|_| ()).is_ok());
    assert_eq!(forged(&|b| b[164] = 77), Err(DecodeError::UnknownEffect { id: 77 }));
    assert_eq!(forged(&|b| b[165] = 1), Err(DecodeError::UnknownEffect { id: 8 }));
    for count in [0, 5, 255] {
        assert_eq!(forged(&|b| b[160] = count), Err(DecodeError::Field("effects")));
    }
    assert_eq!(forged(&|b| b[161] = 1), Err(DecodeError::Field("effects")));
    assert_eq!(forged(&|b| b[160] = 1), Err(DecodeError::Truncated));
    assert_eq!(forged(&|b| b[160] = 3), Err(DecodeError::Truncated));
    for value in [f32::NAN, f32::INFINITY] {
        for offset in [166, 170, 176, 180] {
            let put = |b: &mut Vec<u8>| b[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
            assert_eq!(forged(&put), Err(DecodeError::Field("effects")), "{offset}");
        }
    }
    // A width of nothing, and the same column twice.
    assert_eq!(forged(&|b| b[170..174].fill(0)), Err(DecodeError::Field("effects")));
    assert_eq!(forged(&|b| b[164] = 25), Err(DecodeError::Field("effects")));
    // Effects act on torques: the paper's models have none.
    assert_eq!(forged(&|b| b[8] = 1), Err(DecodeError::Field("effects")));
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(Two::decode(&bad).is_err(), "bit {bit}");
    }
    for length in 0..good.len() {
        assert!(Two::decode(&good[..length]).is_err(), "{length}");
    }
}

#[test]
fn columns_that_mean_nothing_are_none() {
    let refused = |cause: Cause<f64>, coefficient| Columns::new(&[Column { cause, coefficient }], 2).err();
    let value = Some(InvalidColumns::Value(0));
    for cause in causes().iter().map(Cause::convert::<f64>) {
        assert_eq!(refused(cause, 0.1), None, "{cause:?}");
        assert_eq!(refused(cause, f64::NAN), value, "{cause:?}");
    }
    for (cause, coefficient) in [
        (Cause::Term(Term::Sag(0.0)), -0.1),
        (Cause::Term(Term::GearLoad), -0.1),
        (Cause::Term(Term::Gain(0.0)), -1.0),
        (Cause::Term(Term::Return), 1.1),
        (Cause::Term(Term::Drag(2)), 0.1),
        (Cause::Term(Term::Winding), 0.1),
        (Cause::Term(Term::GradeAlong([0.6, 0.8])), 0.1),
        (Cause::Term(Term::WarmUp(0.0)), 0.1),
        (Cause::Term(Term::StepAt(-1.0)), 0.1),
        (Cause::Heat(-3.0), 0.1),
        (Cause::Warming(0.0), 0.1),
        (Cause::Hot, -0.1),
        (Cause::Scale(Side::Left), -1.0),
        (Cause::HalfSlip, -1.0),
        (Cause::Term(Term::OffCentre(0.0)), -0.1),
    ] {
        assert_eq!(refused(cause, coefficient), value, "{cause:?}");
    }
    let one = Column { cause: Cause::Term(Term::Drag(0)), coefficient: 0.1 };
    let other = Column { cause: Cause::Term(Term::Drag(1)), coefficient: 0.1 };
    assert!(Columns::new(&[one, other], 2).is_ok());
    assert_eq!(Columns::new(&[one, other, one], 2), Err(InvalidColumns::Twice(2)));
    assert_eq!(Columns::new(&[one; 5], 2), Err(InvalidColumns::TooMany));
}

/// An effect is as absurd as the power that it makes.
#[test]
fn absurd_effects_are_not_plausible() {
    for cause in causes() {
        let of = |coefficient| {
            let columns = Columns::new(&[Column { cause, coefficient }], 2).unwrap();
            let robot = Coefficients::<f32, 2> { columns, ..coefficients().convert().unwrap() };
            robot.is_plausible()
        };
        assert!(of(0.01), "{cause:?}");
        let is_share =
            matches!(cause, Cause::Term(Term::Return) | Cause::Delay | Cause::Scale(_) | Cause::HalfSlip);
        assert!(is_share || !of(1e30), "{cause:?}");
    }
}

/// Ground adapts by the signed model without effects; anything else is no image, and bytes that say
/// so are none.
#[test]
fn ground_adapts_with_the_signed_model_alone() {
    let plain: Coefficients<f32, 2> = coefficients().convert().unwrap();
    let adapting = Coefficients { ground_adapts: true, ..plain };
    let image = adapting.encode().unwrap();
    assert_eq!(Coefficients::<f32, 2>::decode(image.as_bytes()).unwrap(), adapting);
    let extended = with_columns::<2>(&[Column { cause: Cause::Delay, coefficient: 0.1 }]);
    assert!(Coefficients { ground_adapts: true, ..extended }.encode().is_none());
    let mut bytes = extended.encode().unwrap().as_bytes().to_vec();
    bytes[11] |= 4;
    let body = bytes.len() - 4;
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&bytes[..body]);
    bytes[body..].copy_from_slice(&checksum.to_le_bytes());
    assert_eq!(Two::decode(&bytes), Err(DecodeError::Field("ground")));
}
