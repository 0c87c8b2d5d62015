//! Baselines against NumPy, SciPy and scikit-learn: `reference/baselines/make.py` makes the log and
//! the numbers, by its own kinematics, motors and solvers.
//!
//! What has no public way in (the likelihood of the Gaussian process, the derivatives of the
//! network) is compared by unit tests beside it.

use logs::robot::chassis::Wheels;
use std::path::{Path, PathBuf};

use logs::robot::Robot;
use study::baselines::network::{Ending, Settings, perceptron};
use study::baselines::{Baseline, Card, Point, Readings, cards};
use support::metrics::Metrics;

use crate::common::number;
use model_core::kinematics::Twist;
use model_core::motion::Motion;
use serde_json::Value;

/// Rows of the log that train; the others are a run of their own.
const TRAINING: usize = 360;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/baselines")
}

fn reference() -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("reference.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn robot(name: &str) -> Robot {
    Robot::named(name).unwrap()
}

/// A point of a robot whose left and right wheels move so; without a dead band.
fn point(robot: &Robot, speed: [f64; 2], acceleration: [f64; 2]) -> Point {
    let core = robot.core::<2>(1.0).unwrap();
    Point {
        run: 0,
        time: 0.0,
        speed: core.kinematics.twist(&speed),
        acceleration: core.kinematics.twist(&acceleration),
        wheels: Wheels::from(Motion::new(&speed, &acceleration, &core.mass_matrix, 0.0).wheels),
        mass: 1.0,
        power: 0.0,
        readings: Readings::NONE,
    }
}

