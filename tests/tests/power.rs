//! Eq. 18 and the signed torque model in single precision against NumPy in double:
//! reference/power.py.
#![cfg_attr(target_os = "none", no_std, no_main)]

use model_core::eq18::{self, Gate};
use model_core::kinematics::{Kinematics, MassMatrix};
use model_core::model::{MassRange, Model};
use model_core::motion::Motion;
use model_core::torque::{Drive, TorqueModel};
use on_target_tests::{Failed, Outcome, close, ensure, tests};

#[allow(clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/power.rs");
}
use reference::{BETA, CASES, Case, DEAD_BAND, GYRATION_RADIUS, TORQUE, TRACK, WHEEL_RADIUS};

tests!(
    eq18_as_published,
    eq18_corrected,
    eq18_corrected_is_the_squared_torque,
    signed_torque,
    polynomial_of_the_mass
);

/// Unit roundoff of single precision.
const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;

/// Roundings on the way to one regressor, each relative to the sizes of what is added: seven in an
/// entry of M'', three in K = M'' a, which enters squared, then five products and a sum.
const REGRESSOR_ROUNDINGS: f64 = 2.0 * 10.0 + 6.0;

/// To a power: a torque takes K's ten, eight in its terms and sums, and enters squared, then four
/// more. Fifteen terms with rounded coefficients take no more.
const POWER_ROUNDINGS: f64 = 2.0 * 18.0 + 4.0;

fn mass_matrix() -> Result<MassMatrix<f32, 2>, Failed> {
    let found = Kinematics::differential(WHEEL_RADIUS, TRACK).and_then(|k| k.mass_matrix(GYRATION_RADIUS));
    ensure(found.is_ok(), format_args!("{found:?}"))?;
    found.map_err(|_| Failed)
}

fn motion(case: &Case) -> Result<Motion<f32, 2>, Failed> {
    Ok(Motion::new(&case.speed, &case.acceleration, &mass_matrix()?, DEAD_BAND))
}

fn moving() -> impl Iterator<Item = (usize, &'static Case)> {
    CASES.iter().enumerate().filter(|(_, case)| !case.resting)
}

fn regressors(gate: Gate, pick: fn(&Case) -> &[f64; 15]) -> Outcome {
    for (i, case) in moving() {
        let products = eq18::products(gate, &motion(case)?);
        let found = eq18::regressors(gate, &products, case.mass);
        for (j, ((found, reference), size)) in found.iter().zip(pick(case)).zip(&case.size).enumerate() {
            let tolerance = REGRESSOR_ROUNDINGS * ROUNDOFF * size;
            close(format_args!("case {i}, X{j}"), *found, *reference, tolerance)?;
        }
    }
    Ok(())
}

fn eq18_as_published() -> Outcome {
    regressors(Gate::Published, |case| &case.published)
}

fn eq18_corrected() -> Outcome {
    regressors(Gate::Corrected, |case| &case.corrected)
}

/// The corrected equation is Eq. 15 with the squared torque of Eq. 16; the reference never expands
/// the square.
fn eq18_corrected_is_the_squared_torque() -> Outcome {
    let model = Model::Eq18 { gate: Gate::Corrected, beta: BETA.map(|beta| beta as f32) };
    for (i, case) in moving() {
        let found = model.power(&motion(case)?, case.mass).unwrap_or(f32::NAN);
        // Gates double the inertial torques, and so at most quadruple a power.
        close(format_args!("case {i}"), found, case.law_w, POWER_ROUNDINGS * ROUNDOFF * 4.0 * case.size_w)?;
    }
    Ok(())
}

fn signed_torque() -> Outcome {
    let torque = TorqueModel::from_array(TORQUE);
    for (i, case) in CASES.iter().enumerate() {
        let tolerance = POWER_ROUNDINGS * ROUNDOFF * case.size_w;
        for (drive, reference) in [(Drive::Dissipative, case.clamped_w), (Drive::Regenerative, case.free_w)] {
            let found = Model::Signed { torque, drive }.power(&motion(case)?, case.mass).unwrap_or(f32::NAN);
            close(format_args!("case {i}, {drive:?}"), found, reference, tolerance)?;
        }
    }
    Ok(())
}

/// The polynomial that the payload estimators use gives the same power. Its terms about the middle
/// of the mass range are larger than the sum, by at most the square of the masses' ratio.
fn polynomial_of_the_mass() -> Outcome {
    let model = Model::Signed { torque: TorqueModel::from_array(TORQUE), drive: Drive::Regenerative };
    let range = MassRange::new(1.0_f32, 6.0).ok_or(Failed)?;
    for (i, case) in CASES.iter().enumerate() {
        let response = model.response(&motion(case)?, &range);
        let found = response.polynomial.at(case.mass - range.middle());
        let ratio = f64::from(range.full_load() / case.mass);
        let tolerance = POWER_ROUNDINGS * ROUNDOFF * case.size_w * ratio * ratio;
        close(format_args!("case {i}"), found, case.free_w, tolerance)?;
    }
    Ok(())
}
