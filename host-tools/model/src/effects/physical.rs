//! What a coefficient comes to in the world.
//!
//! Base and effects are torques as the motors supply them: the drive's losses are folded in, and
//! the base's inertia gain, which turns the body's torques into the motors', is what they are
//! folded in by. A slope of 0.03 is then a coefficient of 0.04. What the world has is found by
//! taking it out again; how uncertain that is by the delta method over coefficient and base
//! together.

use model_core::torque::{PARAMETERS, TorqueModel};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// A size in the world.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Physical {
    /// The size.
    pub value: f64,
    /// Its unit; `1` of shares and factors.
    pub unit: String,
    /// Its standard error.
    pub std_err: f64,
}

/// What a conversion needs to know of robot and base.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// The base at which the coefficient was found.
    pub torque: TorqueModel<f64>,
    /// Covariance of its first parameters, as many as there are rows.
    pub covariance: DMatrix<f64>,
    /// Forward speed of the robot per speed of a wheel, m, the others standing; none where wheels
    /// differ in it.
    pub forward: Option<f64>,
    /// Turn rate of the robot per speed of its outermost wheel.
    pub turn: f64,
}

impl World {
    /// Of a robot's R and its base, with the covariance of as many of the base's parameters as
    /// there are rows.
    pub fn new([forward, _, turn]: [&[f64]; 3], torque: TorqueModel<f64>, covariance: DMatrix<f64>) -> Self {
        let alike = forward.iter().all(|entry| (entry.abs() / forward[0].abs() - 1.0).abs() < ALIKE);
        Self {
            torque,
            covariance,
            forward: alike.then_some(forward[0].abs()),
            turn: turn.iter().fold(0.0, |most: f64, entry| most.max(entry.abs())),
        }
    }
}

/// Wheels that differ by less than this share are alike.
const ALIKE: f64 = 1e-6;

/// How an effect's coefficient converts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Conversion {
    /// Unit of the size in the world.
    pub(super) unit: &'static str,
    /// The size of a coefficient, if this robot lets it be told.
    pub(super) of: fn(f64, &World) -> Option<f64>,
}

/// Relative step of numerical derivatives: the third root of a double's precision.
const STEP: f64 = 6e-6;

impl Conversion {
    /// A torque of the body or the floor: the drive has to supply the inertia gain times as much.
    pub(super) const fn of_torque(unit: &'static str) -> Self {
        Self { unit, of: |coefficient, world| Some(coefficient / world.torque.load_gain()) }
    }

    /// The size of a coefficient with its standard error, and what it has in common with each
    /// parameter of the base; none where it cannot be told.
    pub(super) fn apply(
        &self,
        coefficient: f64,
        std_err: f64,
        with_base: &[f64],
        world: &World,
    ) -> Option<Physical> {
        let value = (self.of)(coefficient, world)?;
        let base = world.torque.to_array();
        let known = world.covariance.nrows().min(PARAMETERS);
        let mut slopes = DVector::zeros(1 + known);
        for place in 0..=known {
            let centre = if place == 0 { coefficient } else { base[place - 1] };
            let step = STEP * if centre == 0.0 { 1.0 } else { centre.abs() };
            let at = |by: f64| {
                if place == 0 {
                    return (self.of)(coefficient + by, world);
                }
                let mut moved = base;
                moved[place - 1] += by;
                (self.of)(coefficient, &World { torque: world.torque.with_array(moved), ..world.clone() })
            };
            slopes[place] = (at(step)? - at(-step)?) / (2.0 * step);
        }
        let covariance = DMatrix::from_fn(1 + known, 1 + known, |i, j| match (i, j) {
            (0, 0) => std_err * std_err,
            (0, k) | (k, 0) => with_base.get(k - 1).copied().unwrap_or(0.0),
            _ => world.covariance[(i - 1, j - 1)],
        });
        let variance = slopes.dot(&(&covariance * &slopes));
        (value.is_finite() && variance.is_finite()).then(|| Physical {
            value,
            unit: self.unit.to_owned(),
            std_err: variance.max(0.0).sqrt(),
        })
    }
}
