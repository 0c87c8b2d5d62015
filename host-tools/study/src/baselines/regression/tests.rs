//! Least squares by hand, and data made by each source's own equation, which give its coefficients
//! back.

use model_core::effects::GRAVITY;

use super::{Regression, Term, least_squares};
use crate::baselines::cards::{EFFATI, JAIEM, LENG, LINEAR, LIU_LINEAR, MEI, PARASURAMAN};
use crate::baselines::testing::{burger, drive, recovers};
use crate::baselines::{Baseline, Point, Readings};

fn line() -> Regression {
    Regression::new("line", &[("a", "W", Term::One), ("b", "W s/m", Term::Speed)], &burger())
}

/// y = 1 + 2 x and the residuals (1, -2, 1), which sum to 0 and are orthogonal to x: exact in small
/// integers.
#[test]
fn residuals_are_orthogonal_to_the_terms() {
    let fit = least_squares(&[([1.0, 0.0], 2.0), ([1.0, 1.0], 1.0), ([1.0, 2.0], 6.0)]).unwrap();
    assert!((fit[0] - 1.0).abs() < 1e-12 && (fit[1] - 2.0).abs() < 1e-12, "{fit:?}");
}

/// Of x + y = 2 with equal columns the smallest solution is (1, 1); a column of zeros gets 0.
#[test]
fn shares_what_repeats_and_leaves_out_what_is_not_there() {
    let coefficients = least_squares(&[([1.0, 1.0, 0.0], 2.0), ([2.0, 2.0, 0.0], 4.0)]).unwrap();
    assert!(coefficients.iter().zip([1.0, 1.0, 0.0]).all(|(value, truth)| (value - truth).abs() < 1e-12));
    assert!(least_squares::<[f64; 2]>(&[]).is_none());
}

#[test]
fn refuses_what_it_cannot_learn_from() {
    let points = drive(10, |_| 1.0);
    let refusal = |points: &[Point]| line().fit(points).unwrap_err().to_string();
    assert_eq!(
        refusal(&points[..1]),
        "line: 1 training points; expected at least 2, one for each coefficient"
    );
    assert!(refusal(&[]).contains("0 training points"));
    let mut broken = points.clone();
    broken[3].speed.vx = f64::NAN;
    assert!(refusal(&broken).starts_with("line: training point 3 has the terms [1.0, NaN]"));
    broken[3] = Point { power: f64::INFINITY, ..points[3] };
    assert!(refusal(&broken).contains("a power of inf W"));
    assert_eq!(line().predict(&points).unwrap_err().to_string(), "line: not fitted");
    assert!(line().parameters().is_empty());
}

#[test]
fn predicts_nothing_for_what_is_not_finite() {
    let mut points = drive(10, |_| 1.0);
    let mut model = line();
    model.fit(&points).unwrap();
    points[1].speed.vx = f64::NAN;
    points[2].speed.vx = f64::INFINITY;
    let finite: Vec<bool> = model.predict(&points).unwrap().iter().map(|power| power.is_finite()).collect();
    assert_eq!(finite[..4], [true, false, false, true]);
    assert!(model.predict(&points).unwrap()[2].is_nan());
}

/// Data made by its own line, driven both ways. Two well-separated columns: rounding only.
#[test]
fn mei_recovers_its_own_coefficients() {
    let points = drive(500, |point| 0.3 + 7.4 * point.speed.vx.abs());
    recovers(&MEI, &points, &[0.3, 7.4], 1e-9);
}

/// Data made by its own parabola, driven both ways. Scaled, the condition number of 1, |v|, v² over
/// [0, 0.2] m/s is below 1e4: rounding only.
#[test]
fn jaiem_recovers_its_own_coefficients() {
    let points = drive(500, |point| 0.3 + 2.0 * point.speed.vx.abs() + 5.0 * point.speed.vx.powi(2));
    recovers(&JAIEM, &points, &[0.3, 2.0, 5.0], 1e-9);
}

/// Data made by its own plane at 1, 2 and 3 kg: rounding only.
#[test]
fn parasuraman_recovers_its_own_coefficients() {
    let points = drive(500, |point| 0.3 + 2.0 * point.speed.vx.abs() + 0.4 * point.mass);
    recovers(&PARASURAMAN, &points, &[0.3, 2.0, 0.4], 1e-9);
}

