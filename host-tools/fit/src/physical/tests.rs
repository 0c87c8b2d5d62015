//! The solver on rows made from a known model.

use model_core::eq18::Gate;
use model_core::model::Model;
use model_core::motion::Wheel;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::SMatrix;
use numerics::levenberg_marquardt::{Bounds as Box, LeastSquares, Tolerances, descend};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::dataset::{Dataset, Kept, Row, Run};
use super::cost::{Cost, Loss, WHEEL_FRICTION_SHARE};
use super::restarts::restart_within;
use super::{Bounds, PARAMETERS, Parameters, Rows, Solution};
use crate::gram::Gram;
use crate::warning::Warning;
use crate::{Method, ModelKind, fit, pgd};

const TRUTH: [f64; PARAMETERS] = [0.05, 0.008, 0.007, 0.0065, 1.6, 2.5, 0.02, -0.01, 0.1, 0.15, 0.0];

fn noise(random: &mut ChaCha8Rng) -> f64 {
    random.sample(rand_distr::StandardNormal)
}

/// Rows of two wheels at any speed and acceleration, with `std` W of noise.
fn rows(count: usize, std: f64, drive: Drive) -> Vec<Row> {
    let random = &mut ChaCha8Rng::seed_from_u64(5);
    let torque = super::torque(&TRUTH.into());
    let row = |index: usize| {
        let mut wheel = || {
            let speed = 6.0 * (2.0 * random.random::<f64>() - 1.0);
            let acceleration = 4.0 * noise(random);
            let inertial_torque = 1e-3 * (acceleration + noise(random));
            let scrub = 2.0 * random.random::<f64>() - 1.0;
            let side = if random.random() { 1.0 } else { -1.0 };
            Wheel { speed, acceleration, inertial_torque, direction: f64::signum(speed), scrub, side }
        };
        let wheels = [wheel(), wheel()];
        let mass = [1.0, 3.0, 6.0][index % 3];
        let wheel_power = |wheel: &Wheel<f64>| torque.wheel_power(wheel, mass);
        let power = wheels
            .iter()
            .map(wheel_power)
            .map(|power| if drive == Drive::Dissipative { power.max(0.0) } else { power });
        Row {
            wheels: wheels.into(),
            power: power.sum::<f64>() + std * noise(random),
            mass,
            run: 0,
            time: 0.05 * index as f64,
        }
    };
    (0..count).map(row).collect()
}

fn kept(rows: &[Row]) -> Rows {
    rows.iter().map(Row::view).collect()
}

fn solve(rows: &[Row], drive: Drive, bounds: &Bounds) -> Solution {
    super::solve_within(kept(rows).all(), drive, bounds)
}

fn bounds(winding_loss: f64) -> Bounds {
    let lower = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0];
    Bounds::from_ends(lower, [1.0, 1.0, 1.0, 1.0, 25.0, winding_loss, 1.0, 1.0, 0.5, 1.0, 0.0])
}

fn wide() -> Bounds {
    bounds(100.0)
}

fn assert_near(fitted: &TorqueModel<f64>, share: f64) {
    for (fitted, truth) in super::parameters(fitted).iter().zip(TRUTH) {
        assert!((fitted - truth).abs() <= share * truth.abs(), "{fitted} {truth}");
    }
}

#[test]
fn returns_the_truth_clamped_or_not() {
    for drive in [Drive::Dissipative, Drive::Regenerative] {
        let solution = solve(&rows(3000, 1e-6, drive), drive, &wide());
        assert!(solution.ending.has_converged(), "{solution:?}");
        assert_near(&solution.torque, 1e-4);
        assert!(solution.at_bounds.is_empty());
    }
}

/// One row in fifty is up to 1 W off: least squares moves by far more than the noise, Huber's does
/// not, and it says its threshold.
#[test]
fn a_few_wrong_rows_do_not_decide() {
    let mut rows = rows(6000, 0.01, Drive::Regenerative);
    for row in rows.iter_mut().step_by(50) {
        row.power += row.wheels[0].scrub.abs();
    }
    let solution = solve(&rows, Drive::Regenerative, &wide());
    assert_eq!(threshold(&solution), Some(4.0));
    assert_near(&solution.torque, 0.03);
    assert!(solution.weights.iter().step_by(50).filter(|weight| **weight < 0.5).count() > 100);
}

/// Where one row in twelve holds what the model lacks, those rows are what tells: the tightest
/// threshold is not taken, and no more is given away of what least squares explains than the rule
/// allows.
#[test]
fn what_the_model_lacks_is_not_weighed_away() {
    let mut rows = rows(3000, 0.01, Drive::Regenerative);
    for row in &mut rows {
        let wheel = &row.wheels[1];
        row.power += if wheel.speed > 5.0 { 10.0 } else { 0.0 };
    }
    let solution = solve(&rows, Drive::Regenerative, &wide());
    assert_ne!(threshold(&solution), Some(4.0));
    let rows = kept(&rows);
    let squares =
        Cost { rows: rows.all(), drive: Drive::Regenerative, loss: Loss::Squares, free: wide().free() };
    let cost = squares.cost(&super::parameters(&solution.torque));
    let ends = Box { lower: *wide().lower(), upper: *wide().upper() };
    let least = descend(&squares, &super::parameters(&solution.torque), &ends, &Tolerances::default()).cost;
    let mean = rows.iter().map(|row| row.power).sum::<f64>() / rows.len() as f64;
    let variation: f64 = rows.iter().map(|row| (row.power - mean).powi(2)).sum();
    assert!(cost - least <= 0.005 * variation, "{cost} {least} {variation}");
}

