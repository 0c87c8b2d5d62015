//! Liu 2023: linear and polynomial regression on the motors' commands and their feedback.
//!
//! The source has a mecanum robot whose motors take speeds; here commanded motion of the body is brought to the wheels by the
//! inverse of R, c = R⁺ ζ (of the wheel speeds with that motion the smallest), and the feedback is the measured speed w.
//!
//! - linear: P = a0 + Σ a_i |c_i| + Σ b_i |w_i|. Magnitudes: a wheel draws the same both ways, and a mecanum robot that moves
//!   sideways turns half of them backwards.
//! - polynomial: of degree 2, with x = (c, w): P = a0 + Σ a_i |x_i| + Σ a_ij x_i x_j. The products keep their signs: whether two
//!   wheels turn with or against each other is a turn's mark.
//!
//! Degree and signs are choices of this project.

use nalgebra::{DMatrix, DVector};

use super::regression::{Regression, Symbol};
use super::{Card, MOST_WHEELS, Need, Point};
use crate::error::Result;
use crate::robot::Robot;
use crate::with_wheels;

/// Linear in the magnitudes.
pub const LINEAR: Card = Card {
    name: "liu-linear",
    source: "Liu 2023: linear regression on the wheels' commanded and measured speeds",
    assumes: "level ground, one mass",
    takes_mass: false,
    network: false,
    needs: &[Need::Command],
    layouts: &[],
    make: |robot| Box::new(linear(robot)),
};

/// With all products of two.
pub const POLYNOMIAL: Card = Card {
    name: "liu-polynomial",
    source: "Liu 2023: second-order polynomial regression on the wheels' commanded and measured speeds",
    assumes: "level ground, one mass",
    takes_mass: false,
    network: false,
    needs: &[Need::Command],
    layouts: &[],
    make: |robot| Box::new(polynomial(robot)),
};

const AT_REST: Symbol = ("a0", "W");

const OF_COMMANDS: [Symbol; MOST_WHEELS] =
    [("a1", "W s"), ("a2", "W s"), ("a3", "W s"), ("a4", "W s"), ("a5", "W s"), ("a6", "W s")];

const OF_FEEDBACK: [Symbol; MOST_WHEELS] =
    [("b1", "W s"), ("b2", "W s"), ("b3", "W s"), ("b4", "W s"), ("b5", "W s"), ("b6", "W s")];

fn linear(robot: &Robot) -> Regression {
    let (to_wheels, wheels) = (to_wheels(robot), robot.wheels());
    let symbols = std::iter::once(AT_REST)
        .chain(OF_COMMANDS.into_iter().take(wheels))
        .chain(OF_FEEDBACK.into_iter().take(wheels));
    Regression::sized("liu-linear", symbols.collect(), move |point| {
        let speeds = speeds(point, &to_wheels);
        std::iter::once(1.0).chain(speeds.iter().map(|x| x.abs())).collect()
    })
}

/// Its coefficients go unnamed: a0, a_i in the order of (c, w), then a_ij with i ≤ j row by row.
fn polynomial(robot: &Robot) -> Regression {
    let to_wheels = to_wheels(robot);
    Regression::sized("liu-polynomial", Vec::new(), move |point| {
        let speeds = speeds(point, &to_wheels);
        let products = speeds.iter().enumerate().flat_map(|(i, x)| speeds[i..].iter().map(move |y| x * y));
        std::iter::once(1.0).chain(speeds.iter().map(|x| x.abs())).chain(products).collect()
    })
}

/// Commanded and measured speeds of the wheels, rad/s.
fn speeds(point: &Point, to_wheels: &DMatrix<f64>) -> Vec<f64> {
    let command = point.readings.command;
    let commanded = to_wheels * DVector::from_column_slice(&[command.vx, command.vy, command.omega]);
    commanded.iter().copied().chain(point.wheels.iter().map(|wheel| wheel.speed)).collect()
}

