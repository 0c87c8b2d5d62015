//! Single precision against double: what the board computes is what the host computes, to a derived
//! tolerance.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Rng, burger, coefficients, servo};
use model_core::coefficients::Coefficients;
use model_core::eq18::{self, Gate};
use model_core::estimator::{Estimator, Sample, Timing};
use model_core::model::Model;
use model_core::motion::{Motion, Wheel};
use model_core::payload::schedule::Schedule;
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

const EPSILON: f64 = f32::EPSILON as f64;

/// Inputs that single precision holds, so that only the arithmetic differs.
fn single(wheel: Wheel<f64>) -> Wheel<f32> {
    Wheel {
        speed: wheel.speed as f32,
        acceleration: wheel.acceleration as f32,
        inertial_torque: wheel.inertial_torque as f32,
        direction: wheel.direction as f32,
        scrub: 0.0,
        side: 0.0,
    }
}

fn double(wheel: Wheel<f32>) -> Wheel<f64> {
    Wheel {
        speed: wheel.speed.into(),
        acceleration: wheel.acceleration.into(),
        inertial_torque: wheel.inertial_torque.into(),
        direction: wheel.direction.into(),
        scrub: 0.0,
        side: 0.0,
    }
}

fn positive(wheel: Wheel<f64>) -> Wheel<f64> {
    Wheel {
        speed: wheel.speed.abs(),
        acceleration: wheel.acceleration.abs(),
        inertial_torque: wheel.inertial_torque.abs(),
        direction: 1.0,
        scrub: 0.0,
        side: 0.0,
    }
}

proptest! {
    /// A torque takes seven operations, the power four more, of which one squares the torque: with
    /// all terms positive the relative error is at most (2 · 7 + 4) ε/2 = 9 ε, and terms that
    /// cancel err by no more than that of their sum.
    #[test]
    fn power_of_a_wheel(
        torque in common::torque_model(), wheel in common::wheel(), mass in 0.5..50.0_f32,
    ) {
        let torque32 = TorqueModel::from_array(torque.to_array().map(|x| x as f32));
        let torque = TorqueModel::from_array(torque32.to_array().map(f64::from));
        let wheel32 = single(wheel);
        let wheel = double(wheel32);
        let power = f64::from(torque32.wheel_power(&wheel32, mass));
        let expected = torque.wheel_power(&wheel, mass.into());
        let scale = torque.wheel_power(&positive(wheel), mass.into());
        prop_assert!((power - expected).abs() <= 9.0 * EPSILON * scale, "{} {}", power, expected);
        // About the middle of a range, the polynomial's three terms come on top: at any mass that
        // the robot can have they are at most 4 times the power at full load.
        let polynomial = torque32.polynomial(&wheel32, 3.5, 2.5).polynomial;
        let scale = 4.0 * torque.wheel_power(&positive(wheel), 6.0);
        for d in [-2.5_f32, -1.0, 0.0, 2.5] {
            let expected = torque.wheel_power(&wheel, 3.5 + f64::from(d));
            prop_assert!((f64::from(polynomial.at(d)) - expected).abs() <= 12.0 * EPSILON * scale);
        }
    }

    /// A product takes at most four operations and its sum over the wheels two more, times its
    /// coefficient and mass three, summed over 15: (4 + 2 + 3 + 15) ε/2 = 12 ε of the sum of
    /// magnitudes.
    #[test]
    fn power_by_eq18(
        beta in proptest::array::uniform15(0.0..2.0_f32), wheels in proptest::array::uniform3(common::wheel()),
        mass in 0.5..50.0_f32,
    ) {
        let motion32 = Motion { wheels: wheels.map(single) };
        let motion = Motion { wheels: motion32.wheels.map(double) };
        for gate in [Gate::Published, Gate::Corrected, Gate::Signed] {
            let power = Model::Eq18 { gate, beta }.power(&motion32, mass).unwrap();
            let beta = beta.map(f64::from);
            let expected = Model::Eq18 { gate, beta }.power(&motion, mass.into()).unwrap();
            let magnitudes = eq18::regressors(gate, &eq18::products(gate, &Motion { wheels: motion.wheels.map(positive) }), mass.into());
            let scale: f64 = magnitudes.iter().zip(beta).map(|(x, b)| x * b).sum();
            prop_assert!((f64::from(power) - expected).abs() <= 12.0 * EPSILON * scale, "{:?} {} {}", gate, power, expected);
        }
    }
}

