//! Whether a board of this robot can use an image of coefficients.

use model_core::coefficients::{Coefficients, DecodeError};
use model_core::delay::DelayLine;
use model_core::filter::LowPass;
use model_core::plausibility::Implausible;

use super::RobotIdentity;
use crate::control_table::Reason;
use crate::wheels::WHEELS;

/// Decodes an image of [`model_core::coefficients`] for a board that is set up for `robot` and
/// samples at this rate.
///
/// # Errors
/// The first thing that is wrong with it.
pub fn check_coefficients(
    image: &[u8],
    robot: &RobotIdentity,
    sample_rate_hz: u16,
) -> Result<Coefficients<f32, WHEELS>, Reason> {
    if image.is_empty() {
        return Err(Reason::Empty);
    }
    let coefficients = Coefficients::<f32, WHEELS>::decode(image).map_err(reason)?;
    // Decoding ignores what follows an image: raw flash is longer. An upload that is longer was cut
    // from something else.
    if coefficients.encode().is_none_or(|encoded| encoded.as_bytes().len() != image.len()) {
        return Err(Reason::Length);
    }
    if !robot.is(&coefficients.robot) {
        return Err(Reason::Robot);
    }
    coefficients.check_plausible().map_err(|implausible| match implausible {
        Implausible::Value => Reason::Value,
        Implausible::Cutoff => Reason::Slow,
        Implausible::Mass => Reason::Mass,
    })?;
    if !coefficients.columns.needs().nothing() {
        return Err(Reason::Input);
    }
    let period_s = 1.0 / f64::from(sample_rate_hz);
    let delay = coefficients.robot.conditioning.delay + coefficients.columns.delay();
    if !DelayLine::<f32, WHEELS>::reaches(delay, period_s) {
        return Err(Reason::Delay);
    }
    let cutoff_hz = f64::from(coefficients.robot.cutoff_hz);
    match LowPass::<f32>::new(cutoff_hz, period_s) {
        Ok(_) => Ok(coefficients),
        Err(_) => Err(Reason::Cutoff),
    }
}

/// The CRC-32 at an image's end: by it hosts tell images apart. 0 for bytes that are too few to
/// have one.
#[must_use]
pub fn checksum(image: &[u8]) -> u32 {
    image.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

fn reason(error: DecodeError) -> Reason {
    match error {
        DecodeError::Truncated => Reason::Length,
        DecodeError::NotAnImage => Reason::NotAnImage,
        DecodeError::Version { .. } => Reason::Version,
        DecodeError::Checksum => Reason::Checksum,
        DecodeError::UnknownModel { .. } => Reason::Model,
        DecodeError::UnknownEffect { .. } => Reason::Effect,
        DecodeError::WheelCount { .. } => Reason::Wheels,
        DecodeError::Field(_) => Reason::Value,
    }
}