/// R⁺, which makes wheel speeds (rad/s) of vx, vy (m/s) and ω (rad/s). NaN for a robot that has no R: logs of such a robot
/// cannot be read.
fn to_wheels(robot: &Robot) -> DMatrix<f64> {
    let unknown = || DMatrix::from_element(robot.wheels(), 3, f64::NAN);
    with_wheels!(robot, inverse(robot)).ok().flatten().unwrap_or_else(unknown)
}

fn inverse<const N: usize>(robot: &Robot) -> Result<Option<DMatrix<f64>>> {
    // Any cutoff: only R is wanted.
    let core = robot.core::<N>(1.0)?;
    let rows = core.kinematics.rows();
    let matrix = DMatrix::from_fn(3, N, |component, wheel| rows[component][wheel]);
    // Below any difference that lengths in metres can make.
    Ok(matrix.pseudo_inverse(1e-12).ok())
}

#[cfg(test)]
mod tests {
    use super::{LINEAR, polynomial, to_wheels};
    use crate::baselines::testing::{burger, drive, recovers};
    use crate::baselines::{Baseline, Point};

    /// Commanded and measured speed of the Burger's wheels, 33 mm and 160 mm apart, by hand.
    fn wheels(point: &Point) -> [f64; 4] {
        let command = point.readings.command;
        let [left, right] = [-0.08, 0.08].map(|arm| (command.vx + arm * command.omega) / 0.033);
        [left, right, point.wheels[0].speed, point.wheels[1].speed]
    }

    /// Data made by its own equation: rounding, which the likeness of command and feedback (10 % apart, so a condition
    /// number near 1e4 of the normal equations) raises to 1e-11.
    #[test]
    fn linear_recovers_its_own_coefficients() {
        let truth = [0.4, 0.3, 0.1, 0.05, 0.25];
        let points = drive(2000, |point| {
            let powers = wheels(point).into_iter().zip(&truth[1..]).map(|(x, c)| c * x.abs());
            truth[0] + powers.sum::<f64>()
        });
        recovers(&LINEAR, &points, &truth, 1e-9);
    }

    /// As above; squares and products of speeds 10 % apart square its condition number to 1e8: 1e-16 · 1e8 of the largest.
    #[test]
    fn polynomial_recovers_its_own_coefficients() {
        let points = drive(4000, |point| {
            let [c1, c2, w1, w2] = wheels(point);
            0.4 + 0.3 * c1.abs() + 0.2 * w2.abs() + 0.01 * c1 * c1 + 0.02 * c1 * c2 - 0.03 * w1 * w2
        });
        let mut model = polynomial(&burger());
        model.fit(&points).unwrap();
        let truth = [0.4, 0.3, 0.0, 0.0, 0.2, 0.01, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.03, 0.0];
        let found = model.coefficients().unwrap();
        assert_eq!(found.len(), truth.len());
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 1e-8, "{found} {truth}");
        }
    }

    /// R R⁺ = 1 where the wheels can move the robot: of the Burger in vx and ω, not in vy.
    #[test]
    fn the_inverse_gives_the_motion_back() {
        let inverse = to_wheels(&burger());
        let v = 0.5 * 0.033 * (inverse.row(0) + inverse.row(1));
        let omega = 0.033 / 0.16 * (inverse.row(1) - inverse.row(0));
        for (found, expected) in v.iter().chain(omega.iter()).zip([1.0, 0.0, 0.0, 0.0, 0.0, 1.0]) {
            assert!((found - expected).abs() < 1e-12, "{inverse}");
        }
    }

    /// A command that is not known is an error, not a command to stand.
    #[test]
    fn refuses_unknown_commands() {
        let mut points = drive(100, |_| 1.0);
        points[4].readings.command.omega = f64::NAN;
        let error = (LINEAR.make)(&burger()).fit(&points).unwrap_err().to_string();
        assert!(error.starts_with("liu-linear: training point 4 has the terms"), "{error}");
    }
}
