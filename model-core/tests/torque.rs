//! Laws of the signed torque model: its expansion's Jacobian, its polynomial of the mass, and when
//! it may clamp.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{burger, close, range, servo, torque_model, wheel};
use model_core::eq18::Gate;
use model_core::model::{MassRange, Model};
use model_core::motion::{Motion, Wheel};
use model_core::torque::{Drive, PARAMETERS, TorqueModel};
use proptest::prelude::*;

fn scale(torque: &TorqueModel<f64>, wheel: &Wheel<f64>, mass: f64) -> f64 {
    let positive = Wheel {
        speed: wheel.speed.abs(),
        acceleration: wheel.acceleration.abs(),
        inertial_torque: wheel.inertial_torque.abs(),
        direction: 1.0,
        scrub: 0.0,
        side: 0.0,
    };
    torque.wheel_power(&positive, mass)
}

proptest! {
    /// The expansion is a cubic in the parameters, in each of them at most a quadratic: central
    /// differences are exact but for rounding, ε |β| / step with |β| up to some hundred and a step
    /// of 1e-3.
    #[test]
    fn jacobian_is_the_derivative(torque in torque_model()) {
        let step = 1e-3;
        let jacobian = torque.expansion_jacobian();
        for p in 0..PARAMETERS {
            let moved = |by: f64| {
                let mut values = torque.to_array();
                values[p] += by;
                TorqueModel::from_array(values).expand()
            };
            let (above, below) = (moved(step), moved(-step));
            for j in 0..jacobian.len() {
                let expected = (above[j] - below[j]) / (2.0 * step);
                prop_assert!(close(jacobian[j][p], expected, 1.0, 1e-10), "β{} by {}: {} {}", j, p, jacobian[j][p], expected);
            }
        }
    }

    /// The polynomial is the power, at any mass and about any reference.
    #[test]
    fn polynomial_is_the_power(
        torque in torque_model(), wheel in wheel(), reference in 0.1..50.0_f64, mass in 0.1..50.0_f64,
    ) {
        let power = torque.polynomial(&wheel, reference, 1.0).polynomial.at(mass - reference);
        let expected = torque.wheel_power(&wheel, mass);
        let scale = scale(&torque, &wheel, mass.max(reference));
        prop_assert!(close(power, expected, scale, 2e-14), "{} {}", power, expected);
    }

    /// Whatever passes the gear, a share of its size is lost against the motion: of the load alone
    /// where friction is the motor's, of both where it is the wheel's.
    #[test]
    fn what_passes_the_gear_loses(
        torque in torque_model(), wheel in wheel(), mass in 0.1..50.0_f64, gear_loss in 0.0..0.6_f64,
    ) {
        let of = |wheel_friction_share| TorqueModel { gear_loss, wheel_friction_share, ..torque };
        let lossless = torque.torque(&wheel, mass);
        let along = lossless * wheel.direction;
        let friction = (torque.coulomb + torque.viscous * wheel.speed.abs()) * wheel.direction;
        let rotor = torque.rotor_inertia * wheel.acceleration;
        let scale = 1e3 * (1.0 + along.abs() + rotor.abs());
        for (share, passed) in [(0.0, lossless - rotor - friction), (1.0, lossless - rotor)] {
            let lost = of(share).torque(&wheel, mass) * wheel.direction - along;
            prop_assert!(close(lost, gear_loss * passed.abs(), scale, 1e-14), "{} {}", share, lost);
            prop_assert!(close(of(share).passed(&wheel, mass), passed, scale, 1e-14));
        }
    }

    /// Power is negative only where the torque is against the motion: then, for some mass of the
    /// range, the flag is up. Where the torque drives at all masses it is down, so that no sample
    /// is lost for nothing.
    #[test]
    fn clamping_is_foreseen(torque in torque_model(), wheel in wheel(), low in 0.1..20.0_f64, span in 0.1..30.0_f64) {
        let range = MassRange::new(low, low + span).unwrap();
        let flag = torque.polynomial(&wheel, range.middle(), range.reach()).may_clamp();
        let masses = (0..=200).map(|i| low + span * f64::from(i) / 200.0);
        let rounding = 1e-13 * scale(&torque, &wheel, low + span);
        let mut opposed = false;
        for mass in masses {
            let along = torque.torque(&wheel, mass) * wheel.direction;
            opposed |= along < rounding;
            let clamped = torque.wheel_power(&wheel, mass) < -rounding && along < 0.0;
            prop_assert!(flag || !clamped, "{} kg", mass);
            prop_assert!(torque.wheel_power(&wheel, mass) >= -rounding || along < 0.0);
        }
        // A torque is linear in the mass: a flag means that it opposes the motion at an end.
        prop_assert!(opposed || !flag);
    }

    #[test]
    fn response_is_the_power_where_nothing_clamps(
        torque in torque_model(), wheels in proptest::array::uniform2(wheel()), share in 0.0..1.0_f64,
    ) {
        let (motion, range) = (Motion { wheels }, range());
        let mass = range.no_load() + share * (range.full_load() - range.no_load());
        let rounding: f64 = wheels.iter().map(|w| 1e-13 * scale(&torque, w, 6.0)).sum();
        for drive in [Drive::Dissipative, Drive::Regenerative] {
            let model = Model::Signed { torque, drive };
            let response = model.response(&motion, &range);
            prop_assert!(drive == Drive::Dissipative || !response.may_clamp);
            if !response.may_clamp {
                let power = response.polynomial.at(mass - range.middle());
                prop_assert!((power - model.power(&motion, mass).unwrap()).abs() <= rounding);
            }
        }
        for gate in [Gate::Published, Gate::Corrected] {
            let model = Model::Eq18 { gate, beta: torque.expand() };
            let power = model.response(&motion, &range).polynomial.at(mass - range.middle());
            prop_assert!((power - model.power(&motion, mass).unwrap()).abs() <= 10.0 * rounding + 1e-13 * power.abs());
        }
    }
}

