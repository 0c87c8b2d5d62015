//! Filter, non-negative least squares and the physical fit against SciPy: `reference/make.py` makes
//! the log and the numbers, by its own filter, kinematics and equations.

use std::path::{Path, PathBuf};

use fit::dataset::Reading;
use logs::robot::Robot;

use crate::common::{Bench, NAMES, ROBOT, number};
use model_core::eq18::Gate;
use serde_json::Value;
use support::context::Context;

/// The filter's cutoff of the reference, Hz.
const CUTOFF_HZ: f64 = 3.0;

fn robot() -> String {
    ROBOT.replace("filter_cutoff_hz = 20", &format!("filter_cutoff_hz = {CUTOFF_HZ}"))
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference")
}

fn reference() -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join("reference.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn fit(arguments: &[&str]) -> Value {
    let bench = Bench::new();
    bench.put("robot.toml", robot());
    bench.json(
        &[&["fit", "--robot", "robot.toml", folder().join("log.csv").to_str().unwrap()], arguments].concat(),
    )
}

/// Speed, acceleration and power of the rows behind the filter, settling left out: scipy.signal's
/// Butterworth sections, and the derivative by the trapezium rule. Both round some 50 operations a
/// row; the derivative multiplies by 2/T = 40.
#[test]
fn the_filter_is_scipys() {
    let robot = Robot::parse(&robot()).unwrap();
    let reading = Reading { gate: Gate::Signed, cutoff_hz: None, mass_kg: 1.0 };
    let dataset = fit::read(&Context::default(), &robot, &[folder().join("log.csv")], &reading).unwrap();
    let reference = reference();
    assert_eq!(reference["filtered_rows"], dataset.store.len());
    for expected in reference["filtered"].as_array().unwrap() {
        let [index, w1, w2, a1, a2, power] = numbers(expected)[..] else { panic!("six numbers: {expected}") };
        let row = dataset.store.iter().nth(index as usize).unwrap();
        let [left, right] = row.wheels else { panic!("two wheels") };
        let values = [left.speed, right.speed, left.acceleration, right.acceleration, row.power];
        for (value, expected) in values.into_iter().zip([w1, w2, a1, a2, power]) {
            assert!((value - expected).abs() < 1e-11, "row {index}: {value} {expected}");
        }
    }
}

/// scipy.optimize.nnls solves the rows by Householder, we their Gram matrix: with columns of unit
/// size and a condition of 121 the latter loses 121² = 1.5e4 roundings of 738 sums, 1e-9 at the
/// very most. What is 0 is exactly 0.
#[test]
fn non_negative_least_squares_are_scipys() {
    let report = fit(&["--model", "eq18", "--method", "nnls"]);
    assert_eq!(report["ending"], "optimal");
    let reference = reference();
    let expected = numbers(&reference["nnls"]);
    let parameters = report["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), expected.len());
    for (parameter, expected) in parameters.iter().zip(expected) {
        let value = number(&parameter["value"]);
        if expected == 0.0 {
            assert_eq!(value, 0.0, "{parameter}");
        } else {
            assert!((value / expected - 1.0).abs() < 1e-7, "{parameter}: expected {expected}");
        }
    }
    let rmse = number(&reference["nnls_rmse_w"]);
    assert!((number(&report["rmse_w"]) / rmse - 1.0).abs() < 1e-9, "{rmse}");
}

/// Algorithm 1 on the same problem comes within the 0.1 % in cost, 0.05 % in its root.
#[test]
fn projected_gradients_come_close_to_scipys_optimum() {
    let report = fit(&["--model", "eq18", "--method", "pgd"]);
    let rmse = number(&reference()["nnls_rmse_w"]);
    let excess = number(&report["rmse_w"]) / rmse - 1.0;
    assert!((-1e-9..5e-4).contains(&excess), "{excess}");
    assert!(
        (number(&report["pgd"]["excess_cost"]) - ((1.0 + excess).powi(2) - 1.0)).abs() < 1e-6,
        "{report}"
    );
}

/// scipy.optimize.least_squares on the same six parameters with bounds at 0. Huber's limit is 4
/// standard deviations and the largest of these Gaussian residuals 2.7 (make.py asserts it), so all
/// weights are 1 and the two problems are one. Ours is done when a round moves no parameter by more
/// than 1e-4 of itself; with the same weights and no wheel clamped, the round before was the same
/// problem, so what is left is what Levenberg–Marquardt leaves: cost gains below 1e-13 of ΣP²,
/// which with a condition of some 300 is 3e-7 · 300 = 1e-4 in the parameters.
#[test]
fn the_physical_fit_is_scipys_least_squares() {
    let report = fit(&[]);
    assert!(report["ending"].as_str().unwrap().starts_with("converged-by-"), "{report}");
    assert_eq!(number(&report["idle_share"]), 0.0, "no row of this log is clamped");
    let reference = reference();
    let parameters = report["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 6);
    for ((parameter, expected), name) in
        parameters.iter().zip(numbers(&reference["least_squares"])).zip(NAMES)
    {
        assert_eq!(parameter["name"], name);
        let value = number(&parameter["value"]);
        println!("{name}: {:.1e} off", value / expected - 1.0);
        assert!((value / expected - 1.0).abs() < 1e-4, "{parameter}: expected {expected}");
    }
    let rmse = number(&reference["least_squares_rmse_w"]);
    assert!((number(&report["rmse_w"]) / rmse - 1.0).abs() < 1e-6, "{rmse}");
}

/// The truth that the log was made with lies within four of the stated standard errors of every
/// parameter.
#[test]
fn stated_errors_contain_the_truth_of_the_log() {
    let report = fit(&[]);
    for (parameter, truth) in report["parameters"].as_array().unwrap().iter().zip(crate::common::TRUTH) {
        let distance = (number(&parameter["value"]) - truth).abs() / number(&parameter["std_err"]);
        println!("{}: {distance:.2} standard errors", parameter["name"]);
        assert!(distance < 4.0, "{parameter}: truth {truth}");
    }
}
