//! Laws of symmetry: the mirrored robot, driving in reverse, and braking as speeding up backwards
//! in time.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::torque_model;
use model_core::eq18::Gate;
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

/// Sums of some 60 terms in another order, each of a few roundings.
const ROUNDING: f64 = 1e-13;
const DEAD_BAND: f64 = 0.02;

fn models(torque: TorqueModel<f64>) -> [Model<f64>; 5] {
    let beta = torque.expand();
    [
        Model::Eq18 { gate: Gate::Published, beta },
        Model::Eq18 { gate: Gate::Corrected, beta },
        Model::Eq18 { gate: Gate::Signed, beta },
        Model::Signed { torque, drive: Drive::Dissipative },
        Model::Signed { torque, drive: Drive::Regenerative },
    ]
}

/// What the power is made of, all terms positive: rounding is relative to this.
fn scale<const N: usize>(torque: &TorqueModel<f64>, motion: &Motion<f64, N>, mass: f64) -> f64 {
    let positive = motion.wheels.map(|wheel| {
        let tau = torque.coulomb
            + torque.rolling * mass
            + torque.viscous * wheel.speed.abs()
            + 2.0 * torque.rotor_inertia * wheel.acceleration.abs()
            + 2.0 * torque.inertia_gain * mass * wheel.inertial_torque.abs();
        tau * wheel.speed.abs() + torque.winding_loss * tau * tau
    });
    positive.iter().sum()
}

/// The two motions draw the same power, whatever the model and the mass.
fn assert_same<const N: usize>(
    torque: TorqueModel<f64>,
    one: &Motion<f64, N>,
    other: &Motion<f64, N>,
    mass: f64,
) -> Result<(), TestCaseError> {
    for model in models(torque) {
        let (of_one, of_other) = (model.power(one, mass).unwrap(), model.power(other, mass).unwrap());
        // M'' a may cancel between the wheels; what is left of it then carries the rounding of the
        // largest terms.
        let bound = ROUNDING * (scale(&torque, one, mass) + scale(&torque, other, mass) + 10.0 * mass);
        prop_assert!((of_one - of_other).abs() <= bound, "{:?}: {} {}", model, of_one, of_other);
    }
    Ok(())
}

fn states<const N: usize>() -> impl Strategy<Value = ([f64; N], [f64; N])> {
    (proptest::array::uniform(-10.0..10.0_f64), proptest::array::uniform(-20.0..20.0_f64))
}

/// Mirrors by `swap` and compares; the mirrored robot's path is the mirrored path.
fn assert_mirror<const N: usize>(
    robot: &Kinematics<f64, N>,
    torque: TorqueModel<f64>,
    (w, a): ([f64; N], [f64; N]),
    mass: f64,
    swap: impl Fn([f64; N]) -> [f64; N],
) -> Result<(), TestCaseError> {
    let matrix = robot.mass_matrix(0.2).unwrap();
    let (twist, mirrored) = (robot.twist(&w), robot.twist(&swap(w)));
    prop_assert!((twist.vx - mirrored.vx).abs() < 1e-12);
    prop_assert!((twist.vy + mirrored.vy).abs() < 1e-12);
    prop_assert!((twist.omega + mirrored.omega).abs() < 1e-12);
    let motion = Motion::new(&w, &a, &matrix, DEAD_BAND);
    assert_same(torque, &motion, &Motion::new(&swap(w), &swap(a), &matrix, DEAD_BAND), mass)
}

proptest! {
    #[test]
    fn mirrored_robot_draws_the_same(
        torque in torque_model(), mass in 0.5..50.0_f64,
        two in states::<2>(), three in states::<3>(), four in states::<4>(),
    ) {
        let sides = |[left, right]: [f64; 2]| [right, left];
        assert_mirror(&Kinematics::differential(0.1, 0.4).unwrap(), torque, two, mass, sides)?;
        let pairs = |[fl, fr, rl, rr]: [f64; 4]| [fr, fl, rr, rl];
        assert_mirror(&Kinematics::skid_steer(0.1, 0.4).unwrap(), torque, four, mass, pairs)?;
        assert_mirror(&Kinematics::mecanum(0.1, 0.2, 0.2).unwrap(), torque, four, mass, pairs)?;
        // In the mirror, wheels that drove counter-clockwise drive clockwise.
        let turned = |[left, rear, right]: [f64; 3]| [-right, -rear, -left];
        assert_mirror(&Kinematics::omni(0.1, 0.2).unwrap(), torque, three, mass, turned)?;
    }

    #[test]
    fn reverse_driving_draws_the_same(
        torque in torque_model(), mass in 0.5..50.0_f64, two in states::<2>(), four in states::<4>(),
    ) {
        let matrix = Kinematics::differential(0.1, 0.4).unwrap().mass_matrix(0.2).unwrap();
        let ((w, a), minus) = (two, |x: f64| -x);
        let forward = Motion::new(&w, &a, &matrix, DEAD_BAND);
        assert_same(torque, &forward, &Motion::new(&w.map(minus), &a.map(minus), &matrix, DEAD_BAND), mass)?;
        let matrix = Kinematics::mecanum(0.1, 0.2, 0.3).unwrap().mass_matrix(0.2).unwrap();
        let (w, a) = four;
        let forward = Motion::new(&w, &a, &matrix, DEAD_BAND);
        assert_same(torque, &forward, &Motion::new(&w.map(minus), &a.map(minus), &matrix, DEAD_BAND), mass)?;
    }

    /// Without winding loss and with a drive that feeds back, inertia takes while speeding up what
    /// it gives while braking: the part of the power that the acceleration makes is odd in it.
    #[test]
    fn inertial_power_is_odd_in_time(
        lossy in torque_model(), mass in 0.5..50.0_f64, (w, a) in states::<2>(),
    ) {
        let torque = TorqueModel { winding_loss: 0.0, ..lossy };
        let model = Model::Signed { torque, drive: Drive::Regenerative };
        let matrix = Kinematics::differential(0.1, 0.4).unwrap().mass_matrix(0.2).unwrap();
        let motion = |sign: f64| Motion::new(&w, &a.map(|x| sign * x), &matrix, DEAD_BAND);
        let power = |sign| model.power(&motion(sign), mass).unwrap();
        let (speeding_up, braking) = (power(1.0) - power(0.0), power(-1.0) - power(0.0));
        let bound = ROUNDING * scale(&torque, &motion(1.0), mass);
        prop_assert!((speeding_up + braking).abs() <= bound, "{} {}", speeding_up, braking);
    }

    /// Played backwards (speeds turned, accelerations kept) friction still takes power, and the
    /// whole is still what the forward motion with opposite acceleration draws: all models are
    /// blind to the direction of travel.
    #[test]
    fn time_reversal_is_braking(torque in torque_model(), mass in 0.5..50.0_f64, (w, a) in states::<2>()) {
        let matrix = Kinematics::differential(0.1, 0.4).unwrap().mass_matrix(0.2).unwrap();
        let backwards = Motion::new(&w.map(|x| -x), &a, &matrix, DEAD_BAND);
        let braking = Motion::new(&w, &a.map(|x| -x), &matrix, DEAD_BAND);
        assert_same(torque, &backwards, &braking, mass)?;
    }
}
