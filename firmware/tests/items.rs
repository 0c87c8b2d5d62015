//! The images of calibration, robot and coefficients: what comes back, and why what is wrong is
//! refused.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{SAMPLE_RATE_HZ, burger, image, sealed, with_number};
use firmware::control_table::Reason;
use firmware::items::{CALIBRATION_BYTES, Calibration, ROBOT_BYTES, RobotIdentity, check_coefficients};
use model_core::coefficients::{Coefficients, Name};
use model_core::conditioning::Conditioning;
use model_core::effects::{Cause, Column, Columns, Side, Term};
use model_core::eq18::Gate;
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::plausibility::LEAST_CUTOFF;
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

fn check(image: &[u8]) -> Result<Coefficients<f32, 2>, Reason> {
    check_coefficients(image, &RobotIdentity::BURGER, SAMPLE_RATE_HZ)
}

fn refusal(coefficients: &Coefficients<f32, 2>) -> Option<Reason> {
    check(&image(coefficients)).err()
}

fn with_torque(values: [f32; 7]) -> Coefficients<f32, 2> {
    let model = Model::Signed { torque: TorqueModel::from_array(values), drive: Drive::Dissipative };
    Coefficients { model, ..burger() }
}

#[test]
fn good_coefficients_of_every_model_come_back() {
    for model in [
        burger().model,
        Model::Eq18 { gate: Gate::Published, beta: [0.01; 15] },
        Model::Eq18 { gate: Gate::Corrected, beta: [0.01; 15] },
    ] {
        let coefficients = Coefficients { model, ..burger() };
        assert_eq!(check(&image(&coefficients)), Ok(coefficients));
    }
}

/// Lengths that the host rounded from double precision: a few units in the last place are the same
/// robot, 10⁻⁵ is another.
#[test]
fn the_same_robot_is_the_same_up_to_rounding() {
    let good = image(&burger());
    // Gyration radius, and the first row's and the last row's first entries.
    for offset in [36, 136, 152] {
        let value = f32::from_le_bytes(good[offset..offset + 4].try_into().unwrap());
        for (factor, expected) in [
            (1.0 + 5e-7, None),
            (1.0 - 5e-7, None),
            (1.0 + 1e-5, Some(Reason::Robot)),
            (1.0 - 1e-5, Some(Reason::Robot)),
            (-1.0, Some(if offset == 36 { Reason::Value } else { Reason::Robot })),
        ] {
            let refusal = check(&with_number(&good, offset, value * factor)).err();
            assert_eq!(refusal, expected, "{offset} × {factor}");
        }
    }
    // Sideways, where the other is 0.
    assert_eq!(check(&with_number(&good, 144, 1e-20)).err(), Some(Reason::Robot));
    let mut other = burger();
    other.robot.name = Name::new("TurtleBot3 burger");
    assert_eq!(refusal(&other), Some(Reason::Robot));
}

/// All 15 and 7 coefficients, and everything else that is a number.
#[test]
fn what_is_no_number_is_refused() {
    let mut published = burger();
    published.model = Model::Eq18 { gate: Gate::Published, beta: [0.01; 15] };
    for good in [image(&burger()), image(&published)] {
        for offset in (36..160).step_by(4) {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                assert_eq!(check(&with_number(&good, offset, value)).err(), Some(Reason::Value), "{offset}");
            }
        }
    }
}

#[test]
fn negative_coefficients_are_refused() {
    let good = image(&burger());
    // Gyration radius, dead band, cutoff, masses; noise and the seven parameters.
    for offset in (36..56).chain(60..104).step_by(4) {
        assert_eq!(check(&with_number(&good, offset, -0.5)).err(), Some(Reason::Value), "{offset}");
    }
}

