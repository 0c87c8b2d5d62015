//! Jaiem 2016/2021: the power of a differential drive as a parabola over its speed, P = c0 + c1 |v| + c2 v².
//!
//! The magnitude, as in [`super::mei`].

use super::mei::path_speed;
use super::regression::Regression;
use super::{Card, Point};

/// P = c0 + c1 |v| + c2 v².
pub const SECOND_ORDER: Card = Card {
    name: "jaiem",
    source: "Jaiem 2016/2021: second-order polynomial regression on the speed",
    assumes: "level ground, one mass; turning and accelerating cost nothing",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("jaiem", SYMBOLS, terms)),
};

const SYMBOLS: [(&str, &str); 3] = [("c0", "W"), ("c1", "W s/m"), ("c2", "W s²/m²")];

fn terms(point: &Point) -> [f64; 3] {
    let speed = path_speed(point);
    [1.0, speed, speed * speed]
}

#[cfg(test)]
mod tests {
    use super::SECOND_ORDER;
    use crate::baselines::testing::{drive, recovers};

    /// Data made by its own parabola, driven both ways. Scaled, the condition number of 1, |v|, v² over [0, 0.2] m/s is
    /// below 1e4: rounding only.
    #[test]
    fn recovers_its_own_coefficients() {
        let points = drive(500, |point| 0.3 + 2.0 * point.speed.vx.abs() + 5.0 * point.speed.vx.powi(2));
        recovers(&SECOND_ORDER, &points, &[0.3, 2.0, 5.0], 1e-9);
    }
}
