//! Eq. 18 against Eq. 15 and 16, written here a second time; Eq. 24 against Eq. 18.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{close, torque_model, wheel};
use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::motion::{Motion, Wheel};
use model_core::torque::TorqueModel;
use proptest::prelude::*;

fn sgn(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Eq. 16: each inertial torque is there only while it drives, doubled by the print's (1 + sgn).
fn gated_torque(p: &TorqueModel<f64>, wheel: &Wheel<f64>, mass: f64) -> f64 {
    let gamma_1 = p.coulomb + p.rolling * mass;
    let s = sgn(wheel.acceleration * wheel.speed);
    let r = sgn(wheel.inertial_torque * wheel.speed);
    gamma_1 * sgn(wheel.speed)
        + p.viscous * wheel.speed
        + p.rotor_inertia * (1.0 + s) * wheel.acceleration
        + p.inertia_gain * (1.0 + r) * mass * wheel.inertial_torque
}

/// Eq. 15 and the Joule losses of Eq. 3: P = Σ τ w + κ τ².
fn gated_power(p: &TorqueModel<f64>, wheels: &[Wheel<f64>], mass: f64) -> f64 {
    wheels
        .iter()
        .map(|wheel| {
            let tau = gated_torque(p, wheel, mass);
            tau * wheel.speed + p.winding_loss * tau * tau
        })
        .sum()
}

/// Eq. 17's σ, expanded by hand with (1 + s)² = 2 (1 + s).
fn beta(p: &TorqueModel<f64>) -> [f64; REGRESSORS] {
    let TorqueModel {
        coulomb: a0,
        rolling: a1,
        viscous: g2,
        rotor_inertia: g3,
        inertia_gain: g4,
        winding_loss: k,
        ..
    } = *p;
    [
        k * a0.powi(2),
        2.0 * k * a0 * a1,
        k * a1.powi(2),
        g2 + k * g2.powi(2),
        2.0 * k * g3.powi(2),
        2.0 * k * g4.powi(2),
        a0 + 2.0 * k * a0 * g2,
        a1 + 2.0 * k * a1 * g2,
        2.0 * k * a0 * g3,
        2.0 * k * a1 * g3,
        2.0 * k * a0 * g4,
        2.0 * k * a1 * g4,
        g3 + 2.0 * k * g2 * g3,
        g4 + 2.0 * k * g2 * g4,
        2.0 * k * g3 * g4,
    ]
}

/// X^0 … X^14 of one wheel by Eq. 18, with (2 + s), (2 + r) and m K² as they are printed.
fn printed(wheel: &Wheel<f64>, mass: f64) -> [f64; REGRESSORS] {
    let Wheel { speed: w, acceleration: a, inertial_torque: k, .. } = *wheel;
    let (s, r) = (sgn(a * w), sgn(k * w));
    [
        1.0,
        mass,
        mass * mass,
        w * w,
        (2.0 + s) * a * a,
        mass * (2.0 + r) * k * k,
        sgn(w) * w,
        mass * sgn(w) * w,
        (1.0 + s) * sgn(w) * a,
        mass * (1.0 + s) * sgn(w) * a,
        mass * (1.0 + r) * sgn(w) * k,
        mass * mass * (1.0 + r) * sgn(w) * k,
        (1.0 + s) * a * w,
        mass * (1.0 + r) * k * w,
        mass * (1.0 + s) * (1.0 + r) * k * a,
    ]
}

fn regress(gate: Gate, beta: &[f64; REGRESSORS], motion: &Motion<f64, 3>, mass: f64) -> f64 {
    let regressors = eq18::regressors(gate, &eq18::products(gate, motion), mass);
    regressors.iter().zip(beta).map(|(x, b)| x * b).sum()
}

/// The power with all signs positive and all gates open: rounding is relative to it.
fn scale(p: &TorqueModel<f64>, motion: &Motion<f64, 3>, mass: f64) -> f64 {
    let positive = motion.wheels.map(|wheel| Wheel {
        speed: wheel.speed.abs(),
        acceleration: wheel.acceleration.abs(),
        inertial_torque: wheel.inertial_torque.abs(),
        direction: 1.0,
        scrub: 0.0,
        side: 0.0,
    });
    gated_power(p, &positive, mass)
}

fn motion() -> impl Strategy<Value = Motion<f64, 3>> {
    proptest::array::uniform3(wheel()).prop_map(|wheels| Motion { wheels })
}

/// Some 50 roundings of positive terms.
const ROUNDING: f64 = 2e-14;

proptest! {
    #[test]
    fn corrected_is_the_squared_torque(p in torque_model(), motion in motion(), mass in 0.1..50.0_f64) {
        let expected = gated_power(&p, &motion.wheels, mass);
        let power = regress(Gate::Corrected, &beta(&p), &motion, mass);
        prop_assert!(close(power, expected, scale(&p, &motion, mass), ROUNDING), "{} {}", power, expected);
    }

    /// The print has one a² more a wheel, and (2 + r) K² m where m² (1 + r) K² belongs: nothing
    /// else differs.
    #[test]
    fn published_differs_by_its_two_misprints(p in torque_model(), motion in motion(), mass in 0.1..50.0_f64) {
        let beta = beta(&p);
        let difference = regress(Gate::Published, &beta, &motion, mass) - regress(Gate::Corrected, &beta, &motion, mass);
        let expected: f64 = motion.wheels.iter().map(|wheel| {
            let r = sgn(wheel.inertial_torque * wheel.speed);
            let k_squared = wheel.inertial_torque.powi(2);
            beta[4] * wheel.acceleration.powi(2) + beta[5] * k_squared * (mass * (2.0 + r) - mass * mass * (1.0 + r))
        }).sum();
        let scale = scale(&p, &motion, mass) * (1.0 + 1.0 / mass);
        prop_assert!(close(difference, expected, scale, 2.0 * ROUNDING), "{} {}", difference, expected);
    }

    /// Eq. 18 term by term, with the signs of products; the corrected gate has all of them but the
    /// fifth and sixth.
    #[test]
    fn all_terms_are_those_of_eq18(motion in motion(), mass in 0.1..50.0_f64) {
        let printed: Vec<[f64; REGRESSORS]> =
            motion.wheels.iter().map(|wheel| printed(wheel, mass)).collect();
        for gate in [Gate::Published, Gate::Corrected] {
            let regressors = eq18::regressors(gate, &eq18::products(gate, &motion), mass);
            for j in (0..REGRESSORS).filter(|j| gate == Gate::Published || ![4, 5].contains(j)) {
                let expected: f64 = printed.iter().map(|wheel| wheel[j]).sum();
                let scale: f64 = printed.iter().map(|wheel| wheel[j].abs()).sum();
                prop_assert!(close(regressors[j], expected, scale, ROUNDING), "{} {} {}", j, regressors[j], expected);
            }
        }
    }

    /// Eq. 24 is Eq. 18 sorted by powers of the mass: the same number at any mass, more of them
    /// than a parabola has coefficients.
    #[test]
    fn eq24_is_eq18(
        beta in proptest::array::uniform(0.0..2.0_f64), motion in motion(),
        masses in proptest::array::uniform5(0.1..50.0_f64),
    ) {
        for gate in [Gate::Published, Gate::Corrected, Gate::Signed] {
            let products = eq18::products(gate, &motion);
            let polynomial = eq18::polynomial(gate, &products, &beta);
            for mass in masses {
                let regressors = eq18::regressors(gate, &products, mass);
                let terms = regressors.iter().zip(&beta).map(|(x, b)| x * b);
                let (sum, scale) = terms.fold((0.0, 0.0), |(sum, scale), x: f64| (sum + x, scale + x.abs()));
                prop_assert!(close(polynomial.at(mass), sum, scale, 1e-14), "{:?} {}", gate, mass);
            }
        }
    }

    /// Ungated, the expansion of the signed model is its power; wheels at rest included.
    #[test]
    fn signed_products_are_the_signed_torque(
        p in torque_model(), motion in motion(), resting in any::<bool>(), mass in 0.1..50.0_f64,
    ) {
        let mut motion = motion;
        if resting {
            motion.wheels[1] = Wheel::default();
        }
        let expected: f64 = motion.wheels.iter().map(|wheel| {
            let tau = (p.coulomb + p.rolling * mass) * sgn(wheel.speed)
                + p.viscous * wheel.speed
                + p.rotor_inertia * wheel.acceleration
                + p.inertia_gain * mass * wheel.inertial_torque;
            tau * wheel.speed + p.winding_loss * tau * tau
        }).sum();
        let direct: f64 = motion.wheels.iter().map(|wheel| p.wheel_power(wheel, mass)).sum();
        prop_assert!(close(direct, expected, scale(&p, &motion, mass), ROUNDING), "{} {}", direct, expected);
        let power = regress(Gate::Signed, &p.expand(), &motion, mass);
        prop_assert!(close(power, expected, scale(&p, &motion, mass), ROUNDING), "{} {}", power, expected);
    }
}

/// Where the sign is 0 (constant speed), the gated products vanish with their accelerations.
#[test]
fn constant_speed_has_no_inertial_products() {
    let wheel =
        Wheel { speed: 2.0, acceleration: 0.0, inertial_torque: 0.0, direction: 1.0, scrub: 0.0, side: 0.0 };
    for gate in [Gate::Published, Gate::Corrected, Gate::Signed] {
        let products = eq18::products(gate, &Motion { wheels: [wheel] });
        assert_eq!(products, [1.0, 1.0, 1.0, 4.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
