//! Does the published learning rate train seven layers reliably? Ten seeds on simulated logs;
//! minutes, so on demand:
//!
//! `cargo test --release -p host-tools --test suite network_seeds -- --ignored --nocapture`

use std::path::Path;
use std::time::Instant;

use assert_cmd::Command;
use fit::dataset::Reading;
use logs::robot::Robot;
use model_core::eq18::Gate;
use study::baselines::network::{Ending, Network, Settings, perceptron};
use study::baselines::{Baseline, Point};
use support::context::Context;
use support::metrics::{Metrics, Quality};

fn simulated(folder: &Path, arguments: &str) -> Vec<Point> {
    let log = folder.join("log.csv");
    let mut command = Command::cargo_bin("gmr").expect("gmr is built with its tests");
    command.arg("simulate").args(arguments.split(' ')).arg("--out").arg(&log).assert().success();
    let robot = Robot::named("burger").expect("built in");
    let reading = Reading { gate: Gate::Signed, cutoff_hz: Some(1.0), mass_kg: 1.0 };
    let dataset = fit::read(&Context::default(), &robot, &[log], &reading).expect("a log of the simulator");
    dataset.store.iter().map(|row| Point::new(&dataset.robot, &row.owned())).collect()
}

fn quality(model: &Network, points: &[Point]) -> Quality {
    let mut metrics = Metrics::new(0.1);
    for (point, predicted) in points.iter().zip(model.predict(points).expect("fitted")) {
        metrics.add(point.power, predicted);
    }
    metrics.quality().expect("there are points")
}

/// Every seed ends by tolerance, and explains more of an unseen profile than 0.8.
fn trains_with_ten_seeds(training: &str, test: &str) {
    let folder = tempfile::tempdir().unwrap();
    let (training, test) = (simulated(folder.path(), training), simulated(folder.path(), test));
    for seed in 1..=10 {
        let mut model = perceptron(Settings { seed, ..Settings::PERCEPTRON });
        let started = Instant::now();
        model.fit(&training).unwrap();
        let time = started.elapsed().as_secs_f64();
        let course = *model.training().unwrap();
        let (known, unseen) = (quality(&model, &training).r2.unwrap(), quality(&model, &test).r2.unwrap());
        println!("seed {seed}: {time:.1} s, R² {known:.4} trained, {unseen:.4} unseen, {course:?}");
        assert_eq!(course.ending, Ending::Converged);
        assert!(unseen > 0.8);
    }
}

#[test]
#[ignore = "minutes"]
fn servo_with_sensors() {
    trains_with_ten_seeds(
        "--plant servo --sensors servo --mass 1@0,3@50,5@100,2@150",
        "--plant servo --sensors servo --profile test --mass 2@0,3@100 --seed 2",
    );
}

#[test]
#[ignore = "minutes"]
fn table3_exact() {
    trains_with_ten_seeds(
        "--plant table3 --duration 300 --mass 1@0,3@50,5@100,2@150,6@200,4@250",
        "--plant table3 --profile test --mass 2@0,3@100 --seed 2",
    );
}
