//! Parasuraman 2012/2014: the power as a plane over speed and mass, P = c0 + c1 |v| + c2 m.
//!
//! The mass is added, not multiplied by the speed: so it is where Leng's regression takes it over (Eq. 31 of the paper). The
//! speed is its magnitude, as in [`super::mei`].

use super::mei::path_speed;
use super::regression::Regression;
use super::{Card, Point};

/// P = c0 + c1 |v| + c2 m.
pub const SPEED_AND_MASS: Card = Card {
    name: "parasuraman",
    source: "Parasuraman 2012/2014: first-order regression on speed and mass",
    assumes: "level ground; a kilogram costs the same power at any speed; turning and accelerating cost nothing",
    takes_mass: true,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("parasuraman", SYMBOLS, terms)),
};

const SYMBOLS: [(&str, &str); 3] = [("c0", "W"), ("c1", "W s/m"), ("c2", "W/kg")];

fn terms(point: &Point) -> [f64; 3] {
    [1.0, path_speed(point), point.mass]
}

#[cfg(test)]
mod tests {
    use super::SPEED_AND_MASS;
    use crate::baselines::testing::{burger, drive, recovers};

    /// Data made by its own plane at 1, 2 and 3 kg: rounding only.
    #[test]
    fn recovers_its_own_coefficients() {
        let points = drive(500, |point| 0.3 + 2.0 * point.speed.vx.abs() + 0.4 * point.mass);
        recovers(&SPEED_AND_MASS, &points, &[0.3, 2.0, 0.4], 1e-9);
    }

    /// With one mass, c0 and c2 m cannot be told apart: the sum is right all the same, to rounding.
    #[test]
    fn learns_from_one_mass() {
        let mut points = drive(500, |point| 1.1 + 2.0 * point.speed.vx.abs());
        points.iter_mut().for_each(|point| point.mass = 2.0);
        let mut model = (SPEED_AND_MASS.make)(&burger());
        model.fit(&points).unwrap();
        for (predicted, point) in model.predict(&points).unwrap().iter().zip(&points) {
            assert!((predicted - point.power).abs() < 1e-9, "{predicted} {}", point.power);
        }
    }
}
