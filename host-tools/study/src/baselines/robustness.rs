//! What every baseline has to withstand: a clear error at `fit`, or finite answers.

use logs::robot::chassis::Wheels;
use model_core::kinematics::Twist;
use model_core::motion::Wheel;

use super::testing::{burger, drive, wheels};
use super::{ALL, Card, Layout, Point};

/// Every baseline that knows the Burger; without the networks, whose training takes long.
fn cards() -> impl Iterator<Item = &'static Card> {
    let fits = |card: &&&Card| card.layouts.is_empty() || card.layouts.contains(&Layout::of(&burger()));
    ALL.iter().copied().filter(|card| !card.is_network()).filter(move |card| fits(&card))
}

fn power(point: &Point) -> f64 {
    0.5 + 3.0 * point.speed.vx.abs() + 0.2 * point.speed.omega.abs() + 0.1 * (37.0 * point.time).sin()
}

/// A drive of 60 s, changed at every point.
fn changed(change: impl Fn(&mut Point)) -> Vec<Point> {
    let mut points = drive(1200, power);
    points.iter_mut().for_each(change);
    points
}

/// Trained and tested on the same drive, no power exceeds three times the highest of the training;
/// a singular matrix would make far larger ones. Or a refusal names the baseline.
fn bears(what: &str, points: &[Point]) {
    let highest = points.iter().map(|point| point.power.abs()).fold(0.0, f64::max);
    for card in cards() {
        let mut model = card.make(&burger());
        if let Err(error) = model.fit(points) {
            assert!(error.to_string().contains(card.name), "{what}: {error}");
            continue;
        }
        for power in model.predict(points).unwrap() {
            assert!(power.abs() <= 3.0 * highest, "{what}: {} says {power} W", card.name);
        }
    }
}

/// Moves so, instead.
fn moving(point: &mut Point, speed: Twist<f64>, acceleration: Twist<f64>) {
    (point.speed, point.acceleration) = (speed, acceleration);
    point.wheels = wheels(speed, acceleration);
}

/// Of body and wheels, as measured and as commanded.
fn unknown_motion(point: &mut Point) {
    let unknown = Twist { vx: f64::NAN, vy: f64::NAN, omega: f64::NAN };
    (point.speed, point.acceleration, point.readings.command) = (unknown, unknown, unknown);
    let wheel =
        Wheel { speed: f64::NAN, acceleration: f64::NAN, inertial_torque: f64::NAN, ..Wheel::default() };
    point.wheels = Wheels::from([wheel; 2]);
}

fn unknown_power(point: &mut Point) {
    point.power = f64::NAN;
}

#[test]
fn drives_that_lack_something() {
    const STILL: Twist<f64> = Twist { vx: 0.0, vy: 0.0, omega: 0.0 };
    let straight = |twist: Twist<f64>| Twist { omega: 0.0, ..twist };
    bears("one mass", &changed(|point| point.mass = 2.0));
    bears("one speed", &changed(|point| moving(point, Twist { vx: 0.2, ..STILL }, STILL)));
    bears("standing", &changed(|point| moving(point, STILL, STILL)));
    bears("no turns", &changed(|point| moving(point, straight(point.speed), straight(point.acceleration))));
    bears("level ground", &changed(|point| point.readings.pitch = f64::NAN));
    bears("no power", &changed(|point| point.power = 0.0));
}

/// Training with a hole is refused by name, and leaves the model unfitted.
#[test]
fn trainings_that_are_not_finite() {
    for card in cards() {
        for hole in [unknown_power, unknown_motion] {
            let mut points = changed(|_| {});
            hole(&mut points[77]);
            let mut model = card.make(&burger());
            let Err(error) = model.fit(&points) else { panic!("{} takes it", card.name) };
            assert!(error.to_string().contains(card.name), "{error}");
            assert!(model.predict(&points).is_err() && model.parameters().is_empty(), "{}", card.name);
        }
    }
}

/// A point that is not finite gets no power and does not affect others; neither does an unknown
/// power.
#[test]
fn tests_that_are_not_finite() {
    let mut points = changed(|_| {});
    unknown_motion(&mut points[77]);
    unknown_power(&mut points[78]);
    for card in cards() {
        let mut model = card.make(&burger());
        // No baseline models this power: one may refuse it, and has a test on data of its own.
        if let Err(error) = model.fit(&changed(|_| {})) {
            assert!(error.to_string().contains(card.name), "{error}");
            continue;
        }
        for (index, power) in model.predict(&points).unwrap().iter().enumerate() {
            assert_eq!(power.is_nan(), index == 77, "{} says {power} W of point {index}", card.name);
        }
    }
}