/// 10³⁸ squared is beyond single precision, and the power is asked for where all torques add.
#[test]
fn what_no_robot_has_is_refused() {
    let good = burger();
    let torque = [0.04, 0.012, 0.006, 0.0081, 1.33, 6.5, 0.0];
    for parameter in 0..6 {
        let mut values = torque;
        values[parameter] = 1e38;
        assert_eq!(refusal(&with_torque(values)), Some(Reason::Value), "parameter {parameter}");
    }
    for regressor in 0..15 {
        let mut beta = [0.01; 15];
        beta[regressor] = 1e38;
        for gate in [Gate::Published, Gate::Corrected] {
            let coefficients = Coefficients { model: Model::Eq18 { gate, beta }, ..good };
            assert_eq!(refusal(&coefficients), Some(Reason::Value), "{gate:?} {regressor}");
        }
    }
    // Both wheels at 10 rad/s and 6 kg, all torques Coulomb's: 2 (10 τ + 6.5 τ²) is 100 kW at
    // τ = 86.95 N·m.
    let coulomb = |torque| Coefficients {
        identifies_mass: false,
        ..with_torque([torque, 0.0, 0.0, 0.0, 0.0, 6.5, 0.0])
    };
    assert_eq!(refusal(&coulomb(86.9)), None);
    assert_eq!(refusal(&coulomb(87.0)), Some(Reason::Value));
    // The same torque from rolling under 6 kg.
    assert_eq!(refusal(&with_torque([0.0, 14.48, 0.0, 0.0, 0.0, 6.5, 0.0])), None);
    assert_eq!(refusal(&with_torque([0.0, 14.5, 0.0, 0.0, 0.0, 6.5, 0.0])), Some(Reason::Value));

    let bytes = image(&good);
    for (what, offset, value) in [
        ("dead band of 1 rad/s", 40, 1.0),
        ("no load of 0 kg", 48, 0.0),
        ("no load of half a gram", 48, 5e-4),
        ("mass range of zero", 48, 6.0),
        ("no load above full load", 48, 7.0),
        ("static power of 1e6 W", 56, 1e6),
        ("static power of −1e38 W", 56, -1e38),
        ("negative static power", 56, -1.0),
        ("a payload of a gram", 48, 5.999),
        ("noise density", 60, 1e38),
        ("lasting error", 64, 1e38),
        ("tail", 72, 1e38),
    ] {
        assert_eq!(check(&with_number(&bytes, offset, value)).err(), Some(Reason::Value), "{what}");
    }
    assert_eq!(check(&with_number(&bytes, 48, 5e-3)).err(), None);
    // Where power does not depend on the mass, and nobody says that it does, only the bound itself
    // refuses.
    let massless = with_torque([0.04, 0.0, 0.006, 0.0081, 0.0, 6.5, 0.0]);
    let bytes = image(&Coefficients { identifies_mass: false, ..massless });
    assert_eq!(check(&with_number(&bytes, 52, 100_000.0)).err(), None);
    assert_eq!(check(&with_number(&bytes, 52, 100_001.0)).err(), Some(Reason::Value));
}

/// The mass would be unknown for ever, and the reason on display the drive: without what tells
/// masses apart, and with noise that hides them. With coefficients that say so the reason is true,
/// and the board takes them.
#[test]
fn a_mass_that_cannot_be_known_is_refused() {
    let good = image(&burger());
    let massless = with_torque([0.04, 0.0, 0.006, 0.0081, 0.0, 6.5, 0.0]);
    let eq18 = Coefficients { model: Model::Eq18 { gate: Gate::Corrected, beta: [0.0; 15] }, ..burger() };
    for (what, bytes) in [
        ("no mass in the torque", image(&massless)),
        ("no mass in Eq. 18", image(&eq18)),
        ("noise density", with_number(&good, 60, 1e6)),
        ("lasting error", with_number(&good, 64, 1e4)),
    ] {
        assert_eq!(check(&bytes).err(), Some(Reason::Mass), "{what}");
        let mut honest = bytes;
        honest[11] |= 2;
        assert_eq!(check(&sealed(honest)).err(), None, "{what}");
    }
    // Ground that adapts divides by the density; the plain estimator has the scatter that it sees.
    let mut adapting = with_number(&good, 60, 0.0);
    assert_eq!(check(&adapting).err(), None);
    adapting[11] |= 4;
    assert_eq!(check(&sealed(adapting)).err(), Some(Reason::Value));
}

