//! The exact optimum of Eq. 20 under β ≥ 0: the active-set method of Lawson and Hanson on the Gram matrix.

use model_core::eq18::REGRESSORS;
use nalgebra::{DMatrix, DVector};

use super::gram;

/// The problem of Eq. 18.
type Scaled = gram::Scaled<REGRESSORS>;
/// Its coefficients.
type Vector = gram::Vector<REGRESSORS>;

/// How the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The conditions of Karush, Kuhn and Tucker hold.
    Optimal,
    /// The set of free coefficients kept changing; the best found is returned.
    IterationLimit,
}

/// A non-negative solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Coefficients, scaled as the problem was.
    pub beta: Vector,
    /// How the search ended.
    pub ending: Ending,
    /// Coefficients set free or fixed again.
    pub iterations: u32,
}

/// Gradients below this share of the (unit) columns count as nought.
const TOLERANCE: f64 = 1e-12;

const MOST_ITERATIONS: u32 = 10 * REGRESSORS as u32;

/// Columns that depend on those already free, to this share of their square, stay fixed at 0.
const DEPENDENT: f64 = 1e-10;

/// Minimises the scaled cost over β ≥ 0.
pub fn solve(problem: &Scaled) -> Solution {
    let mut free = [false; REGRESSORS];
    let mut barred = [false; REGRESSORS];
    let mut beta = Vector::zeros();
    let mut iterations = 0;
    loop {
        let descent = -problem.gradient(&beta);
        let candidate = (0..REGRESSORS)
            .filter(|&i| !free[i] && !barred[i] && descent[i] > TOLERANCE)
            .max_by(|&i, &j| descent[i].total_cmp(&descent[j]));
        let Some(entering) = candidate else {
            return Solution { beta, ending: Ending::Optimal, iterations };
        };
        if iterations >= MOST_ITERATIONS {
            return Solution { beta, ending: Ending::IterationLimit, iterations };
        }
        free[entering] = true;
        // Step towards the free optimum; whoever reaches 0 first is fixed there.
        loop {
            iterations += 1;
            let Some(target) = unconstrained(problem, &free) else {
                // The new column adds nothing that the others cannot: leave it at 0.
                free[entering] = false;
                barred[entering] = true;
                break;
            };
            let blocking = (0..REGRESSORS)
                .filter(|&i| free[i] && target[i] <= 0.0)
                .map(|i| (i, beta[i] / (beta[i] - target[i])))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((leaving, share)) = blocking else {
                beta = target;
                barred = [false; REGRESSORS];
                break;
            };
            beta += share * (target - beta);
            if leaving == entering && share <= 0.0 {
                // Rounding made its descent look positive.
                barred[entering] = true;
            }
            for i in 0..REGRESSORS {
                if free[i] && (i == leaving || beta[i] <= 0.0) {
                    free[i] = false;
                    beta[i] = 0.0;
                }
            }
            if iterations >= MOST_ITERATIONS {
                break;
            }
        }
    }
}

/// The least-squares solution with only the free coefficients; `None` where their columns depend on each other.
fn unconstrained(problem: &Scaled, free: &[bool; REGRESSORS]) -> Option<Vector> {
    let used: Vec<usize> = (0..REGRESSORS).filter(|&i| free[i]).collect();
    let matrix = DMatrix::from_fn(used.len(), used.len(), |i, j| problem.xx[(used[i], used[j])]);
    let right = DVector::from_fn(used.len(), |i, _| problem.xp[used[i]]);
    let factor = matrix.cholesky()?;
    if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot < DEPENDENT) {
        return None;
    }
    let solution = factor.solve(&right);
    let mut beta = Vector::zeros();
    for (value, i) in solution.iter().zip(used) {
        beta[i] = *value;
    }
    Some(beta)
}