/// With one mass, c0 and c2 m cannot be distinguished: the sum is right all the same, to rounding.
#[test]
fn learns_from_one_mass() {
    let mut points = drive(500, |point| 1.1 + 2.0 * point.speed.vx.abs());
    points.iter_mut().for_each(|point| point.mass = 2.0);
    let mut model = PARASURAMAN.make(&burger());
    model.fit(&points).unwrap();
    for (predicted, point) in model.predict(&points).unwrap().iter().zip(&points) {
        assert!((predicted - point.power).abs() < 1e-9, "{predicted} {}", point.power);
    }
}

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
    recovers(&LENG, &points, &[&TRUTH[..], &[9.0, 4.0]].concat(), 1e-9);
}

/// Data made by Eq. 31 itself give its coefficients back.
#[test]
fn recovers_the_coefficients_of_eq_31() {
    let points = drive(2000, |point| common(point) + 0.05 * point.mass);
    recovers(&LINEAR, &points, &[&TRUTH[..], &[0.05]].concat(), 1e-9);
}

/// A log without a pitch column is one of level ground: c7 and c8 stay 0.
#[test]
fn knows_level_ground() {
    let level = |point: Point| Point { readings: Readings::NONE, ..point };
    let points: Vec<Point> = drive(2000, common).into_iter().map(level).collect();
    recovers(&LENG, &points, &[&TRUTH[..], &[0.0, 0.0]].concat(), 1e-9);
}

/// An acceleration that is not known must not pass for none.
#[test]
fn an_unknown_acceleration_is_not_zero() {
    let mut points = drive(100, common);
    let mut model = LENG.make(&burger());
    model.fit(&points).unwrap();
    points[7].acceleration.vx = f64::NAN;
    assert!(model.predict(&points).unwrap()[7].is_nan());
    assert!(model.fit(&points).is_err());
}

/// Data made by its own equation from the wheels' speeds, μ = 0.3 under the Burger's weight at 80
/// mm: rounding only.
#[test]
fn effati_recovers_its_own_parameters() {
    let weight = burger().mass_no_load_kg() * GRAVITY;
    let points = drive(2000, |point| {
        let [left, right] = [0, 1].map(|side| 0.033 * point.wheels[side].speed);
        2.5 * (left.abs() + right.abs()) + 0.3 * weight * 0.08 * point.speed.omega.abs()
    });
    recovers(&EFFATI, &points, &[2.5, 0.3], 1e-9);
}

/// Commanded and measured speed of the Burger's wheels, 33 mm and 160 mm apart, by hand.
fn wheels(point: &Point) -> [f64; 4] {
    let command = point.readings.command;
    let [left, right] = [-0.08, 0.08].map(|arm| (command.vx + arm * command.omega) / 0.033);
    [left, right, point.wheels[0].speed, point.wheels[1].speed]
}

/// Data made by its own equation: rounding, which the likeness of command and feedback (10 % apart,
/// so a condition number near 1e4 of the normal equations) raises to 1e-11.
#[test]
fn linear_recovers_its_own_coefficients() {
    let truth = [0.4, 0.3, 0.1, 0.05, 0.25];
    let points = drive(2000, |point| {
        let powers = wheels(point).into_iter().zip(&truth[1..]).map(|(x, c)| c * x.abs());
        truth[0] + powers.sum::<f64>()
    });
    recovers(&LIU_LINEAR, &points, &truth, 1e-9);
}

/// As above; squares and products of speeds 10 % apart square its condition number to 1e8: 1e-16 ·
/// 1e8 of the largest.
#[test]
fn polynomial_recovers_its_own_coefficients() {
    let points = drive(4000, |point| {
        let [c1, c2, w1, w2] = wheels(point);
        0.4 + 0.3 * c1.abs() + 0.2 * w2.abs() + 0.01 * c1 * c1 + 0.02 * c1 * c2 - 0.03 * w1 * w2
    });
    let mut model = Regression::of_wheels("liu-polynomial", true, &burger());
    model.fit(&points).unwrap();
    let truth = [0.4, 0.3, 0.0, 0.0, 0.2, 0.01, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.03, 0.0];
    let coefficients = model.coefficients().unwrap();
    assert_eq!(coefficients.len(), truth.len());
    for (value, truth) in coefficients.iter().zip(truth) {
        assert!((value - truth).abs() < 1e-8, "{value} {truth}");
    }
}

/// A command that is not known is an error, not a command to stand.
#[test]
fn refuses_unknown_commands() {
    let mut points = drive(100, |_| 1.0);
    points[4].readings.command.omega = f64::NAN;
    let error = LIU_LINEAR.make(&burger()).fit(&points).unwrap_err().to_string();
    assert!(error.starts_with("liu-linear: training point 4 has the terms"), "{error}");
}
