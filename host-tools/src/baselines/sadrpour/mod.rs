//! Sadrpour 2012/2013: the energy of a mission of an unmanned ground vehicle, by its longitudinal dynamics.
//!
//! The power is that of [`super::longitudinal`]. The vehicle's mass is known and constant in the source; here it is in
//! the lumped parameters, and no input. They are learned in one of two ways: by recursive least squares while driving, or by
//! Bayesian estimation, which begins with what earlier drives over such ground tell of their distribution.

mod bayes;
mod prior;

pub use bayes::Bayes;

use super::Card;
use super::longitudinal::{SYMBOLS, terms};
use super::online::Online;

/// By recursive least squares.
pub const RECURSIVE: Card = Card {
    name: "sadrpour-rls",
    source: "Sadrpour 2012/2013: longitudinal dynamics, recursive least squares while driving (forgetting over 60 s)",
    assumes: "turns cost nothing; past powers of the drive are known; level ground where the log has no pitch_rad",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Online::new("sadrpour-rls", SYMBOLS, terms)),
};

/// By Bayesian estimation.
pub const BAYESIAN: Card = Card {
    name: "sadrpour-bayes",
    source: "Sadrpour 2012/2013: longitudinal dynamics, Bayesian estimation with a prior from the training drives",
    assumes: "turns cost nothing; past powers of the drive are known; its parameters are drawn as those of the training were",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::<Bayes>::default(),
};

#[cfg(test)]
mod tests {
    use super::{BAYESIAN, RECURSIVE};
    use crate::baselines::testing::{drive, recovers};
    use model_core::effects::GRAVITY;

    /// A vehicle of M = 4 kg, f = 1.5 N, b = 0.6 W on a road of up to 0.1 rad.
    const TRUTH: [f64; 3] = [0.6, 1.5, 4.0];

    fn points() -> Vec<crate::baselines::Point> {
        drive(2000, |point| {
            let (v, dv, grade) = (point.speed.vx, point.acceleration.vx, point.readings.pitch);
            let force = 4.0 * (dv + GRAVITY * grade.sin()) + 1.5 * grade.cos() * v.signum();
            0.6 + force * v
        })
    }

    /// The start where nothing is known pulls each parameter by at most |θ| / (1e6 λ), λ the smallest eigenvalue of XᵀX: above
    /// 1 with 2000 points (see `recursive`), so 5e-6 and less than 1e-5 of the smallest parameter; predictions drift with them.
    #[test]
    fn recursive_recovers_its_own_parameters() {
        recovers(&RECURSIVE, &points(), &TRUTH, 1e-5);
    }

    /// Segments of one truth agree but for the weak pull on each towards the mean of all, which is the truth as well: rounding,
    /// and the pull of its ridge of 1e-6 as above.
    #[test]
    fn bayesian_recovers_its_own_parameters() {
        recovers(&BAYESIAN, &points(), &TRUTH, 1e-5);
    }
}
