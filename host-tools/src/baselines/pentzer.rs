//! Pentzer 2022: the power of a skid steer by [`super::skid`], its three unknowns learned by recursive least squares.
//!
//! ```text
//! P = g + G (|V_l| + |V_r|) + F |V_r - V_l|
//! ```
//!
//! with a gain constant g, taken as an offset, the resistance G of a side, and friction. The source learns the centres of
//! rotation from the robot's track over the ground by an extended Kalman filter. Logs of wheel speeds and power do not hold that
//! track: since ω = (V_r - V_l) / B, friction and centres act on the power only as the product F = μ m g a / B, which is
//! learned instead of its factors. Overhead imagery, from which the source refines the friction ahead of the robot, is left out.

use super::online::Online;
use super::regression::Symbol;
use super::skid::{LAYOUTS, side_speeds, slip_track};
use super::{Card, Point};

/// Three unknowns, learned while driving.
pub const RECURSIVE: Card = Card {
    name: "pentzer",
    source: "Pentzer 2022: skid steer by unknown centres of rotation, recursive least squares while driving",
    assumes: "level ground, one mass, no inertia; past powers of the drive are known",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: LAYOUTS,
    make: |robot| {
        let slip_track = slip_track(robot);
        Box::new(Online::new("pentzer", SYMBOLS, move |point| terms(point, slip_track)))
    },
};

const SYMBOLS: [Symbol; 3] = [("g", "W"), ("G", "N"), ("F", "N")];

/// 1, |V_l| + |V_r|, |V_r - V_l|; the slip-track gives back the speeds of the sides from the body's, whatever it is.
fn terms(point: &Point, slip_track: f64) -> [f64; 3] {
    [1.0, side_speeds(point, slip_track), slip_track * point.speed.omega.abs()]
}

#[cfg(test)]
mod tests {
    use super::RECURSIVE;
    use crate::baselines::testing::{drive, recovers};

    /// Data made by its own equation from the wheels' speeds. The start where nothing is known pulls each by less than 1e-5
    /// (see `sadrpour`).
    #[test]
    fn recovers_its_own_parameters() {
        let points = drive(2000, |point| {
            let [left, right] = [0, 1].map(|side| 0.033 * point.wheels[side].speed);
            0.4 + 2.5 * (left.abs() + right.abs()) + 1.2 * (right - left).abs()
        });
        recovers(&RECURSIVE, &points, &[0.4, 2.5, 1.2], 1e-5);
    }
}
