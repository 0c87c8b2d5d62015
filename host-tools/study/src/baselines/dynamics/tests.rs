//! Data made by each source's own assumptions give its constants back.

use model_core::effects::GRAVITY;
use model_core::motion::Wheel;

use crate::baselines::cards::{JARAMILLO, KIM, MORALES, YACOUB, YAO};
use crate::baselines::testing::{burger, drive, predict_one_speed, recovers};
use crate::baselines::{Card, Point};

const RESISTANCE: f64 = 2.0;
/// n Kt = n Ke, N m/A.
const TORQUE_CONSTANT: f64 = 0.16;
const KAPPA: f64 = RESISTANCE / (TORQUE_CONSTANT * TORQUE_CONSTANT);

/// V i of a motor at this torque and speed of the wheel.
fn motor(torque: f64, speed: f64) -> f64 {
    let current = torque / TORQUE_CONSTANT;
    let voltage = RESISTANCE * current + TORQUE_CONSTANT * speed;
    voltage * current
}

fn power(point: &Point, torque: impl Fn(&Wheel<f64>) -> f64) -> f64 {
    point.wheels.iter().map(|wheel| motor(torque(wheel), wheel.speed)).sum()
}

/// Without noise the last step gains less than 1e-12 of Σ P², so the residual before it was below
/// 1e-6 of the power, and the step itself is a Gauss–Newton one: what is left is 1e-6 times the
/// condition of these drives, below a hundred.
const WITHIN: f64 = 1e-4;

#[test]
fn kim_recovers_its_constants() {
    let points = drive(2000, |point| {
        power(point, |wheel| 2e-3 * wheel.speed + 1e-3 * wheel.acceleration + 1.4 * wheel.inertial_torque)
    });
    assert!(points.iter().any(|point| point.power < 0.0), "braking is in the data");
    recovers(&KIM, &points, &[KAPPA, 2e-3, 1e-3, 1.4], WITHIN);
}

/// The Burger's drives clamp: the power of each wheel does not fall below 0.
#[test]
fn jaramillo_recovers_its_constants_at_several_payloads() {
    let points = drive(2000, |point| {
        let torque = |wheel: &Wheel<f64>| {
            (0.01 + 0.004 * point.mass) * wheel.speed.signum()
                + 1e-3 * wheel.speed
                + 5e-4 * wheel.acceleration
                + 1.2 * point.mass * wheel.inertial_torque
        };
        let of = |wheel: &Wheel<f64>| motor(torque(wheel), wheel.speed).max(0.0);
        point.wheels.iter().filter(|wheel| wheel.direction != 0.0).map(of).sum()
    });
    recovers(&JARAMILLO, &points, &[KAPPA, 0.01, 0.004, 1e-3, 5e-4, 1.2], WITHIN);
}

#[test]
fn morales_recovers_its_constants() {
    let points = drive(2000, |point| {
        power(point, |wheel| {
            0.015 * wheel.direction
                + 1e-3 * wheel.speed
                + 5e-4 * wheel.acceleration
                + 1.4 * wheel.inertial_torque
        })
    });
    recovers(&MORALES, &points, &[KAPPA, 0.015, 1e-3, 5e-4, 1.4], WITHIN);
}

#[test]
fn yacoub_recovers_its_constants_on_a_road() {
    let points = drive(2000, |point| {
        let torque = |wheel: &Wheel<f64>| {
            0.02 * wheel.direction
                + 1e-3 * wheel.speed
                + 0.03 * (point.acceleration.vx + GRAVITY * point.readings.pitch.sin())
        };
        let of = |wheel: &Wheel<f64>| motor(torque(wheel), wheel.speed).max(0.0);
        point.wheels.iter().filter(|wheel| wheel.direction != 0.0).map(of).sum()
    });
    recovers(&YACOUB, &points, &[KAPPA, 0.02, 1e-3, 0.03, 0.03], WITHIN);
}

#[test]
fn yao_recovers_its_constants() {
    let points = drive(2000, |point| power(point, |wheel| 0.02 * wheel.direction + 1e-3 * wheel.speed));
    recovers(&YAO, &points, &[KAPPA, 0.02, 1e-3], WITHIN);
}

const ALL: [&Card; 5] = [&KIM, &JARAMILLO, &MORALES, &YACOUB, &YAO];

#[test]
fn poor_drives_give_finite_powers() {
    predict_one_speed(&ALL);
}

/// Power that does not grow with the speed is all winding loss, which determines only the product
/// of κ and the torques.
#[test]
fn power_that_knows_no_speed_ends_the_search() {
    let points = drive(2000, |point| 2.0 + 0.3 * (91.0 * point.time).sin());
    for card in [&JARAMILLO, &MORALES, &YACOUB, &YAO] {
        let mut model = card.make(&burger());
        model.fit(&points).unwrap();
        let moving = model.predict(&points[1..]).unwrap();
        let mean = moving.iter().sum::<f64>() / moving.len() as f64;
        // The wave has a mean of a hundredth of a watt; the search leaves a mechanical share of a
        // few per cent.
        assert!((mean - 2.0).abs() < 0.1, "{}: {mean} W", card.name);
    }
}
