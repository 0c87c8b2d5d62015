//! Laws of scaling: units and sizes that change together leave the power alone.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{close, torque_model, wheel};
use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::{Motion, Wheel};
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

/// Some 20 roundings of positive terms.
const ROUNDING: f64 = 1e-14;

/// Bound on every product of the power: torques with all signs positive.
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

/// Degree of each product of Eq. 18 in speed, acceleration and K together.
const DEGREE: [i32; REGRESSORS] = [0, 0, 0, 2, 2, 2, 1, 1, 1, 1, 1, 1, 2, 2, 2];

proptest! {
    /// Speed in another unit (w' = c w): torque is per that unit, τ' = τ / c, so that τ w stays
    /// power.
    #[test]
    fn unit_of_speed(torque in torque_model(), wheel in wheel(), mass in 0.5..50.0_f64, c in 0.1..10.0_f64) {
        let there = TorqueModel {
            coulomb: torque.coulomb / c,
            rolling: torque.rolling / c,
            viscous: torque.viscous / (c * c),
            rotor_inertia: torque.rotor_inertia / (c * c),
            inertia_gain: torque.inertia_gain / (c * c),
            winding_loss: torque.winding_loss * c * c, scrub: 0.0, imbalance: 0.0, gear_loss: torque.gear_loss,
            bridge_drop: c * torque.bridge_drop,
            wheel_friction_share: torque.wheel_friction_share,
        };
        let rescaled = Wheel {
            speed: c * wheel.speed,
            acceleration: c * wheel.acceleration,
            inertial_torque: c * wheel.inertial_torque,
            direction: wheel.direction, scrub: 0.0, side: 0.0
        };
        let (here, there_power) = (torque.wheel_power(&wheel, mass), there.wheel_power(&rescaled, mass));
        prop_assert!(close(here, there_power, scale(&torque, &wheel, mass), ROUNDING), "{} {}", here, there_power);
        for gate in [Gate::Published, Gate::Corrected, Gate::Signed] {
            let beta = torque.expand();
            let mut beta_there = beta;
            for (value, degree) in beta_there.iter_mut().zip(DEGREE) {
                *value /= c.powi(degree);
            }
            let power = |wheel, beta| {
                let motion = Motion { wheels: [wheel] };
                Model::Eq18 { gate, beta }.power(&motion, mass).unwrap()
            };
            let (here, there) = (power(wheel, beta), power(rescaled, beta_there));
            // Gates multiply by up to 4; the published square of K carries one mass less.
            let scale = 4.0 * scale(&torque, &wheel, mass.max(mass.sqrt())) * (1.0 + 1.0 / mass);
            prop_assert!(close(here, there, scale, ROUNDING), "{:?} {} {}", gate, here, there);
        }
    }

    /// Mass in another unit (m' = c m): what counts per unit of mass shrinks.
    #[test]
    fn unit_of_mass(torque in torque_model(), wheel in wheel(), mass in 0.5..50.0_f64, c in 0.1..10.0_f64) {
        let there = TorqueModel { rolling: torque.rolling / c, inertia_gain: torque.inertia_gain / c, ..torque };
        let (here, there) = (torque.wheel_power(&wheel, mass), there.wheel_power(&wheel, c * mass));
        prop_assert!(close(here, there, scale(&torque, &wheel, mass), ROUNDING));
        for gate in [Gate::Published, Gate::Corrected, Gate::Signed] {
            let beta = torque.expand();
            let mut beta_there = beta;
            for (value, power) in beta_there.iter_mut().zip(gate.mass_powers()) {
                *value /= c.powi(i32::from(*power));
            }
            let products = eq18::products(gate, &Motion { wheels: [wheel] });
            let here = eq18::polynomial(gate, &products, &beta).at(mass);
            let there = eq18::polynomial(gate, &products, &beta_there).at(c * mass);
            let scale = 4.0 * scale(&torque, &wheel, mass) * (1.0 + 1.0 / mass);
            prop_assert!(close(here, there, scale, ROUNDING), "{:?} {} {}", gate, here, there);
        }
    }

    /// All torques times c, with a motor of c times the torque at the same loss per watt: power
    /// times c.
    #[test]
    fn more_torque_is_more_power(torque in torque_model(), wheel in wheel(), mass in 0.5..50.0_f64, c in 0.1..10.0_f64) {
        let [a0, a1, g2, g3, g4, loss, b] = torque.to_array();
        let stronger = TorqueModel::from_array([c * a0, c * a1, c * g2, c * g3, c * g4, loss / c, c * b]);
        let (once, more) = (torque.wheel_power(&wheel, mass), stronger.wheel_power(&wheel, mass));
        prop_assert!(close(c * once, more, c * scale(&torque, &wheel, mass), ROUNDING));
        for (once, more) in torque.expand().iter().zip(stronger.expand()) {
            prop_assert!(close(c * once, more, c * once.abs(), ROUNDING), "{} {}", once, more);
        }
    }

    /// A robot of c times the wheels and track at the same wheel speeds: M'' grows with c², so the
    /// same torques accelerate 1/c² of the mass.
    #[test]
    fn size_of_the_robot(
        torque in torque_model(), mass in 0.5..50.0_f64, c in 0.2..5.0_f64,
        w in proptest::array::uniform2(-10.0..10.0_f64), a in proptest::array::uniform2(-20.0..20.0_f64),
    ) {
        let robot = |c: f64| Kinematics::differential(0.05 * c, 0.3 * c).unwrap().mass_matrix(0.1 * c).unwrap();
        let model = |gain: f64| Model::Signed {
            torque: TorqueModel { inertia_gain: torque.inertia_gain * gain, ..torque },
            drive: Drive::Regenerative,
        };
        let (small, large) = (Motion::new(&w, &a, &robot(1.0), 0.02), Motion::new(&w, &a, &robot(c), 0.02));
        let here = model(1.0).power(&small, mass).unwrap();
        let there = model(1.0 / (c * c)).power(&large, mass).unwrap();
        // K may cancel between the wheels, so its rounding is that of its terms, up to M'' · 20
        // rad/s² = 0.1.
        let worst = small.wheels.map(|wheel| scale(&torque, &Wheel { inertial_torque: 0.1, ..wheel }, mass));
        prop_assert!(close(here, there, worst.iter().sum(), ROUNDING), "{} {}", here, there);
    }
}
