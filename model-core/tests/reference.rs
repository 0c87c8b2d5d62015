//! Against numbers from NumPy and SciPy: `reference.py` writes them, this reads them, in both
//! precisions.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::burger;
use model_core::eq18::{self, Gate};
use model_core::filter::{Channel, LowPass};
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Response};
use model_core::motion::Motion;
use model_core::payload::window::{Sums, Window};
use model_core::payload::{Method, Noise};
use model_core::polynomial::Polynomial;
use model_core::real::Real;

fn table(text: &str) -> Vec<Vec<f64>> {
    text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

/// Largest errors of value and derivative, the input's magnitude being up to 8.
fn filter_errors<T: Real>(cutoff: f64, rate: f64, first_column: usize) -> (f64, f64) {
    let filter = LowPass::<T>::new(cutoff, 1.0 / rate).unwrap();
    let rows = table(include_str!("reference/filter.csv"));
    let mut channel = Channel::default();
    filter.settle(&mut channel, T::from_f64(rows[0][first_column]));
    let mut worst = (0.0_f64, 0.0_f64);
    for row in &rows {
        let (input, value, derivative) = (row[first_column], row[first_column + 1], row[first_column + 2]);
        let out = filter.step(&mut channel, T::from_f64(input));
        worst.0 = worst.0.max((out.value.to_f64() - value).abs());
        worst.1 = worst.1.max((out.derivative.to_f64() - derivative).abs());
    }
    worst
}

/// A second-order section with k = tan(π f / f_s) answers a lasting error of its state with 1 / (4
/// k²) of it (250 at 2 Hz of 200, 2.4 at 5 Hz of 50), and a white one, remembered for 1 / k steps,
/// with √k of that. A rounding of a number up to 8 is 8 ε/√12, some six of them a step and section:
/// 8 ε standard deviation for both sections. Of 1200 samples the worst stays within 4 of them,
/// doubled for the rounding of a1 and a2, which moves the poles by as much. The derivative is 2 k /
/// T = 12.6 and 32 per second times the difference of two such numbers.
fn filter_tolerance(epsilon: f64, cutoff: f64, rate: f64) -> (f64, f64) {
    let k = (std::f64::consts::PI * cutoff / rate).tan();
    let value = 8.0 * 8.0 * epsilon * (1.0 / (4.0 * k * k)).max(1.0) * k.sqrt();
    (value, 2.0 * value * 2.0 * k * rate)
}

#[test]
fn filter_is_scipys_butterworth() {
    for (cutoff, rate, column) in [(2.0, 200.0, 0), (5.0, 50.0, 3)] {
        let (value, derivative) = filter_errors::<f64>(cutoff, rate, column);
        let (value_bound, derivative_bound) = filter_tolerance(f64::EPSILON, cutoff, rate);
        println!("f64: {value:e} of {value_bound:e}, {derivative:e} of {derivative_bound:e}");
        // SciPy's own sections round as much.
        assert!(value <= 2.0 * value_bound && derivative <= 2.0 * derivative_bound);
        let (value, derivative) = filter_errors::<f32>(cutoff, rate, column);
        let (value_bound, derivative_bound) = filter_tolerance(f64::from(f32::EPSILON), cutoff, rate);
        println!("f32: {value:e} of {value_bound:e}, {derivative:e} of {derivative_bound:e}");
        assert!(value <= value_bound && derivative <= derivative_bound);
    }
}

fn assert_products<T: Real>(robot: &Kinematics<T, 2>, gyration_radius: T) {
    let matrix = robot.mass_matrix(gyration_radius).unwrap();
    let epsilon = T::EPSILON.to_f64();
    for row in table(include_str!("reference/eq18.csv")) {
        let number = |i: usize| T::from_f64(row[i]);
        let motion = Motion::new(&[number(0), number(1)], &[number(2), number(3)], &matrix, T::from_f64(0.0));
        // K is a sum of two terms that may cancel, so its error is that of the larger: 6 ε of M'' ·
        // 20 rad/s².
        let k_error = 6.0 * epsilon * 40.0 * matrix.rows()[0][0].to_f64();
        let (w, a, k) = (7.0, 20.0, 40.0 * matrix.rows()[0][0].to_f64());
        // What that does to each product, two wheels and gates up to 4, beside 6 ε of the product
        // itself.
        let sensitive =
            [0., 0., 0., 0., 0., 2. * k, 0., 0., 0., 0., 1., 1., 0., w, 2. * a].map(|s| 8.0 * s * k_error);
        for (gate, first) in [(Gate::Corrected, 4), (Gate::Published, 19)] {
            for (j, product) in eq18::products(gate, &motion).iter().enumerate() {
                let expected = row[first + j];
                let bound = 6.0 * epsilon * expected.abs().max(1e-3) + sensitive[j];
                assert!((product.to_f64() - expected).abs() <= bound, "{gate:?} {j}: {product:?} {expected}");
            }
        }
    }
}

#[test]
fn products_are_numpys() {
    assert_products(&burger().0, 0.064);
    assert_products(&Kinematics::<f32, 2>::differential(0.033, 0.16).unwrap(), 0.064);
}

/// The mass of a window moves by (error of the score) / (information). Forty terms |r b| of up to
/// 0.36 · 1 W, each rounded to ε and summed with ε a term, against an information of 40 ·
/// 0.2² = 1.6: 40 · 40 · 0.36 ε / 1.6 = 360 ε at worst, beside the few ε of the inputs.
fn assert_masses<T: Real>() {
    let range = MassRange::new(T::from_f64(1.0), T::from_f64(6.0)).unwrap();
    let noise = Noise { density: T::from_f64(1e-4), model_std: T::ZERO, tail: T::ONE, residual_std: T::ZERO };
    let window = Window { range, noise, period: T::from_f64(0.1), linear_beyond: T::INFINITY };
    let samples = table(include_str!("reference/window_samples.csv"));
    let mut worst = 0.0_f64;
    for row in table(include_str!("reference/window_masses.csv")) {
        let mine: Vec<_> = samples.iter().filter(|sample| sample[0] == row[0]).collect();
        assert_eq!(mine.len(), 40);
        let mut buckets = vec![];
        for bucket in mine.chunks(5) {
            let mut sums = Sums::default();
            for sample in bucket {
                let [a, b, c, power] = [1, 2, 3, 4].map(|i| T::from_f64(sample[i]));
                let response = Response { polynomial: Polynomial { a, b, c }, may_clamp: false };
                window.add(&mut sums, power, &response, T::ONE, T::NAN);
            }
            buckets.push(sums);
        }
        let estimate = window.estimate(buckets.iter()).known().unwrap();
        worst = worst.max((estimate.mass.to_f64() - 3.5 - row[1]).abs());
    }
    let bound = 360.0 * T::EPSILON.to_f64();
    assert!(worst <= bound, "{worst:e} of {bound:e}");
}

#[test]
fn masses_are_scipys() {
    assert_masses::<f64>();
    assert_masses::<f32>();
}
