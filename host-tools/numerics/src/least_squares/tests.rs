//! Against SciPy, and the laws of scores.

mod noise;

use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use super::{FurtherColumn, LeastSquaresError, NormalEquations, Prior};

/// `make.py` beside the numbers wrote them.
const REFERENCE: &str = include_str!("../../../tests/reference/numerics/prior_least_squares.json");

struct Reference(Value);

impl Reference {
    fn read() -> Self {
        Self(serde_json::from_str(REFERENCE).unwrap())
    }

    fn number(&self, key: &str) -> f64 {
        self.0[key].as_f64().unwrap()
    }

    fn vector(&self, key: &str) -> DVector<f64> {
        numbers(&self.0[key]).into()
    }

    fn matrix(&self, key: &str) -> DMatrix<f64> {
        let rows: Vec<Vec<f64>> = self.0[key].as_array().unwrap().iter().map(numbers).collect();
        DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
    }

    fn prior(&self) -> Prior {
        Prior { precision: self.matrix("precision"), offset: self.vector("offset") }
    }
}

fn numbers(values: &Value) -> Vec<f64> {
    values.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

/// The condition of the scaled normal matrix is some 1e3; a thousand roundings on top are 1e-10.
fn assert_close(value: f64, expected: f64, what: &str) {
    assert!((value - expected).abs() <= 1e-10 * expected.abs(), "{what}: {value} {expected}");
}

/// The whole panel: slopes, the further column, the residual; per root of the weight.
fn products(reference: &Reference) -> DMatrix<f64> {
    let (slopes, weights) = (reference.matrix("slopes"), reference.vector("weights"));
    let columns: Vec<DVector<f64>> = slopes
        .column_iter()
        .map(|column| column.into_owned())
        .chain([reference.vector("further"), reference.vector("residual")])
        .map(|column| column.component_mul(&weights.map(f64::sqrt)))
        .collect();
    let panel = DMatrix::from_columns(&columns);
    panel.tr_mul(&panel)
}

#[test]
fn solution_covariance_and_loss_are_scipys() {
    let reference = Reference::read();
    let (slopes, weights) = (reference.matrix("slopes"), reference.vector("weights"));
    let residual = reference.vector("residual");
    let mut by_rows = NormalEquations::zeros(slopes.ncols());
    for ((row, residual), weight) in slopes.row_iter().zip(&residual).zip(&weights) {
        by_rows.add_row(row.transpose().as_slice(), *residual, *weight);
    }
    let by_products = NormalEquations::from_products(&products(&reference), &[0, 1, 2, 3]);
    for mut problem in [by_rows, by_products] {
        problem.add_prior(&reference.prior());
        let factored = problem.factor(0.0).unwrap();
        for (value, expected) in factored.solution().iter().zip(&reference.vector("solution")) {
            assert_close(*value, *expected, "solution");
        }
        for (value, expected) in factored.covariance().iter().zip(&reference.matrix("covariance")) {
            assert_close(*value, *expected, "covariance");
        }
        assert_close(factored.loss(), reference.number("loss"), "loss");
    }
}

/// A score is the coefficient that the column gets where it is in the problem itself, and its
/// square is what that gains.
#[test]
fn a_score_is_the_regression_coefficients_z() {
    let reference = Reference::read();
    let all = products(&reference);
    let mut problem = NormalEquations::from_products(&all, &[0, 1, 2, 3]);
    problem.add_prior(&reference.prior());
    let factored = problem.factor(0.0).unwrap();
    let score = factored.score(&FurtherColumn::from_products(&all, &[0, 1, 2, 3], 4), 0.0).unwrap();
    let (value, std_err) = (reference.number("further_value"), reference.number("further_std_err"));
    assert_close(score.value(), value, "value");
    assert_close(score.std_err(), std_err, "standard error");
    assert_close(score.z(), value / std_err, "z");
    assert_close(score.z().powi(2), factored.loss() - reference.number("loss_with_further"), "gain");
}

#[test]
fn what_the_others_take_has_no_score() {
    let reference = Reference::read();
    let all = products(&reference);
    let factored = NormalEquations::from_products(&all, &[0, 1, 2, 3]).factor(0.0).unwrap();
    let one_of_them = FurtherColumn::from_products(&all, &[0, 1, 2, 3], 2);
    assert!(factored.score(&one_of_them, 1e-9).is_none());
    let none = FurtherColumn { along: DVector::zeros(4), residual: 0.0, square: 0.0 };
    assert!(factored.score(&none, 0.0).is_none());
}

/// Two equal columns: refused; with a ridge they share; with one held at 0 the other takes all.
#[test]
fn columns_that_repeat_each_other_are_told() {
    let mut problem = NormalEquations::zeros(2);
    for x in [1.0, 2.0, 4.0] {
        problem.add_row(&[x, x], 6.0 * x, 1.0);
    }
    assert_eq!(problem.clone().factor(0.0).unwrap_err(), LeastSquaresError::NotPositiveDefinite);
    let shared = problem.clone().factor(1e-10).unwrap().solution();
    assert!((shared[0] - 3.0).abs() < 1e-5 && (shared[1] - 3.0).abs() < 1e-5, "{shared}");
    let mut held = problem.clone();
    held.hold(1, 1e-4);
    let held = held.factor(0.0).unwrap().solution();
    assert!((held[0] - 6.0).abs() < 1e-5 && held[1].abs() < 1e-5, "{held}");
    problem.add_row(&[f64::NAN, 1.0], 1.0, 1.0);
    assert_eq!(problem.factor(0.0).unwrap_err(), LeastSquaresError::NotFinite);
}

/// A prior of precision p on a mean over n rows of unit weight leaves n/(n + p) of a parameter to
/// the data.
#[test]
fn determined_parameters_are_counted() {
    let mut problem = NormalEquations::zeros(1);
    for _ in 0..6 {
        problem.add_row(&[1.0], 1.0, 1.0);
    }
    let data = problem.matrix().clone();
    problem.hold(0, 0.5);
    assert!((problem.factor(0.0).unwrap().determined(&data) - 0.6).abs() < 1e-12);
}
