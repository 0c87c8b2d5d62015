//! Effati 2023: the power of a skid steer by [`super::skid`], its centres of rotation known.
//!
//! ```text
//! P = G (|V_l| + |V_r|) + μ m g a |ω|
//! ```
//!
//! without an offset, so that the energy of a path does not depend on the speed at which it is driven: what the source builds its
//! energy-optimal paths on. The centres are known from the slip-track B. Robot files do not tell where the wheels stand, so the
//! distance a of a contact from its centre is taken as B / 2 and m as the robot's mass without payload: both scale μ, not the
//! predicted power.

use model_core::effects::GRAVITY;

use super::regression::{Regression, Symbol};
use super::skid::{LAYOUTS, side_speeds, slip_track};
use super::{Card, Point};
use crate::robot::Robot;

/// Two unknowns, learned from the training.
pub const KNOWN_CENTRES: Card = Card {
    name: "effati",
    source: "Effati 2023: skid steer by known centres of rotation",
    assumes: "level ground, one mass, no inertia, no power at rest",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: LAYOUTS,
    make: |robot| Box::new(regression(robot)),
};

const SYMBOLS: [Symbol; 2] = [("G", "N"), ("μ", "1")];

fn regression(robot: &Robot) -> Regression {
    let slip_track = slip_track(robot);
    let sliding = robot.mass_no_load_kg() * GRAVITY * 0.5 * slip_track;
    Regression::new("effati", SYMBOLS, move |point: &Point| {
        [side_speeds(point, slip_track), sliding * point.speed.omega.abs()]
    })
}

#[cfg(test)]
mod tests {
    use super::KNOWN_CENTRES;
    use crate::baselines::testing::{burger, drive, recovers};
    use model_core::effects::GRAVITY;

    /// Data made by its own equation from the wheels' speeds, μ = 0.3 under the Burger's weight at 80 mm: rounding only.
    #[test]
    fn recovers_its_own_parameters() {
        let weight = burger().mass_no_load_kg() * GRAVITY;
        let points = drive(2000, |point| {
            let [left, right] = [0, 1].map(|side| 0.033 * point.wheels[side].speed);
            2.5 * (left.abs() + right.abs()) + 0.3 * weight * 0.08 * point.speed.omega.abs()
        });
        recovers(&KNOWN_CENTRES, &points, &[2.5, 0.3], 1e-9);
    }
}