fn threshold(solution: &Solution) -> Option<f64> {
    solution.huber.map(|huber| huber.threshold_std)
}

/// Fifty random starts on the same cost end nowhere lower; where the fit is not at its optimum,
/// they do.
#[test]
fn no_start_ends_lower() {
    let mut rows = rows(1500, 0.05, Drive::Dissipative);
    for row in &mut rows {
        row.power += 0.3 * row.wheels[0].speed.abs().sqrt();
    }
    let solution = solve(&rows, Drive::Dissipative, &wide());
    let above = |torque: &TorqueModel<f64>| {
        restart_within(kept(&rows).all(), Drive::Dissipative, &wide(), torque, solution.huber, 50)
            .cost_above_share
    };
    let share = above(&solution.torque);
    assert!((-1e-6..=1e-3).contains(&share), "{share}");
    let mut off = solution.torque;
    off.inertia_gain *= 1.2;
    assert!(above(&off) > 1e-3);
}

/// Derivatives against central differences, far from the clamp's edge: 1e-6 of a gradient's size.
/// Friction passes the gear or does not.
#[test]
fn derivatives_are_those_of_the_cost() {
    let rows = kept(&rows(200, 0.1, Drive::Regenerative));
    for (loss, share) in [(Loss::Squares, 0.0), (Loss::Squares, 1.0), (Loss::Huber(0.5), 1.0)] {
        let cost = Cost { rows: rows.all(), drive: Drive::Regenerative, loss, free: [true; PARAMETERS] };
        let mut at = Parameters::from(TRUTH) * 1.1;
        at[WHEEL_FRICTION_SHARE] = share;
        let (gradient, _) = cost.derivatives(&at);
        for i in 0..WHEEL_FRICTION_SHARE {
            let by = 1e-6 * at[i].abs();
            let moved = |by: f64| {
                let mut moved = at;
                moved[i] += by;
                cost.cost(&moved)
            };
            let slope = (moved(by) - moved(-by)) / (2.0 * by);
            assert!(
                (slope - 2.0 * gradient[i]).abs() < 1e-5 * slope.abs().max(1.0),
                "{i}: {slope} {gradient}"
            );
        }
    }
}

/// Sums over blocks are those over rows, the last block being short and wheels clamped.
#[test]
fn blocks_are_rows() {
    let rows = kept(&rows(200, 0.1, Drive::Regenerative));
    let at = Parameters::from(TRUTH) * 1.1;
    for drive in [Drive::Regenerative, Drive::Dissipative] {
        let cost = Cost { rows: rows.all(), drive, loss: Loss::Squares, free: [true; PARAMETERS] };
        let (mut squares, mut gradient, mut matrix) = (0.0, Parameters::zeros(), SMatrix::zeros());
        for row in rows.iter() {
            let (power, slope) = super::predict(&super::torque(&at), &row, drive);
            squares += (row.power - power).powi(2);
            gradient -= slope * (row.power - power);
            matrix += slope * slope.transpose();
        }
        let derivatives = cost.derivatives(&at);
        assert!((cost.cost(&at) - squares).abs() < 1e-12 * squares);
        assert!((derivatives.0 - gradient).norm() < 1e-12 * gradient.norm());
        assert!((derivatives.1 - matrix).norm() < 1e-12 * matrix.norm());
    }
    let clamped =
        |row: Kept<'_>| row.wheels.iter().any(|w| super::torque(&at).wheel_power(w, row.mass) < 0.0);
    assert!(rows.iter().any(clamped));
}

#[test]
fn a_bound_that_is_met_is_told() {
    let bounds = bounds(1.0);
    let solution = solve(&rows(2000, 0.01, Drive::Regenerative), Drive::Regenerative, &bounds);
    let names: Vec<&str> = solution.at_bounds.iter().map(|at| at.description.name).collect();
    assert_eq!(names, ["winding_loss"]);
    assert_eq!(solution.torque.winding_loss, 1.0);
}

/// A gear takes 0.9 of what passes it, more than a board believes: the fit does without, and says so.
#[test]
fn a_gear_s_loss_at_its_bound_is_left_out() {
    let robot = logs::robot::Robot::named("burger").unwrap();
    let mut dataset = Dataset::empty(robot.chassis(2.0).unwrap(), Gate::Signed);
    let torque = TorqueModel { gear_loss: 0.9, bridge_drop: 0.0, ..super::torque(&TRUTH.into()) };
    let mut rows = rows(3000, 0.0, Drive::Regenerative);
    for row in &mut rows {
        row.power = row
            .wheels
            .iter()
            .map(|wheel| torque.wheel_power(wheel, row.mass))
            .map(|power| power.max(0.0))
            .sum();
    }
    dataset.store = kept(&rows);
    (dataset.period_s, dataset.used, dataset.rows) = (0.05, 3000, 3000);
    dataset.masses = vec![1.0, 3.0, 6.0];
    let run = Run { file: "a.csv".into(), gram: Gram::default() };
    dataset.runs.push(run);
    dataset.free_terms.gear_loss = Some(0.0);
    let fit = fit(&robot, &dataset, ModelKind::Signed, Method::Physical, &pgd::Settings::default()).unwrap();
    let Model::Signed { torque, .. } = fit.model else { panic!("{:?}", fit.model) };
    assert_eq!(torque.gear_loss, 0.0);
    let says = |warning: &Warning| warning.text.starts_with("gear_loss ended at its bound");
    assert!(fit.warnings.iter().any(says), "{:?}", fit.warnings);
}
