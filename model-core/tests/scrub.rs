//! Laws of the scrub of skid-steered wheels.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{close, torque_model, wheel};
use model_core::eq18::{self, Gate};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::torque::{self, Drive, PARAMETERS, SCRUB_POWERS, TorqueModel};
use proptest::prelude::*;

const DEAD_BAND: f64 = 0.02;

/// Sums of some 60 terms in another order, each of a few roundings.
const ROUNDING: f64 = 1e-12;

fn scrubbing() -> impl Strategy<Value = TorqueModel<f64>> {
    (torque_model(), 0.0..0.5_f64).prop_map(|(torque, scrub)| TorqueModel { scrub, ..torque })
}

fn husky() -> Kinematics<f64, 2> {
    Kinematics::differential(0.165, 1.07).unwrap().with_scrub(true)
}

fn motion(kinematics: &Kinematics<f64, 2>, speed: [f64; 2], acceleration: [f64; 2]) -> Motion<f64, 2> {
    Motion::new(&speed, &acceleration, &kinematics.mass_matrix(0.21).unwrap(), DEAD_BAND)
}

proptest! {
    /// Products and expansion are the squared torque, scrub included.
    #[test]
    fn expansion_is_the_squared_torque(
        torque in scrubbing(), wheel in wheel(), share in -1.0..1.0_f64, mass in 0.5..50.0_f64,
    ) {
        let wheel = model_core::motion::Wheel { scrub: share, ..wheel };
        let motion = Motion { wheels: [wheel] };
        let base = eq18::regressors(Gate::Signed, &eq18::products(Gate::Signed, &motion), mass);
        let mut sum: f64 = base.iter().zip(torque.expand()).map(|(x, b)| x * b).sum();
        let mut scale: f64 = base.iter().zip(torque.expand()).map(|(x, b)| (x * b).abs()).sum();
        let products = torque::scrub_products(&motion);
        for ((product, power), beta) in products.iter().zip(SCRUB_POWERS).zip(torque.expand_scrub()) {
            let term = product * mass.powi(i32::from(power)) * beta;
            sum += term;
            scale += term.abs();
        }
        let expected = torque.wheel_power(&wheel, mass);
        prop_assert!(close(sum, expected, scale, ROUNDING), "{} {}", sum, expected);
        let about = torque.polynomial(&wheel, 3.0, 2.0).polynomial.at(mass - 3.0);
        prop_assert!(close(about, expected, scale * (1.0 + mass), 1e-11), "{} {}", about, expected);
    }

    /// Cubic in the parameters, at most quadratic in each: central differences are exact but for
    /// rounding.
    #[test]
    fn jacobian_is_the_derivative(torque in scrubbing()) {
        let step = 1e-3;
        let jacobian = torque.scrub_jacobian();
        for p in 0..PARAMETERS {
            let moved = |by: f64| {
                let mut values = torque.to_array();
                values[p] += by;
                TorqueModel::from_array(values).expand_scrub()
            };
            let (above, below) = (moved(step), moved(-step));
            for j in 0..jacobian.len() {
                let expected = (above[j] - below[j]) / (2.0 * step);
                prop_assert!(close(jacobian[j][p], expected, 1.0, 1e-10), "{} {}: {} {}", j, p, jacobian[j][p], expected);
            }
        }
    }

    /// Left and right swapped, and driving in reverse, draw the same power.
    #[test]
    fn mirror_and_reverse(
        torque in scrubbing(), mass in 10.0..100.0_f64,
        w in proptest::array::uniform2(-10.0..10.0_f64), a in proptest::array::uniform2(-5.0..5.0_f64),
    ) {
        let kinematics = husky();
        let model = Model::Signed { torque, drive: Drive::Dissipative };
        let power = |w, a| model.power(&motion(&kinematics, w, a), mass).unwrap();
        let here = power(w, a);
        let mirrored = power([w[1], w[0]], [a[1], a[0]]);
        let reversed = power(w.map(|x| -x), a.map(|x| -x));
        prop_assert!(close(here, mirrored, 1.0 + here.abs(), 1e-9), "{} {}", here, mirrored);
        prop_assert!(close(here, reversed, 1.0 + here.abs(), 1e-9), "{} {}", here, reversed);
    }

    /// Without losses the scrub costs b m |ω| over the largest entry of R's row ω, whatever the
    /// turn; straight ahead nothing.
    #[test]
    fn scrub_costs_turning(b in 0.01..0.5_f64, mass in 10.0..100.0_f64, w in proptest::array::uniform2(0.1..10.0_f64)) {
        prop_assume!((w[1] - w[0]).abs() > 2.0 * DEAD_BAND);
        let kinematics = husky();
        let torque = TorqueModel { scrub: b, ..TorqueModel::default() };
        let model = Model::Signed { torque, drive: Drive::Regenerative };
        let omega = kinematics.twist(&w).omega;
        let expected = b * mass * omega.abs() / kinematics.rows()[2][1];
        let power = model.power(&motion(&kinematics, w, [0.0; 2]), mass).unwrap();
        prop_assert!(close(power, expected, expected, 1e-12), "{} {}", power, expected);
        let straight = model.power(&motion(&kinematics, [w[0]; 2], [0.0; 2]), mass).unwrap();
        prop_assert_eq!(straight, 0.0);
    }
}

/// Wheels that do not slip sideways have no share in a turn.
#[test]
fn only_skid_steer_scrubs() {
    let differential = Kinematics::<f64, 2>::differential(0.033, 0.16).unwrap();
    let spin = Motion::new(&[-2.0, 2.0], &[0.0; 2], &differential.mass_matrix(0.06).unwrap(), DEAD_BAND);
    assert!(spin.wheels.iter().all(|wheel| wheel.scrub == 0.0));
    let skid = Kinematics::<f64, 4>::skid_steer(0.165, 1.07).unwrap();
    let spin = Motion::new(&[-2.0, 2.0, -2.0, 2.0], &[0.0; 4], &skid.mass_matrix(0.2).unwrap(), DEAD_BAND);
    assert_eq!(spin.wheels.map(|wheel| wheel.scrub), [-1.0, 1.0, -1.0, 1.0]);
}