/// Sensors that show a tenth, or ten times what they measure, and no more.
#[test]
fn a_sensor_that_shows_next_to_nothing_is_refused() {
    for cause in [Cause::Scale(Side::Left), Cause::Scale(Side::Both), Cause::Term(Term::Gain(0.0))] {
        for (coefficient, expected) in
            [(-0.89, None), (-0.91, Some(Reason::Value)), (8.9, None), (9.1, Some(Reason::Value))]
        {
            let columns = Columns::new(&[Column { cause, coefficient }], 2).unwrap();
            assert_eq!(refusal(&Coefficients { columns, ..burger() }), expected, "{cause:?} {coefficient}");
        }
    }
}

/// A filter needs two periods of its cutoff behind a start or a gap, and single precision.
#[test]
fn a_filter_that_no_robot_has_is_refused() {
    let good = image(&burger());
    for (cutoff, expected) in
        [(0.1, None), (0.099, Some(Reason::Slow)), (0.001, Some(Reason::Slow)), (1e-30, Some(Reason::Slow))]
    {
        assert_eq!(check(&with_number(&good, 44, cutoff)).err(), expected, "{cutoff} Hz");
    }
    assert!(Reason::Slow.text().contains(&LEAST_CUTOFF.to_string()));
}

/// 0.45 of the sample rate is where the filter ends.
#[test]
fn the_sample_rate_bounds_the_cutoff() {
    let good = image(&burger());
    for (cutoff, rate, expected) in [
        (89.9, 200, None),
        (90.1, 200, Some(Reason::Cutoff)),
        (1e6, 200, Some(Reason::Cutoff)),
        (2.0, 4, Some(Reason::Cutoff)),
        (2.0, 0, Some(Reason::Cutoff)),
        (0.0, 200, Some(Reason::Value)),
    ] {
        let image = with_number(&good, 44, cutoff);
        let refusal = check_coefficients(&image, &RobotIdentity::BURGER, rate).err();
        assert_eq!(refusal, expected, "{cutoff} Hz at {rate} Hz");
    }
}

#[test]
fn other_kinds_of_image_are_refused() {
    let good = image(&burger());
    let with_byte = |at: usize, byte: u8| {
        let mut image = good.clone();
        image[at] = byte;
        check(&sealed(image)).err()
    };
    assert_eq!(with_byte(0, b'X'), Some(Reason::NotAnImage));
    // 2 is with effects: here the checksum stands where their number should. 3 is with traits: here
    // are none.
    assert_eq!(with_byte(4, 2), Some(Reason::Value));
    assert_eq!(with_byte(4, 3), Some(Reason::Value));
    assert_eq!(with_byte(4, 4), Some(Reason::Version));
    assert_eq!(with_byte(5, 1), Some(Reason::Version));
    assert_eq!(with_byte(8, 3), Some(Reason::Model));
    assert_eq!(with_byte(9, 2), Some(Reason::Value));
    assert_eq!(with_byte(10, 3), Some(Reason::Wheels));
    let three = Kinematics::omni(0.033, 0.1).unwrap();
    let robot = model_core::coefficients::Robot {
        name: burger().robot.name,
        kinematics: three,
        gyration_radius: 0.064,
        mass_matrix: three.mass_matrix(0.064).unwrap(),
        dead_band: 0.02,
        cutoff_hz: 2.0,
        conditioning: Conditioning::PLAIN,
        range: MassRange::new(1.0, 6.0).unwrap(),
        static_power: 0.0,
    };
    let three = Coefficients {
        robot,
        model: burger().model,
        noise: burger().noise,
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    };
    assert_eq!(check(three.encode().unwrap().as_bytes()).err(), Some(Reason::Wheels));
    // Other items are none either.
    assert_eq!(check(&Calibration::default().encode()).err(), Some(Reason::NotAnImage));
    assert_eq!(Calibration::decode(&good), Err(Reason::NotAnImage));
    assert_eq!(RobotIdentity::decode(&good), Err(Reason::NotAnImage));
}

