//! What holds for every network.

use model_core::kinematics::Twist;
use support::metrics::Metrics;

use super::{Baseline, Ending, Network, Point, Settings, perceptron};
use crate::baselines::testing::still;

/// Small enough for a test: 2000 points take 10 steps an epoch.
const SMALL: Settings =
    Settings { learning_rate: 0.005, width: 16, most_epochs: 150, most_points: 2000, ..Settings::PERCEPTRON };

/// Smooth, curved in every input, without vy; incommensurable waves fill the space of inputs.
fn points(first: usize, count: usize) -> Vec<Point> {
    let wave = |i: usize, k: f64| (i as f64 * k).sin();
    let point = |i: usize| {
        let speed = Twist { vx: 0.2 * wave(i, 0.911), vy: 0.0, omega: 2.0 * wave(i, 1.717) };
        let acceleration = Twist { vx: wave(i, 2.323), vy: 0.0, omega: 5.0 * wave(i, 0.531) };
        let mass = 3.0 + 2.0 * wave(i, 0.037);
        let power = 0.3
            + 20.0 * mass * speed.vx.powi(2)
            + 0.5 * speed.omega.powi(2)
            + 0.5 * mass * acceleration.vx * speed.vx
            + 0.05 * acceleration.omega * speed.omega;
        Point { speed, acceleration, mass, power, ..still() }
    };
    (first..first + count).map(point).collect()
}

fn r2(model: &Network, points: &[Point]) -> f64 {
    let mut metrics = Metrics::new(0.0);
    for (point, predicted) in points.iter().zip(model.predict(points).unwrap()) {
        metrics.add(point.power, predicted);
    }
    metrics.quality().unwrap().r2.unwrap()
}

/// The five changing inputs explain the power entirely; what a small network misses of it is under
/// 2 %.
#[test]
fn learns_a_smooth_function() {
    let mut model = perceptron(SMALL);
    model.fit(&points(0, 2000)).unwrap();
    let held_out = r2(&model, &points(5000, 1000));
    assert!(held_out > 0.98, "{held_out} {:?}", model.training());
}

/// A planar robot's power depends on vy as well: the network sees it.
#[test]
fn sees_sideways_motion() {
    let sideways = |mut point: Point| {
        (point.speed.vy, point.speed.vx) = (point.speed.vx, 0.0);
        (point.acceleration.vy, point.acceleration.vx) = (point.acceleration.vx, 0.0);
        point
    };
    let moved = |first, count| points(first, count).into_iter().map(sideways).collect::<Vec<_>>();
    let mut model = perceptron(SMALL);
    model.fit(&moved(0, 2000)).unwrap();
    assert!(r2(&model, &moved(5000, 1000)) > 0.98);
}

#[test]
fn same_seed_same_predictions() {
    let (training, test) = (points(0, 600), points(5000, 100));
    let predict = |seed| {
        let mut model = perceptron(Settings { most_epochs: 3, seed, ..SMALL });
        model.fit(&training).unwrap();
        model.predict(&test).unwrap()
    };
    assert_eq!(predict(1), predict(1));
    assert_ne!(predict(1), predict(2));
}

/// Fitting again forgets the first fit.
#[test]
fn fits_again_from_new_weights() {
    let (training, test) = (points(0, 400), points(5000, 10));
    let mut model = perceptron(Settings { most_epochs: 2, ..SMALL });
    model.fit(&training).unwrap();
    let first = model.predict(&test).unwrap();
    model.fit(&training).unwrap();
    assert_eq!(model.predict(&test).unwrap(), first);
}

/// Every way in which a training ends, provoked; of seven single ReLUs in a row one is almost
/// surely dead from the start.
#[test]
fn names_its_ending() {
    let end = |settings: Settings| {
        let mut model = perceptron(settings);
        let fitted = model.fit(&points(0, 600));
        (model.training().unwrap().ending, fitted)
    };
    let (ending, fitted) = end(Settings { most_epochs: 2, ..SMALL });
    assert!(ending == Ending::EpochLimit && fitted.is_ok());
    let (ending, fitted) = end(Settings { tolerance: 10.0, patience: 2, ..SMALL });
    assert!(ending == Ending::Converged && fitted.is_ok());
    let (ending, fitted) = end(Settings { learning_rate: 1e6, ..SMALL });
    assert!(ending == Ending::Diverged, "{ending:?}");
    assert!(fitted.unwrap_err().to_string().contains("diverged in epoch"));
    let (ending, fitted) = end(Settings { width: 1, most_epochs: 5, ..SMALL });
    assert!(ending == Ending::Dead && fitted.is_ok(), "{ending:?}");
}

#[test]
fn refuses_what_it_cannot_learn_from() {
    let refusal = |settings: Settings, points: &[Point]| {
        let mut model = perceptron(settings);
        let message = model.fit(points).unwrap_err().to_string();
        assert!(model.predict(points).is_err(), "unfitted");
        message
    };
    let good = points(0, 600);
    assert_eq!(
        refusal(SMALL, &good[..199]),
        "mlp: 199 training points; expected at least one mini-batch of 200"
    );
    let mut broken = good.clone();
    broken[7].acceleration.omega = f64::NAN;
    assert!(refusal(SMALL, &broken).starts_with("mlp: training point 7 is not finite"));
    broken[7] = Point { power: f64::INFINITY, ..good[7] };
    assert!(refusal(SMALL, &broken).starts_with("mlp: training point 7 is not finite"));
    assert!(refusal(SMALL, &[good[0]; 300]).contains("never change"));
    assert!(refusal(Settings { batch: 0, ..SMALL }, &good).contains("the mini-batch is 0"));
    assert!(refusal(Settings { hidden_layers: 0, ..SMALL }, &good).contains("hidden layers is 0"));
    assert!(refusal(Settings { learning_rate: -1.0, ..SMALL }, &good).contains("the learning rate is -1"));
}

/// ReLU would make a sound number of NaN.
#[test]
fn predicts_nothing_for_what_is_not_finite() {
    let mut model = perceptron(Settings { most_epochs: 1, ..SMALL });
    model.fit(&points(0, 400)).unwrap();
    let mut test = points(5000, 3);
    test[1].speed.vx = f64::NAN;
    let predicted = model.predict(&test).unwrap();
    assert_eq!(predicted.iter().map(|power| power.is_nan()).collect::<Vec<_>>(), [false, true, false]);
    assert!(model.predict(&[]).unwrap().is_empty());
}
