//! Leng 2024: multivariate linear regression on the body's motion (Eq. 30), and with the mass of Parasuraman 2014 (Eq. 31).

use super::regression::{Regression, Symbol};
use super::{Card, Point};

/// Eq. 30, without the mass.
pub const ROAD_GRADE: Card = Card {
    name: "leng",
    source: "Leng 2024 (Eq. 30): linear in v, ω, gated v̇ v, ω̇ ω and sin φ v",
    assumes: "one mass; level ground where the log has no pitch_rad",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("leng", ROAD_GRADE_SYMBOLS, road_grade)),
};

/// Eq. 31, the regression that the paper compares itself with.
pub const WITH_MASS: Card = Card {
    name: "linear",
    source: "Leng 2024 with the mass of Parasuraman 2014 (Eq. 31): linear in v, ω, gated v̇ v and ω̇ ω, and m",
    assumes: "level ground; a kilogram costs the same power at any speed",
    takes_mass: true,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Regression::new("linear", WITH_MASS_SYMBOLS, with_mass)),
};

const ROAD_GRADE_SYMBOLS: [Symbol; 9] = [
    ("c0", "W"),
    ("c1", "W s/m"),
    ("c2", "W s³/m²"),
    ("c3", "W s³/m²"),
    ("c4", "W s"),
    ("c5", "W s³"),
    ("c6", "W s³"),
    ("c7", "W s/m"),
    ("c8", "W s/m"),
];

const WITH_MASS_SYMBOLS: [Symbol; 8] = [
    ("c0", "W"),
    ("c1", "W s/m"),
    ("c2", "W s³/m²"),
    ("c3", "W s³/m²"),
    ("c4", "W s"),
    ("c5", "W s³"),
    ("c6", "W s³"),
    ("c7", "W/kg"),
];

/// 1, v, max(v̇, 0) v, min(v̇, 0) v, ω, max(ω̇, 0) ω, min(ω̇, 0) ω.
fn motion(point: &Point) -> [f64; 7] {
    let (v, omega) = (point.speed.vx, point.speed.omega);
    let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
    [1.0, v, up(dv) * v, down(dv) * v, omega, up(domega) * omega, down(domega) * omega]
}

/// [`motion`], max(sin φ, 0) v, min(sin φ, 0) v.
fn road_grade(point: &Point) -> [f64; 9] {
    let [one, v, faster, slower, omega, turn_faster, turn_slower] = motion(point);
    let climb = point.grade().sin();
    [one, v, faster, slower, omega, turn_faster, turn_slower, up(climb) * v, down(climb) * v]
}

/// [`motion`], m.
fn with_mass(point: &Point) -> [f64; 8] {
    let [one, v, faster, slower, omega, turn_faster, turn_slower] = motion(point);
    [one, v, faster, slower, omega, turn_faster, turn_slower, point.mass]
}

/// max(value, 0), but NaN for NaN, which `f64::max` takes for 0.
fn up(value: f64) -> f64 {
    0.5 * (value + value.abs())
}

/// min(value, 0), but NaN for NaN.
fn down(value: f64) -> f64 {
    0.5 * (value - value.abs())
}

#[cfg(test)]
mod tests {
    use super::{ROAD_GRADE, WITH_MASS};
    use crate::baselines::testing::{burger, drive, recovers};
    use crate::baselines::{Point, Readings};

    const TRUTH: [f64; 7] = [0.3, 2.0, 5.0, -1.0, 0.4, 0.7, -0.2];

    fn gated(rate: f64, speed: f64, up: f64, down: f64) -> f64 {
        if rate > 0.0 { up * rate * speed } else { down * rate * speed }
    }

    /// What Eq. 30 and 31 have in common.
    fn common(point: &Point) -> f64 {
        let [c0, c1, c2, c3, c4, c5, c6] = TRUTH;
        let (v, omega) = (point.speed.vx, point.speed.omega);
        let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
        c0 + c1 * v + gated(dv, v, c2, c3) + c4 * omega + gated(domega, omega, c5, c6)
    }

    /// Data made by Eq. 30 itself give its coefficients back.
    #[test]
    fn recovers_the_coefficients_of_eq_30() {
        let points =
            drive(2000, |point| common(point) + gated(point.readings.pitch.sin(), point.speed.vx, 9.0, 4.0));
        recovers(&ROAD_GRADE, &points, &[&TRUTH[..], &[9.0, 4.0]].concat(), 1e-9);
    }

    /// Data made by Eq. 31 itself give its coefficients back.
    #[test]
    fn recovers_the_coefficients_of_eq_31() {
        let points = drive(2000, |point| common(point) + 0.05 * point.mass);
        recovers(&WITH_MASS, &points, &[&TRUTH[..], &[0.05]].concat(), 1e-9);
    }

    /// A log without a pitch column is one of level ground: c7 and c8 stay 0.
    #[test]
    fn knows_level_ground() {
        let level = |point: Point| Point { readings: Readings::NONE, ..point };
        let points: Vec<Point> = drive(2000, common).into_iter().map(level).collect();
        recovers(&ROAD_GRADE, &points, &[&TRUTH[..], &[0.0, 0.0]].concat(), 1e-9);
    }

    /// An acceleration that is not known must not pass for none.
    #[test]
    fn an_unknown_acceleration_is_not_zero() {
        let mut points = drive(100, common);
        let mut model = (ROAD_GRADE.make)(&burger());
        model.fit(&points).unwrap();
        points[7].acceleration.vx = f64::NAN;
        assert!(model.predict(&points).unwrap()[7].is_nan());
        assert!(model.fit(&points).is_err());
    }
}
