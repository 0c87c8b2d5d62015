//! Mei 2005: the power of a differential drive as a straight line over its speed, P = c0 + c1 |v|.
//!
//! A robot draws the same forwards and backwards, so it is the magnitude of the speed. They fitted the line to straight drives
//! and circles at constant speed; only the speed along the path enters (Table 1: "longitudinal speed"), so that a spin on
//! the spot is predicted as standing.

use super::regression::Regression;
use super::{Card, Point};

/// P = c0 + c1 |v|.
pub const FIRST_ORDER: Card = Card {
    name: "mei",
    source: "Mei 2005: first-order regression on the speed",
    assumes: "level ground; turning, accelerating and the payload cost nothing",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("mei", [("c0", "W"), ("c1", "W s/m")], terms)),
};

fn terms(point: &Point) -> [f64; 2] {
    [1.0, path_speed(point)]
}

/// Speed along the path, m/s: of a robot that cannot move sideways |v|.
pub(super) fn path_speed(point: &Point) -> f64 {
    point.speed.vx.hypot(point.speed.vy)
}

#[cfg(test)]
mod tests {
    use super::FIRST_ORDER;
    use crate::baselines::testing::{drive, recovers};

    /// Data made by its own line, driven both ways. Two well-separated columns: rounding only.
    #[test]
    fn recovers_its_own_coefficients() {
        let points = drive(500, |point| 0.3 + 7.4 * point.speed.vx.abs());
        recovers(&FIRST_ORDER, &points, &[0.3, 7.4], 1e-9);
    }
}