/// The log with one of its powers.
fn log(robot: &Robot, power: &str) -> Vec<Point> {
    let text = std::fs::read_to_string(folder().join("log.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let read = |line: &str| {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
        let of = |name: &str| values[header.iter().position(|column| *column == name).unwrap()];
        let moving = point(robot, [of("wl"), of("wr")], [of("al"), of("ar")]);
        let command = Twist { vx: of("cmd_v"), vy: 0.0, omega: of("cmd_omega") };
        Point {
            run: of("run") as u32,
            time: of("time_s"),
            mass: of("mass_kg"),
            power: of(power),
            readings: Readings { command, pitch: of("pitch_rad"), ..Readings::NONE },
            ..moving
        }
    };
    let points: Vec<Point> = lines.map(read).collect();
    assert_eq!(points.len(), 480);
    points
}

fn fitted(card: &Card, robot: &Robot, training: &[Point]) -> Box<dyn Baseline> {
    let mut model = card.make(robot);
    model.fit(training).unwrap();
    model
}

fn values(model: &dyn Baseline) -> Vec<f64> {
    model.parameters().iter().map(|parameter| parameter.value).collect()
}

/// The largest difference, over the largest expected number.
fn apart(values: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(values.len(), expected.len(), "{values:?} {expected:?}");
    let largest = expected.iter().map(|value| value.abs()).fold(0.0, f64::max);
    values
        .iter()
        .zip(expected)
        .map(|(value, expected)| {
            assert!(value.is_finite(), "{value:?}");
            (value - expected).abs() / largest
        })
        .fold(0.0, f64::max)
}

/// Regressions by `numpy.linalg.lstsq`, which solves the rows where ours solves the Gram matrix:
/// that squares the condition of the columns, at most 21 for all but the polynomial, and loses 21²
/// · 360 roundings of 1e-16: 2e-11. The polynomial's has 800² · 360 · 1e-16 = 3e-8, if all
/// roundings add up. That is of the largest share of the power: of a coefficient whose share is a
/// hundredth, it is a hundred times as much.
#[test]
fn regressions_are_numpys_least_squares() {
    let (robot, reference) = (robot("burger"), reference());
    let points = log(&robot, "road_w");
    let (training, unseen) = points.split_at(TRAINING);
    let cards = [
        &cards::MEI,
        &cards::JAIEM,
        &cards::PARASURAMAN,
        &cards::LENG,
        &cards::LINEAR,
        &cards::EFFATI,
        &cards::LIU_LINEAR,
        &cards::LIU_POLYNOMIAL,
    ];
    for card in cards {
        let expected = &reference["regressions"][card.name];
        let model = fitted(card, &robot, training);
        let within = if card.name == cards::LIU_POLYNOMIAL.name { 3e-8 } else { 2e-11 };
        let distance = apart(&model.predict(unseen).unwrap(), &numbers(&expected["predicted"]));
        println!("{}: predictions {distance:.1e} apart", card.name);
        assert!(distance < within, "{}: {distance}", card.name);
        if card.name != cards::LIU_POLYNOMIAL.name {
            for (value, expected) in values(&*model).iter().zip(numbers(&expected["coefficients"])) {
                assert!((value / expected - 1.0).abs() < 100.0 * within, "{}: {value} {expected}", card.name);
            }
        }
    }
}

/// Recursive least squares against weighted least squares of all rows before each row, solved anew.
/// The covariance begins at 1e6, so that its first steps cancel to 1e6 · 1e-16 = 1e-10 in
/// parameters and terms of order 1 to 10.
#[test]
fn recursive_least_squares_are_the_batch_of_what_was_seen() {
    let (robot, reference) = (robot("burger"), reference());
    let points = log(&robot, "road_w");
    let (training, unseen) = points.split_at(TRAINING);
    for card in [&cards::SADRPOUR, &cards::PENTZER] {
        let predicted = fitted(card, &robot, training).predict(unseen).unwrap();
        let distance = apart(&predicted, &numbers(&reference[card.name]));
        println!("{}: {distance:.1e} apart", card.name);
        assert!(distance < 1e-10, "{}: {distance}", card.name);
    }
}

/// The prior's mean, and the posterior's predictions in closed form from all rows before each row.
/// Rounding: 1e-16 times the ratio of the prior's variances to the noise over a row, below 1e4, and
/// a hundred rows.
#[test]
fn the_bayesian_update_is_the_closed_form() {
    let (robot, reference) = (robot("burger"), reference());
    let points = log(&robot, "road_w");
    let (training, unseen) = points.split_at(TRAINING);
    let expected = &reference["sadrpour-bayes"];
    let model = fitted(&cards::SADRPOUR_BAYES, &robot, training);
    let prior = apart(&values(&*model), &numbers(&expected["prior_mean"]));
    let distance = apart(&model.predict(unseen).unwrap(), &numbers(&expected["predicted"]));
    println!("prior {prior:.1e}, predictions {distance:.1e} apart");
    assert!(prior < 2e-11 && distance < 1e-10, "{prior} {distance}");
}

/// Nonlinear least squares with bounds. Ours ends when a step gains less than 1e-5 of the cost;
/// were that still to be gained, the constants would be off by √(1e-5 · 354) = 0.06 of their
/// standard errors. That step is taken, and Gauss and Newton leave a tenth of it at most where
/// residuals are some hundredths of the power.
#[test]
fn known_dynamics_are_scipys_least_squares() {
    let (robot, reference) = (robot("burger"), reference());
    let points = log(&robot, "level_w");
    let training = &points[..TRAINING];
    let model = fitted(&cards::JARAMILLO, &robot, training);
    let expected = &reference["jaramillo"];
    let [constants, errors] = ["constants", "standard_errors"].map(|name| numbers(&expected[name]));
    for ((ours, expected), error) in model.parameters().iter().zip(constants).zip(errors) {
        let distance = (ours.value - expected).abs() / error;
        println!("{} {}: {distance:.1e} standard errors from {expected}", ours.name, ours.value);
        assert!(distance < 6e-3, "{ours:?} {expected}");
    }
    let squares = training.iter().zip(model.predict(training).unwrap());
    let squares: f64 = squares.map(|(point, predicted)| (point.power - predicted).powi(2)).sum();
    let excess = (squares / TRAINING as f64).sqrt() / number(&expected["rmse_w"]) - 1.0;
    assert!((-1e-9..1e-5).contains(&excess), "{excess}");
}

/// Bounded linear least squares by an active set on the rows, where ours has their Gram matrix:
/// with columns of unit size and a condition below 24, 24² · 360 roundings of 1e-16, 2e-11 of the
/// largest share of the power; the smallest is a hundredth of it. What is 0 is exactly 0.
#[test]
fn physics_based_models_are_scipys_bounded_least_squares() {
    let reference = reference();
    let (burger, husky) = (robot("burger"), robot("husky"));
    let (burgers, huskys) = (log(&burger, "physics_w"), log(&husky, "skid_w"));
    let cases = [
        (&cards::WAHAB, &burger, &burgers),
        (&cards::TOUZOUT, &burger, &burgers),
        (&cards::DOGRU, &husky, &huskys),
    ];
    for (card, robot, points) in cases {
        let model = fitted(card, robot, &points[..TRAINING]);
        let expected = numbers(&reference[card.name]);
        assert_eq!(model.parameters().len(), expected.len());
        for (ours, expected) in model.parameters().iter().zip(expected) {
            println!("{} {}: {} {expected}", card.name, ours.name, ours.value);
            if expected == 0.0 {
                assert_eq!(ours.value, 0.0, "{}: {ours:?}", card.name);
            } else {
                assert!((ours.value / expected - 1.0).abs() < 2e-9, "{}: {ours:?} {expected}", card.name);
            }
        }
    }
}

/// Straight on, each speed (rad/s) held for a period up to its point, and the torque of each of the
/// two wheels (N m).
fn straight(robot: &Robot, of: &Value) -> Vec<Point> {
    let (speeds, torques) = (numbers(&of["speeds"]), numbers(&of["torques"]));
    let at = |(index, (w, torque)): (usize, (f64, f64))| Point {
        time: 0.05 * index as f64,
        power: 2.0 * torque * w,
        ..point(robot, [w, w], [0.0, 0.0])
    };
    speeds.into_iter().zip(torques).enumerate().map(at).collect()
}

/// LuGre friction by SciPy's stiff solver. The Stribeck curve, where bristles have bent to the end,
/// gives the constants of its differential equation back: the solver errs by 1e-9, and the search
/// for vs ends a millionth of two steps of its grid wide, a factor of 0.65 each: 1e-6, which the
/// other constants share. In creeping to and fro the torque is that of bristles which SciPy bends
/// in metres.
#[test]
fn bristles_bend_as_in_scipys_stiff_solver() {
    let (robot, reference) = (robot("burger"), &reference()["lugre"]);
    let curve = straight(&robot, &reference["stribeck"]);
    let model = fitted(&cards::ANJUM, &robot, &curve);
    let [_, _, constants @ ..] = &values(&*model)[..] else { panic!("m and I first") };
    for (constant, expected) in constants.iter().zip(numbers(&reference["constants"])) {
        println!("{constant}: {:.1e} off", constant / expected - 1.0);
        assert!((constant / expected - 1.0).abs() < 3e-6, "{constant} {expected}");
    }
    let creep = straight(&robot, &reference["creep"]);
    let torque = |(point, power): (&Point, f64)| power / (2.0 * point.wheels[0].speed);
    let torques: Vec<f64> = creep.iter().zip(model.predict(&creep).unwrap()).map(torque).collect();
    let distance = apart(&torques, &numbers(&reference["creep"]["torques"]));
    println!("creeping: {distance:.1e} apart");
    assert!(distance < 3e-6, "{distance}");
}

/// Seven layers of 32, trained by us and by scikit-learn with eight seeds each, on a run that none
/// has seen. Of the 64 pairs of one of ours and one of theirs, ours is ahead in 8 to 56 for 99 of
/// 100 draws from one distribution (Mann and Whitney 1947).
#[test]
fn perceptrons_learn_as_well_as_scikit_learns() {
    let (robot, reference) = (robot("burger"), reference());
    let points = log(&robot, "level_w");
    let (training, unseen) = points.split_at(TRAINING);
    let quality = |seed: u64| {
        let mut model = perceptron(Settings { seed, ..Settings::PERCEPTRON });
        model.fit(training).unwrap();
        assert!(matches!(model.training().unwrap().ending, Ending::Converged | Ending::EpochLimit));
        let mut metrics = Metrics::new(0.1);
        for (point, predicted) in unseen.iter().zip(model.predict(unseen).unwrap()) {
            metrics.add(point.power, predicted);
        }
        metrics.quality().unwrap().r2.unwrap()
    };
    let ours: Vec<f64> = (1..=8).map(quality).collect();
    let theirs = numbers(&reference["perceptron_r2"]);
    assert_eq!(theirs.len(), ours.len());
    let ahead: usize = ours.iter().map(|ours| theirs.iter().filter(|theirs| ours > theirs).count()).sum();
    println!("R² {ours:.3?}, scikit-learn {theirs:.3?}: ahead in {ahead} pairs");
    assert!((8..=56).contains(&ahead), "{ours:?} {theirs:?}");
}
