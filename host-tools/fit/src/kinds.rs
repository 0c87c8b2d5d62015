//! Kinds of driving in the logs of a fit: slow or fast, and for each of these straight on or
//! turning, or steady or accelerating.
//!
//! A fit balances the errors of its form over all that the robot did. One kind of driving alone has
//! much larger errors, and a task may be of one kind: crawling, dashes to and fro.

use logs::robot::chassis::Together;
use numerics::robust::median;

use super::dataset::{Kept, Rows};

/// Halves of the rows in motion: by how fast the wheels turn, by how much they differ, and by how
/// hard they accelerate.
pub(super) struct Kinds {
    speed: f64,
    difference: f64,
    acceleration: f64,
}

/// The bits of [`Kinds::kind`] that distinguish two kinds: speed and turn, or speed and
/// acceleration. All three at once leave too few rows in each for its error to exceed the noise.
pub(super) const PAIRS: [u8; 2] = [0b110, 0b101];

impl Kinds {
    pub(super) fn of(rows: &Rows) -> Self {
        let moving = || rows.iter().filter(|row| row.wheels.is_moving());
        let mut speeds: Vec<f64> = moving().map(speed).collect();
        let mut differences: Vec<f64> = moving().map(difference).collect();
        let mut accelerations: Vec<f64> = moving().map(acceleration).collect();
        let middle = |values: &mut Vec<f64>| median(values).unwrap_or(0.0);
        Self {
            speed: middle(&mut speeds),
            difference: middle(&mut differences),
            acceleration: middle(&mut accelerations),
        }
    }

    /// A bit each: fast, turning, accelerating.
    pub(super) fn kind(&self, row: &Kept<'_>) -> u8 {
        4 * u8::from(speed(*row) > self.speed)
            + 2 * u8::from(difference(*row) > self.difference)
            + u8::from(acceleration(*row) > self.acceleration)
    }
}

/// Mean of the wheels' sizes, rad/s.
fn speed(row: Kept<'_>) -> f64 {
    row.wheels.mean_speed()
}

/// From the slowest wheel to the fastest, with their signs, rad/s.
fn difference(row: Kept<'_>) -> f64 {
    let speeds = || row.wheels.iter().map(|wheel| wheel.speed);
    speeds().fold(f64::NEG_INFINITY, f64::max) - speeds().fold(f64::INFINITY, f64::min)
}

/// Mean of the wheels' sizes, rad/s².
fn acceleration(row: Kept<'_>) -> f64 {
    row.wheels.mean(|wheel| wheel.acceleration.abs())
}