/// 28 and 68 bytes, laid out as their documentation says.
#[test]
fn layouts() {
    let calibration = Calibration { power_factors: [1.002, 0.998, 0.5, 2.0] }.encode();
    assert_eq!(calibration[..8], *b"GMRK\x01\x00\x1C\x00");
    assert_eq!(calibration[8..12], 1.002_f32.to_le_bytes());
    assert_eq!(calibration[20..24], 2.0_f32.to_le_bytes());
    assert_eq!((calibration.len(), CALIBRATION_BYTES), (28, 28));

    let robot = RobotIdentity::BURGER.encode();
    assert_eq!(robot[..12], *b"GMRR\x01\x00\x44\x00\x02\x00\x00\x00");
    assert_eq!(robot[12..36], *b"TurtleBot3 Burger\0\0\0\0\0\0\0");
    assert_eq!(robot[36..40], 0.064_f32.to_le_bytes());
    let rows: Vec<f32> = robot[40..64].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    assert_eq!(rows, [0.0165, 0.0165, 0.0, 0.0, -0.20625, 0.20625]);
    assert_eq!((robot.len(), ROBOT_BYTES), (68, 68));
}

/// The CRC-32 of zlib over the bytes before, from Python: `zlib.crc32`.
#[test]
fn checksum_of_another_program() {
    let calibration = Calibration::default().encode();
    assert_eq!(u32::from_le_bytes(calibration[24..].try_into().unwrap()), CALIBRATION_CRC);
}

/// `zlib.crc32(struct.pack("<4sHH4f", b"GMRK", 1, 28, 1, 1, 1, 1))`
const CALIBRATION_CRC: u32 = 0x9E53_3186;

#[test]
fn calibrations_are_near_one() {
    for (value, is_plausible) in [
        (0.5, true),
        (2.0, true),
        (0.499, false),
        (2.001, false),
        (0.0, false),
        (-1.0, false),
        (f32::NAN, false),
        (f32::INFINITY, false),
    ] {
        for rail in 0..4 {
            let mut calibration = Calibration::default();
            calibration.power_factors[rail] = value;
            let expected = if is_plausible { Ok(calibration) } else { Err(Reason::Value) };
            assert_eq!(Calibration::decode(&calibration.encode()), expected, "{value}");
        }
    }
}

#[test]
fn robots_have_lengths_and_a_name() {
    let good = RobotIdentity::BURGER;
    assert_eq!(RobotIdentity::decode(&good.encode()), Ok(good));
    assert_eq!(RobotIdentity::default(), good);
    assert_eq!(RobotIdentity::of(&burger().robot), good);
    let bad = [
        RobotIdentity { name: Name::new(""), ..good },
        RobotIdentity { gyration_radius: 0.0, ..good },
        RobotIdentity { gyration_radius: -0.1, ..good },
        RobotIdentity { gyration_radius: f32::NAN, ..good },
        RobotIdentity { gyration_radius: 101.0, ..good },
        RobotIdentity { rows: [[0.0; 2]; 3], ..good },
        RobotIdentity { rows: [[0.1; 2], [f32::NAN, 0.0], [0.1; 2]], ..good },
        RobotIdentity { rows: [[0.1; 2], [0.0; 2], [f32::INFINITY, 0.1]], ..good },
        RobotIdentity { rows: [[101.0, 0.1], [0.0; 2], [0.1; 2]], ..good },
    ];
    for robot in bad {
        assert_eq!(RobotIdentity::decode(&robot.encode()), Err(Reason::Value), "{robot:?}");
    }
    let with_byte = |at: usize, byte: u8| {
        let mut image = good.encode().to_vec();
        image[at] = byte;
        RobotIdentity::decode(&sealed(image)).err()
    };
    assert_eq!(with_byte(4, 2), Some(Reason::Version));
    assert_eq!(with_byte(8, 3), Some(Reason::Wheels));
    assert_eq!(with_byte(9, 1), Some(Reason::Value));
    // No UTF-8, and something behind the end of the name.
    assert_eq!(with_byte(12, 0xFF), Some(Reason::Value));
    assert_eq!(with_byte(35, b'x'), Some(Reason::Value));
}