/// A drive of `seconds` at 200 Hz through the whole pipeline in both precisions; the largest
/// difference of the masses.
fn drive(model: Model<f64>, seconds: usize, schedule: Schedule) -> f64 {
    let coefficients = Coefficients { model, ..coefficients() };
    let single: Coefficients<f32, 2> = coefficients.convert().unwrap();
    // The same numbers in both.
    let coefficients: Coefficients<f64, 2> = single.convert().unwrap();
    let (period, bucket_s) = (0.005, 1.0);
    let timing = Timing { period_s: period, bucket_s, schedule, detect_changes: false };
    let window = coefficients.window(period);
    let window32 = single.window(period as f32);
    let mut host: Estimator<f64, _, 2, 30> = Estimator::new(&coefficients, window, &timing).unwrap();
    let mut board: Estimator<f32, _, 2, 30> = Estimator::new(&single, window32, &timing).unwrap();
    let (_, matrix) = burger();
    let mut rng = Rng::new(1);
    let mut worst = 0.0_f64;
    let mut compared = 0;
    for i in 0..seconds * 200 {
        let time = i as f64 * period;
        let speed = [4.0 + 2.0 * (0.9 * time).sin(), 4.0 + 2.0 * (0.7 * time).cos()];
        let acceleration = [1.8 * (0.9 * time).cos(), -1.4 * (0.7 * time).sin()];
        let power = model.power(&Motion::new(&speed, &acceleration, &matrix, 0.02), 4.2).unwrap();
        let power = (power + 0.1 * rng.normal()) as f32;
        let speed = speed.map(|x| x as f32);
        let sample = Sample { wheel_speed: speed, wheel_acceleration: None, power };
        let out32 = board.push(&sample, period as f32);
        let sample =
            Sample { wheel_speed: speed.map(f64::from), wheel_acceleration: None, power: power.into() };
        let out = host.push(&sample, period);
        // In the middle of a bucket: after an hour of adding 5 ms in single precision its ends are
        // a sample apart.
        if let (100, Some(mass), Some(mass32)) = (i % 200, out.mass.known(), out32.mass.known()) {
            worst = worst.max((f64::from(mass32.mass) - mass.mass).abs());
            worst = worst.max((f64::from(mass32.high) - mass.high).abs());
            compared += 1;
        }
    }
    assert!(compared > seconds / 2);
    let (energy, energy32) = (host.energy().0, f64::from(board.energy().0));
    // The filter's error of 1e-4 W (below) may lean one way; the sum itself does not add to it.
    assert!((energy - energy32).abs() <= 1e-4 * energy, "{energy} {energy32}");
    worst
}

/// Filtered speed errs by some 1e-4 rad/s and power by 1e-4 W (bound in `reference.rs`), derivative
/// by 1e-3 rad/s². Power by the model moves with them by dP/dw ≈ 0.3 W·s/rad and dP/da ≈ 0.05
/// W·s²/rad: 1e-4 W in all, of one sign at worst, on a slope dP/dm of at least 0.05 W/kg. That is
/// 2e-3 kg; sums of 5000 terms in buckets of 200 add 200 ε · 1 W / 0.05 W/kg = 5e-4 kg.
const MASS_TOLERANCE: f64 = 2.5e-3;

#[test]
fn mass_through_the_whole_pipeline() {
    let signed = Model::Signed { torque: servo(), drive: Drive::Dissipative };
    let corrected = Model::Eq18 { gate: Gate::Corrected, beta: servo().expand() };
    for model in [signed, corrected] {
        for schedule in [Schedule::Moving { window: 10 }, Schedule::Moving { window: 25 }] {
            let worst = drive(model, 120, schedule);
            println!("{schedule:?}: {worst:e} kg");
            assert!(worst < MASS_TOLERANCE, "{model:?} {schedule:?}: {worst:e} kg");
        }
    }
}

/// An hour of cumulative sums: merged buckets keep each sum short.
#[test]
fn mass_after_an_hour() {
    let worst =
        drive(Model::Signed { torque: servo(), drive: Drive::Dissipative }, 3600, Schedule::Cumulative);
    println!("{worst:e} kg");
    assert!(worst < MASS_TOLERANCE, "{worst:e} kg");
}
