//! The signed model away from its clamp: a polynomial of its parameters over 21 regressors, so that
//! its cost is a sum over rows that no later question needs again.
//!
//! ```text
//! P = β(θ)ᵀ x,   Σ (p − β(θ)ᵀ x)² = pᵀp − 2 β(θ)ᵀ Xᵀp + β(θ)ᵀ XᵀX β(θ)
//! ```
//!
//! β(θ) are [`TorqueModel::expand`] and [`TorqueModel::expand_scrub`]; both sides are taken for
//! alike.

use logs::robot::chassis::Together;
use logs::with_motion;
use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::motion::Wheel;
use model_core::torque::{self, Drive, SCRUB_POWERS, SCRUB_PRODUCTS, TorqueModel};
use nalgebra::{Const, SMatrix, SVector};
use numerics::levenberg_marquardt::LeastSquares;

use crate::dataset::Kept;
use crate::gram::{Gram, Vector};
use crate::physical::{Alone, PARAMETERS, Parameters, torque};

/// Regressors of the signed model.
pub(super) const PRODUCTS: usize = REGRESSORS + SCRUB_PRODUCTS;

type Matrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Regressors of a motion at a total mass in kg.
pub(super) fn regressors(row: &Kept<'_>) -> [f64; PRODUCTS] {
    let mass = row.mass;
    let shared = eq18::regressors(Gate::Signed, &row.products(Gate::Signed), mass);
    let scrub = with_motion!(row.wheels, motion => torque::scrub_products(motion));
    std::array::from_fn(|i| match i.checked_sub(REGRESSORS) {
        None => shared[i],
        Some(place) => scrub[place] * mass.powi(i32::from(SCRUB_POWERS[place])),
    })
}

/// No wheel can be clamped, whatever the parameters: what drives it, drives it along its motion.
pub(super) fn cannot_clamp(wheels: &[Wheel<f64>], drive: Drive) -> bool {
    let along = |wheel: &Wheel<f64>| {
        let factors = [wheel.acceleration, wheel.inertial_torque, wheel.scrub];
        factors.into_iter().all(|factor| factor * wheel.direction >= 0.0)
    };
    drive == Drive::Regenerative || wheels.iter().all(along)
}

/// β(θ).
pub(super) fn expand(torque: &TorqueModel<f64>) -> Vector<PRODUCTS> {
    let (shared, scrub) = (torque.expand(), torque.expand_scrub());
    Vector::from_fn(|i, _| *shared.get(i).unwrap_or_else(|| &scrub[i - REGRESSORS]))
}

/// ∂β/∂θ; none of the imbalance.
fn jacobian(torque: &TorqueModel<f64>) -> SMatrix<f64, PRODUCTS, PARAMETERS> {
    let (shared, scrub) = (torque.expansion_jacobian(), torque.scrub_jacobian());
    SMatrix::from_fn(|i, j| {
        let row = shared.get(i).unwrap_or_else(|| &scrub[i - REGRESSORS]);
        row.get(j).copied().unwrap_or(0.0)
    })
}

/// The cost of rows by their sums.
pub(super) struct Cost<'a> {
    gram: &'a Gram<PRODUCTS>,
    products: SMatrix<f64, PRODUCTS, PRODUCTS>,
}

impl<'a> Cost<'a> {
    pub(super) fn of(gram: &'a Gram<PRODUCTS>) -> Self {
        Self { gram, products: gram.xx() }
    }

    /// What each parameter of a linear part explains alone: where a search begins.
    pub(super) fn alone(&self) -> Alone {
        /// Of coulomb, rolling, viscous, rotor inertia, inertia gain and scrub: their products
        /// where κ is 0.
        const LINEAR: [(usize, usize); 6] = [(0, 6), (1, 7), (2, 3), (3, 12), (4, 13), (6, REGRESSORS)];
        let with = self.gram.xp();
        let mut parameters = Parameters::zeros();
        for (parameter, product) in LINEAR {
            let square = self.products[(product, product)];
            parameters[parameter] = if square > 0.0 { (with[product] / square).max(0.0) } else { 0.0 };
        }
        let speed = (self.products[(6, 6)] / self.gram.rows().max(1) as f64).sqrt();
        Alone { parameters, speed }
    }
}

impl LeastSquares<Const<PARAMETERS>> for Cost<'_> {
    fn cost(&self, parameters: &Parameters) -> f64 {
        self.gram.cost(&expand(&torque(parameters))) * self.gram.rows().max(1) as f64
    }

    fn derivatives(&self, parameters: &Parameters) -> (Parameters, Matrix) {
        let torque = torque(parameters);
        let slopes = jacobian(&torque);
        let scores: SVector<f64, PRODUCTS> = self.gram.scores(&expand(&torque));
        (-(slopes.transpose() * scores), slopes.transpose() * self.products * slopes)
    }
}

/// Normal matrix and scores in θ of these sums.
pub(super) fn normal(gram: &Gram<PRODUCTS>, at: &TorqueModel<f64>) -> (Matrix, Parameters) {
    let slopes = jacobian(at);
    (slopes.transpose() * gram.xx() * slopes, slopes.transpose() * gram.scores(&expand(at)))
}