/// The right checksum over another number of bytes than the item has.
#[test]
fn items_of_another_length_are_refused() {
    let resized = |image: &[u8], length: usize| {
        let mut image = image.to_vec();
        image.resize(length, 0);
        image[6..8].copy_from_slice(&(length as u16).to_le_bytes());
        sealed(image)
    };
    for length in [24, 27, 29, 32] {
        let image = resized(&Calibration::default().encode(), length);
        assert_eq!(Calibration::decode(&image).err(), Some(Reason::Length), "{length}");
    }
    for length in [64, 67, 69, 72] {
        let image = resized(&RobotIdentity::BURGER.encode(), length);
        assert_eq!(RobotIdentity::decode(&image).err(), Some(Reason::Length), "{length}");
    }
    for length in [160, 163, 165, 168] {
        assert_eq!(check(&resized(&image(&burger()), length)).err(), Some(Reason::Length), "{length}");
    }
}

proptest! {
    #[test]
    fn any_calibration_and_robot_come_back(
        power_factors in proptest::array::uniform4(0.5..=2.0_f32),
        name in "\\PC{1,30}",
        gyration_radius in 1e-3..10.0_f32,
        rows in proptest::array::uniform3(proptest::array::uniform2(-2.0..2.0_f32)),
    ) {
        let calibration = Calibration { power_factors };
        prop_assert_eq!(Calibration::decode(&calibration.encode()), Ok(calibration));
        let robot = RobotIdentity { name: Name::new(&name), gyration_radius, rows };
        prop_assert_eq!(RobotIdentity::decode(&robot.encode()), Ok(robot));
    }

    #[test]
    fn any_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..256)) {
        prop_assert!(Calibration::decode(&bytes).is_err());
        prop_assert!(RobotIdentity::decode(&bytes).is_err());
        prop_assert!(check(&bytes).is_err());
    }

    /// Whatever the numbers, what is accepted gives a finite power that some robot has, and no
    /// panic.
    #[test]
    fn what_is_accepted_is_usable(
        numbers in proptest::collection::vec((0..31_usize, prop_oneof![any::<f32>(), Just(1e38), Just(0.0)]), 0..6),
    ) {
        let mut bytes = image(&burger());
        for (index, value) in numbers {
            bytes = with_number(&bytes, 36 + 4 * index, value);
        }
        if let Ok(coefficients) = check(&bytes) {
            let motion = model_core::motion::Motion::new(
                &[5.0, 5.0], &[0.0, 0.0], &coefficients.robot.mass_matrix, coefficients.robot.dead_band);
            let power = coefficients.model.power(&motion, coefficients.robot.range.middle());
            prop_assert!(power.is_some_and(|power| power.abs() <= 1e5));
        }
    }
}

fn with_effect(cause: Cause<f32>, coefficient: f32) -> Coefficients<f32, 2> {
    Coefficients { columns: Columns::new(&[Column { cause, coefficient }], 2).unwrap(), ..burger() }
}

/// What the board can run it takes; what needs a column of a log, reaches back too far or draws
/// more than any robot it does not.
#[test]
fn effects_are_taken_as_far_as_the_board_can_run_them() {
    for (cause, coefficient, expected) in [
        (Cause::Term(Term::GradeAhead), 0.03, None),
        (Cause::Heat(120.0), 0.5, None),
        (Cause::Scale(Side::Right), -0.02, None),
        (Cause::Delay, 0.5, None),
        (Cause::Delay, -0.51, Some(Reason::Delay)),
        (Cause::Term(Term::GradeByPitch), 1.3, Some(Reason::Input)),
        (Cause::Temperature(20.0), 0.004, Some(Reason::Input)),
        (Cause::Term(Term::Driver), 0.01, Some(Reason::Input)),
        (Cause::Term(Term::Windage), 1e30, Some(Reason::Value)),
        (Cause::Term(Term::Constant), 1e6, Some(Reason::Value)),
    ] {
        assert_eq!(refusal(&with_effect(cause, coefficient)), expected, "{cause:?}");
    }
    // Columns begin at 136 + 24; the first one's id stands behind their number and three zeros.
    let good = image(&with_effect(Cause::Term(Term::GradeAhead), 0.03));
    for (offset, byte, expected) in
        [(164, 99, Reason::Effect), (160, 2, Reason::Length), (160, 0, Reason::Value)]
    {
        let mut bytes = good.clone();
        bytes[offset] = byte;
        assert_eq!(check(&sealed(bytes)).err(), Some(expected), "{offset}");
    }
}
