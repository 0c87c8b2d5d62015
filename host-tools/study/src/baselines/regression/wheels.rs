//! Regressions on the motors' commands and their feedback (Liu 2023).
//!
//! The source has a mecanum robot whose motors take speeds; here commanded motion of the body is
//! brought to the wheels by the inverse of R, c = R⁺ ζ (of the wheel speeds with that motion the
//! smallest), and the feedback is the measured speed w.
//!
//! - linear: P = a0 + Σ a_i |c_i| + Σ b_i |w_i|. Magnitudes: a wheel draws the same both ways, and
//!   a mecanum robot that moves sideways turns half of them backwards.
//! - polynomial: of degree 2, with x = (c, w): P = a0 + Σ a_i |x_i| + Σ a_ij x_i x_j. The products
//!   keep their signs: whether two wheels turn with or against each other is a turn's mark.
//!
//! Degree and signs are choices of this project.

use logs::robot::Robot;
use model_core::coefficients::MOST_WHEELS;
use nalgebra::{DMatrix, DVector};

use crate::baselines::baseline::Symbol;
use crate::baselines::point::Point;

const AT_REST: Symbol = ("a0", "W");

const OF_COMMANDS: [Symbol; MOST_WHEELS] =
    [("a1", "W s"), ("a2", "W s"), ("a3", "W s"), ("a4", "W s"), ("a5", "W s"), ("a6", "W s")];

const OF_FEEDBACK: [Symbol; MOST_WHEELS] =
    [("b1", "W s"), ("b2", "W s"), ("b3", "W s"), ("b4", "W s"), ("b5", "W s"), ("b6", "W s")];

/// Commanded and measured speeds of a robot's wheels.
pub(super) struct WheelSpeeds {
    to_wheels: DMatrix<f64>,
    products: bool,
}

impl WheelSpeeds {
    pub(super) fn of(robot: &Robot, products: bool) -> Self {
        Self { to_wheels: robot.wheel_speeds_of_motion(), products }
    }

    /// The coefficients of the polynomial have no names: a0, a_i in the order of (c, w), then a_ij
    /// with i ≤ j row by row.
    pub(super) fn symbols(&self) -> Vec<Symbol> {
        if self.products {
            return Vec::new();
        }
        let wheels = self.to_wheels.nrows();
        let each = OF_COMMANDS.into_iter().take(wheels).chain(OF_FEEDBACK.into_iter().take(wheels));
        std::iter::once(AT_REST).chain(each).collect()
    }

    pub(super) fn terms(&self, point: &Point) -> Vec<f64> {
        let speeds = self.speeds(point);
        let magnitudes = speeds.iter().map(|x| x.abs());
        let mut terms: Vec<f64> = std::iter::once(1.0).chain(magnitudes).collect();
        if self.products {
            let products = speeds.iter().enumerate();
            terms.extend(products.flat_map(|(i, x)| speeds[i..].iter().map(move |y| x * y)));
        }
        terms
    }

    /// Commanded and measured, rad/s.
    fn speeds(&self, point: &Point) -> Vec<f64> {
        let command = point.readings.command;
        let commanded =
            &self.to_wheels * DVector::from_column_slice(&[command.vx, command.vy, command.omega]);
        commanded.iter().copied().chain(point.wheels.iter().map(|wheel| wheel.speed)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::baselines::testing::burger;

    /// R R⁺ = 1 where the wheels can move the robot: of the Burger in vx and ω, not in vy.
    #[test]
    fn the_inverse_gives_the_motion_back() {
        let inverse = burger().wheel_speeds_of_motion();
        let v = 0.5 * 0.033 * (inverse.row(0) + inverse.row(1));
        let omega = 0.033 / 0.16 * (inverse.row(1) - inverse.row(0));
        for (value, expected) in v.iter().chain(omega.iter()).zip([1.0, 0.0, 0.0, 0.0, 0.0, 1.0]) {
            assert!((value - expected).abs() < 1e-12, "{inverse}");
        }
    }
}
