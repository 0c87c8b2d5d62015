//! What models of known form need of their training points.

use support::error::{Error, Result};

use super::point::Point;

/// Fewest points in which a wheel turns: several for each constant.
const LEAST: usize = 20;

/// The points are finite, and the robot moves in enough of them.
///
/// # Errors
/// Names the first point that is not finite, or the number that move.
pub(super) fn check(name: &str, points: &[Point]) -> Result<()> {
    if let Some(index) = points.iter().position(|point| !is_finite(point)) {
        return Err(Error::failed(format!(
            "{name}: training point {index} is not finite ({:?}); expected finite motion, mass and power",
            points[index]
        )));
    }
    let moving =
        points.iter().filter(|point| point.wheels.iter().any(|wheel| wheel.direction != 0.0)).count();
    if moving < LEAST {
        return Err(Error::failed(format!(
            "{name}: a wheel turns in {moving} training points; expected at least {LEAST}"
        )));
    }
    Ok(())
}

fn is_finite(point: &Point) -> bool {
    let Point { speed, acceleration, wheels, mass, power, .. } = point;
    let body = [speed.vx, speed.vy, speed.omega, acceleration.vx, acceleration.vy, acceleration.omega];
    let wheels = wheels.iter().flat_map(|wheel| [wheel.speed, wheel.acceleration, wheel.inertial_torque]);
    let others = [*mass, *power, point.time, point.grade()];
    body.into_iter().chain(wheels).chain(others).all(f64::is_finite)
}

/// At most so many points, evenly over the whole.
pub(super) fn thin<T: Copy>(points: &[T], most: usize) -> Vec<T> {
    evenly(points.len(), most).map(|index| points[index]).collect()
}

/// At most so many indices of `count`, evenly over the whole.
pub(super) fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let kept = most.min(count);
    (0..kept).map(move |index| index * count / kept)
}

/// The value if it is above 0, else 0; NaN stays NaN, which `f64::max` would make 0.
pub(super) fn positive_part(value: f64) -> f64 {
    if value < 0.0 { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use super::{LEAST, check, evenly};
    use crate::baselines::testing::{drive, still};

    #[test]
    fn counts_the_points_that_move() {
        let moving = drive(LEAST + 1, |_| 1.0);
        let enough = [vec![still(); 100], moving[1..].to_vec()].concat();
        assert!(check("x", &enough).is_ok());
        let error = check("x", &enough[..enough.len() - 1]).unwrap_err().to_string();
        assert_eq!(error, "x: a wheel turns in 19 training points; expected at least 20");
    }

    #[test]
    fn names_the_first_point_that_is_not_finite() {
        let mut points = drive(50, |_| 1.0);
        points[7].acceleration.omega = f64::NAN;
        points[9].mass = f64::INFINITY;
        let error = check("x", &points).unwrap_err().to_string();
        assert!(error.starts_with("x: training point 7 is not finite"), "{error}");
    }

    /// Neighbours of 10 in 35 are 3 or 4 apart, and the first is kept.
    #[test]
    fn thins_evenly() {
        assert_eq!(evenly(35, 10).collect::<Vec<_>>(), [0, 3, 7, 10, 14, 17, 21, 24, 28, 31]);
        assert_eq!(evenly(3, 10).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(evenly(0, 10).count(), 0);
    }
}