#[test]
fn a_dissipative_drive_draws_at_least_nothing() {
    let (_, matrix) = burger();
    let motion = Motion::new(&[5.0, 5.0], &[-60.0, -60.0], &matrix, 0.02);
    let power = |drive| Model::Signed { torque: servo(), drive }.power(&motion, 3.0).unwrap();
    assert_eq!(power(Drive::Dissipative), 0.0);
    assert!(power(Drive::Regenerative) < 0.0);
    // One wheel brakes, the other drives: no wheel pays for the other.
    let motion = Motion::new(&[5.0, 5.0], &[-60.0, 60.0], &matrix, 0.02);
    assert!(power(Drive::Dissipative) == 0.0);
    let split = |drive| Model::Signed { torque: servo(), drive }.power(&motion, 3.0).unwrap();
    assert!(split(Drive::Dissipative) > split(Drive::Regenerative));
}

#[test]
fn no_number_without_a_mass_or_a_motion() {
    let (_, matrix) = burger();
    let moving = |speed, acceleration| Motion::new(&[speed, 3.0], &[acceleration, 1.0], &matrix, 0.02);
    let models = [
        Model::Signed { torque: servo(), drive: Drive::Dissipative },
        Model::Signed { torque: servo(), drive: Drive::Regenerative },
        Model::Eq18 { gate: Gate::Corrected, beta: servo().expand() },
        Model::Eq18 { gate: Gate::Published, beta: servo().expand() },
    ];
    for model in models {
        assert!(model.power(&moving(2.0, 1.0), 3.0).is_some());
        for mass in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            assert_eq!(model.power(&moving(2.0, 1.0), mass), None, "{model:?} {mass}");
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(model.power(&moving(bad, 1.0), 3.0), None, "{model:?} speed {bad}");
            assert_eq!(model.power(&moving(2.0, bad), 3.0), None, "{model:?} acceleration {bad}");
        }
    }
    for (low, high) in [(0.0, 1.0), (-1.0, 1.0), (2.0, 2.0), (3.0, 2.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
        assert_eq!(MassRange::new(low, high), None);
    }
    assert_eq!(MassRange::new(1.0, f64::INFINITY), None);
}

#[test]
fn soundness_is_finite_and_not_negative() {
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        for p in 0..PARAMETERS {
            let mut values = servo().to_array();
            values[p] = bad;
            let torque = TorqueModel::from_array(values);
            assert!(!Model::Signed { torque, drive: Drive::Dissipative }.is_sound());
        }
        let mut beta = servo().expand();
        beta[14] = bad;
        assert!(!Model::Eq18 { gate: Gate::Corrected, beta }.is_sound());
    }
    assert!(Model::Signed { torque: servo(), drive: Drive::Dissipative }.is_sound());
}
