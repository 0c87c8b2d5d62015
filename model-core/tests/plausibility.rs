//! What is taken for coefficients can be used: with every image that is plausible there is a drive
//! that gives the mass.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::coefficients;
use crc::{CRC_32_ISO_HDLC, Crc};
use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::{Coefficients, DecodeError};
use model_core::eq18::Gate;
use model_core::estimator::{Estimate, Estimator, Sample, Timing};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::plausibility::Implausible;
use model_core::slip::SlipMemory;

const PERIOD: f64 = 0.005;

/// Zero, one, and what is far from either.
const WILD: [f32; 21] = [
    0.0, 1e-38, 1e-30, 1e-20, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4,
    1e6, 1e9, 1e20, 1e38,
];

type Two = Coefficients<f32, 2>;

/// As the image of a robot with everything that an image can hold; its places stand in
/// `model_core::coefficients`.
fn good() -> [Vec<u8>; 4] {
    let plain: Two = coefficients().convert().unwrap();
    let mut memory = plain;
    memory.robot.kinematics = Kinematics::from_rows(*plain.robot.kinematics.rows()).unwrap().with_scrub(true);
    memory.robot.mass_matrix = memory.robot.kinematics.mass_matrix(plain.robot.gyration_radius).unwrap();
    memory.robot.conditioning.slip = SlipMemory { half_slip: 0.126, relaxation: 1.79, rest: 0.0 };
    memory.robot.conditioning.delay = 0.05;
    let eq18 = Coefficients { model: Model::Eq18 { gate: Gate::Corrected, beta: [0.01; 15] }, ..plain };
    let adapting = Coefficients { ground_adapts: true, ..plain };
    [plain, memory, eq18, adapting].map(|coefficients| coefficients.encode().unwrap().as_bytes().to_vec())
}

fn with_number(image: &[u8], offset: usize, value: f32) -> Result<Two, DecodeError> {
    let mut image = image.to_vec();
    image[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
    let body = image.len() - 4;
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&image[..body]);
    image[body..].copy_from_slice(&checksum.to_le_bytes());
    Two::decode(&image)
}

/// Whether a robot that is as the coefficients say, in the middle of its masses, is weighed within
/// three windows when it drives so fast, straight ahead or in curves, speeding up and slowing down.
/// `None` of a cutoff or delay that the sample rate cannot have, which is refused for that.
fn is_weighed(coefficients: &Two, fast: f32, turns: f32) -> Option<bool> {
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 25 },
        detect_changes: true,
    };
    let robot = &coefficients.robot;
    let method = coefficients.window(PERIOD as f32);
    let mut plain = Estimator::<f32, _, 2, 32>::new(coefficients, method, &timing).ok()?;
    let mut adapting = Adaptive::new(coefficients, &Ground::usual(), PERIOD, 1.0)
        .ok()
        .filter(|_| coefficients.ground_adapts);
    let is_weighed = (0..(75.0 / PERIOD) as u32).any(|i| {
        let t = i as f32 * PERIOD as f32;
        let wheel = |rate: f32| (fast * (0.6 + 0.4 * (rate * t).sin()), fast * 0.4 * rate * (rate * t).cos());
        let ((left, by_left), (right, by_right)) = (wheel(0.9), wheel(0.9 - turns));
        let motion = Motion::new(&[left, right], &[by_left, by_right], &robot.mass_matrix, robot.dead_band);
        let power = coefficients.model.power(&motion, robot.range.middle()).unwrap_or(f32::NAN);
        let sample = Sample { wheel_speed: [left, right], wheel_acceleration: None, power };
        let Estimate { mass, .. } = match &mut adapting {
            Some(adapting) => adapting.push(&sample, PERIOD as f32),
            None => plain.push(&sample, PERIOD as f32),
        };
        mass.known().is_some()
    });
    Some(is_weighed)
}

/// Every number of the image, one at a time, to the far ends and between.
#[test]
fn what_is_plausible_gives_a_mass() {
    let (mut taken, mut refused, mut useless) = (0, [0; 3], Vec::new());
    for (kind, image) in good().iter().enumerate() {
        // From the gyration radius to the last row of R; after it follow a checksum or effects,
        // which have bounds of their own.
        for offset in (36..160).step_by(4) {
            for value in WILD {
                let Ok(coefficients) = with_number(image, offset, value) else { continue };
                match coefficients.check_plausible() {
                    Err(why) => refused[why as usize] += 1,
                    Ok(()) => {
                        taken += 1;
                        let drives = [(5.0, 0.0), (5.0, 0.2), (50.0, 0.0), (50.0, 0.2), (0.5, 0.2)];
                        if drives
                            .into_iter()
                            .all(|(fast, turns)| is_weighed(&coefficients, fast, turns) == Some(false))
                        {
                            useless.push((kind, offset, value));
                        }
                    }
                }
            }
        }
    }
    assert!(useless.is_empty(), "{useless:?}");
    // Neither all nor nothing.
    assert!(taken > 500 && refused.iter().all(|count| *count > 5), "{taken} {refused:?}");
}

/// What is refused for its mass is not weighed at ordinary speeds: the bound is no narrower than it
/// has to be.
#[test]
fn what_is_refused_for_its_mass_gives_none() {
    for (kind, image) in good().iter().enumerate() {
        for offset in (60..76).step_by(4) {
            for value in WILD {
                let Ok(coefficients) = with_number(image, offset, value) else { continue };
                if coefficients.check_plausible() == Err(Implausible::Mass) {
                    let weighed = [5.0, 0.5].map(|fast| is_weighed(&coefficients, fast, 0.2));
                    assert_eq!(weighed, [Some(false); 2], "{kind} {offset} {value}");
                }
            }
        }
    }
}
