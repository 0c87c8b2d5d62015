//! The coefficient image against one packed by Python's struct and zlib: reference/image.py.
#![cfg_attr(target_os = "none", no_std, no_main)]

use model_core::coefficients::{Coefficients, DecodeError, Name, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};
use on_target_tests::{Failed, Outcome, ensure, tests};

#[allow(clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/image.rs");
}
use reference::{
    CUTOFF_HZ, DEAD_BAND, FULL_LOAD, GYRATION_RADIUS, IMAGE, NAME, NO_LOAD, NOISE_DENSITY, NOISE_MODEL_STD,
    NOISE_TAIL, RESIDUAL_STD, ROWS, STATIC_POWER, TORQUE,
};

tests!(
    encodes_as_documented,
    decodes_what_python_packed,
    notices_every_flipped_bit,
    notices_every_missing_byte
);

fn coefficients() -> Option<Coefficients<f32, 2>> {
    let kinematics = Kinematics::from_rows(ROWS).ok()?;
    Some(Coefficients {
        robot: Robot {
            name: Name::new(NAME),
            kinematics,
            gyration_radius: GYRATION_RADIUS,
            mass_matrix: kinematics.mass_matrix(GYRATION_RADIUS).ok()?,
            dead_band: DEAD_BAND,
            cutoff_hz: CUTOFF_HZ,
            conditioning: Conditioning::PLAIN,
            range: MassRange::new(NO_LOAD, FULL_LOAD)?,
            static_power: STATIC_POWER,
        },
        model: Model::Signed { torque: TorqueModel::from_array(TORQUE), drive: Drive::Regenerative },
        noise: Noise {
            density: NOISE_DENSITY,
            model_std: NOISE_MODEL_STD,
            tail: NOISE_TAIL,
            residual_std: RESIDUAL_STD,
        },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    })
}

fn encodes_as_documented() -> Outcome {
    let image = coefficients().and_then(|c| c.encode()).ok_or(Failed)?;
    ensure(image.as_bytes().len() == IMAGE.len(), format_args!("{} bytes", image.as_bytes().len()))?;
    for (i, (found, reference)) in image.as_bytes().iter().zip(IMAGE).enumerate() {
        ensure(*found == reference, format_args!("byte {i}: {found:#04x}, reference {reference:#04x}"))?;
    }
    Ok(())
}

/// Bit for bit: nothing is computed but M'', from the same numbers.
fn decodes_what_python_packed() -> Outcome {
    let found = Coefficients::<f32, 2>::decode(&IMAGE);
    ensure(found.ok() == coefficients(), format_args!("{found:?}"))?;
    let found = Coefficients::<f32, 3>::decode(&IMAGE);
    let expected = DecodeError::WheelCount { count: 2 };
    ensure(found == Err(expected), format_args!("for three wheels: {found:?}"))
}

fn notices_every_flipped_bit() -> Outcome {
    for i in 0..IMAGE.len() {
        for bit in 0..8 {
            let mut damaged = IMAGE;
            if let Some(byte) = damaged.get_mut(i) {
                *byte ^= 1 << bit;
            }
            let found = Coefficients::<f32, 2>::decode(&damaged);
            ensure(found.is_err(), format_args!("byte {i}, bit {bit}: decoded all the same"))?;
        }
    }
    Ok(())
}

fn notices_every_missing_byte() -> Outcome {
    for length in 0..IMAGE.len() {
        let found = Coefficients::<f32, 2>::decode(IMAGE.get(..length).unwrap_or(&[]));
        ensure(found == Err(DecodeError::Truncated), format_args!("{length} bytes: {found:?}"))?;
    }
    Ok(())
}
