//! Data made by each source's own equation give its parameters back, and a drive follows what
//! changes.

use model_core::effects::GRAVITY;

use super::{MEMORY_S, Online};
use crate::baselines::cards::{LONGITUDINAL, PENTZER, SADRPOUR, SADRPOUR_BAYES};
use crate::baselines::testing::{PERIOD_S, burger, drive, recovers};
use crate::baselines::{Baseline, Point, longitudinal};

fn online() -> Online<{ longitudinal::TERMS }> {
    Online::new("online", &LONGITUDINAL, &burger())
}

/// After ten minutes at 3 N the ground becomes one of 6 N. The training weighs one memory T, which
/// has decayed to T exp(-t/T) after a time t in which the drive has collected T (1 - exp(-t/T)).
/// Where all terms are as excited in both, 3 memories leave exp(-3) = 5 % of the training, so the
/// estimate is within 5 % of the step (doubled: they are not quite); with the training's full ten
/// minutes (weight 10 T) a third would be left.
#[test]
fn follows_a_change_of_ground_within_its_memory() {
    let minute = (60.0 / PERIOD_S) as usize;
    let ground = |force: f64| move |point: &Point| 1.0 + force * longitudinal::terms(point)[1];
    let mut model = online();
    model.fit(&drive(10 * minute, ground(3.0))).unwrap();
    assert!((model.parameters()[1].value - 3.0).abs() < 1e-3);
    let points = drive((3.2 * MEMORY_S / PERIOD_S) as usize, ground(6.0));
    let predicted = model.predict(&points).unwrap();
    let late = (3.0 * MEMORY_S / PERIOD_S) as usize;
    let implied = |i: usize| (predicted[i] - 1.0) / longitudinal::terms(&points[i])[1];
    let fast = |range: std::ops::Range<usize>| range.filter(|i| points[*i].speed.vx.abs() > 0.15);
    let first = fast(0..40).next().unwrap();
    assert!((implied(first) - 3.0).abs() < 0.5, "it starts as trained");
    for i in fast(late..points.len()) {
        let force = implied(i);
        assert!((force - 6.0).abs() < 0.1 * 3.0, "{force} at {}", points[i].time);
    }
}

#[test]
fn refuses_what_it_cannot_learn_from() {
    let mut points = drive(100, |_| 1.0);
    assert!(online().predict(&points).unwrap_err().to_string().contains("not fitted"));
    assert!(online().fit(&points[..2]).unwrap_err().to_string().contains("2 training points"));
    points[3].acceleration.vx = f64::NAN;
    assert!(online().fit(&points).unwrap_err().to_string().starts_with("online: training point 3 has"));
}

/// A robot that only stood has no figure for motion: it keeps 0 there, and predicts standing power
/// at rest.
#[test]
fn learns_standing_from_standing() {
    let mut points = drive(100, |_| 0.7);
    points.iter_mut().for_each(|point| point.speed = Default::default());
    let mut model = online();
    model.fit(&points).unwrap();
    let values: Vec<f64> = model.parameters().iter().map(|parameter| parameter.value).collect();
    assert!((values[0] - 0.7).abs() < 1e-6 && values[1..] == [0.0, 0.0], "{values:?}");
}

/// Data made by its own equation from the wheels' speeds. The start where nothing is known pulls
/// each by less than 1e-5 (see below).
#[test]
fn pentzer_recovers_its_own_parameters() {
    let points = drive(2000, |point| {
        let [left, right] = [0, 1].map(|side| 0.033 * point.wheels[side].speed);
        0.4 + 2.5 * (left.abs() + right.abs()) + 1.2 * (right - left).abs()
    });
    recovers(&PENTZER, &points, &[0.4, 2.5, 1.2], 1e-5);
}

/// A vehicle of M = 4 kg, f = 1.5 N, b = 0.6 W on a road of up to 0.1 rad.
const VEHICLE: [f64; 3] = [0.6, 1.5, 4.0];

fn road() -> Vec<Point> {
    drive(2000, |point| {
        let (v, dv, grade) = (point.speed.vx, point.acceleration.vx, point.readings.pitch);
        let force = 4.0 * (dv + GRAVITY * grade.sin()) + 1.5 * grade.cos() * v.signum();
        0.6 + force * v
    })
}

/// The start where nothing is known pulls each parameter by at most |θ| / (1e6 λ), λ the smallest
/// eigenvalue of XᵀX: above 1 with 2000 points (see `estimator`), so 5e-6 and less than 1e-5 of the
/// smallest parameter; predictions drift with them.
#[test]
fn recursive_recovers_its_own_parameters() {
    recovers(&SADRPOUR, &road(), &VEHICLE, 1e-5);
}

/// Segments of one truth agree but for the weak pull on each towards the mean of all, which is the
/// truth as well: rounding, and the pull of its ridge of 1e-6 as above.
#[test]
fn bayesian_recovers_its_own_parameters() {
    recovers(&SADRPOUR_BAYES, &road(), &VEHICLE, 1e-5);
}
