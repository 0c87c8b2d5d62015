//! Coefficients of the robot that a board is set up for when nothing is stored.
#![allow(dead_code, reason = "every test crate uses its own part")]

use crc::{CRC_32_ISO_HDLC, Crc};
use firmware::items::RobotIdentity;
use model_core::coefficients::{Coefficients, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};

pub(crate) const SAMPLE_RATE_HZ: u16 = 200;

/// A TurtleBot3 Burger with the size of numbers that a fit finds for it.
pub(crate) fn burger() -> Coefficients<f32, 2> {
    let identity = RobotIdentity::BURGER;
    let kinematics = Kinematics::from_rows(identity.rows).unwrap();
    Coefficients {
        robot: Robot {
            name: identity.name,
            kinematics,
            gyration_radius: identity.gyration_radius,
            mass_matrix: kinematics.mass_matrix(identity.gyration_radius).unwrap(),
            dead_band: 0.02,
            cutoff_hz: 2.0,
            conditioning: Conditioning::PLAIN,
            range: MassRange::new(1.0, 6.0).unwrap(),
            static_power: 0.0,
        },
        model: Model::Signed {
            torque: TorqueModel::from_array([0.04, 0.012, 0.006, 0.0081, 1.33, 6.5, 0.0]),
            drive: Drive::Dissipative,
        },
        noise: Noise { density: 0.0031, model_std: 0.012, tail: 1.25, residual_std: 0.0 },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    }
}

pub(crate) fn image(coefficients: &Coefficients<f32, 2>) -> Vec<u8> {
    coefficients.encode().unwrap().as_bytes().to_vec()
}

/// The checksum at the end made right again.
pub(crate) fn sealed(mut image: Vec<u8>) -> Vec<u8> {
    let body = image.len() - 4;
    let checksum = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(&image[..body]);
    image[body..].copy_from_slice(&checksum.to_le_bytes());
    image
}

/// Another number at `offset`, the checksum right.
pub(crate) fn with_number(image: &[u8], offset: usize, value: f32) -> Vec<u8> {
    let mut image = image.to_vec();
    image[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
    sealed(image)
}
