//! Eq. 18's coefficients: the quadratic problem of Eq. 20, by Algorithm 1 or exactly.

use std::time::Instant;

use model_core::eq18::REGRESSORS;

use super::pgd::Vector;
use super::{gram, nnls, pgd};

/// Sums over the regressors of Eq. 18.
type Gram = gram::Gram<REGRESSORS>;

/// What Algorithm 1 did, judged by the exact optimum.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Certificate {
    /// Iterations taken.
    pub iterations: u64,
    /// Time taken, s.
    pub seconds: f64,
    /// How it ended.
    pub ending: pgd::Ending,
    /// Mean squared error above the exact optimum's, as a share of that.
    pub excess_cost: f64,
}

/// Coefficients by the exact method.
pub fn by_nnls(gram: &Gram) -> (Vector, nnls::Solution<REGRESSORS>) {
    let problem = gram.scaled();
    let solution = nnls::solve(&problem);
    (problem.unscale(&solution.beta), solution)
}

/// Coefficients by Algorithm 1, and how far they are from the optimum.
pub fn by_pgd(gram: &Gram, settings: &pgd::Settings) -> (Vector, Certificate) {
    let problem = gram.scaled();
    let started = Instant::now();
    let solution = pgd::solve(&problem, Vector::zeros(), settings);
    let seconds = started.elapsed().as_secs_f64();
    let beta = problem.unscale(&solution.beta);
    let (optimum, _) = by_nnls(gram);
    let least = gram.cost(&optimum);
    let excess_cost = if least > 0.0 { (gram.cost(&beta) - least) / least } else { 0.0 };
    (beta, Certificate { iterations: solution.iterations, seconds, ending: solution.ending, excess_cost })
}
