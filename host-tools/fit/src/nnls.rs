//! The exact optimum of Eq. 20, or of any linear least squares, under β ≥ 0: the active-set method
//! of Lawson and Hanson on the Gram matrix.

use nalgebra::{DMatrix, DVector};

use super::gram::{Scaled, Vector};

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
pub struct Solution<const P: usize> {
    /// Coefficients, scaled as the problem was.
    pub beta: Vector<P>,
    /// How the search ended.
    pub ending: Ending,
    /// Coefficients set free or fixed again.
    pub iterations: u32,
}

/// Gradients below this share of the (unit) columns count as zero.
const TOLERANCE: f64 = 1e-12;

/// Most iterations for each coefficient.
const MOST_ITERATIONS: u32 = 10;

/// Columns that depend on those already free, to this share of their square, stay fixed at 0.
const DEPENDENT: f64 = 1e-10;

/// Minimises the scaled cost over β ≥ 0.
pub fn solve<const P: usize>(problem: &Scaled<P>) -> Solution<P> {
    let most_iterations = MOST_ITERATIONS * P as u32;
    let mut free = [false; P];
    let mut barred = [false; P];
    let mut beta = Vector::<P>::zeros();
    let mut iterations = 0;
    loop {
        let descent = -problem.gradient(&beta);
        let candidate = (0..P)
            .filter(|&i| !free[i] && !barred[i] && descent[i] > TOLERANCE)
            .max_by(|&i, &j| descent[i].total_cmp(&descent[j]));
        let Some(entering) = candidate else {
            return Solution { beta, ending: Ending::Optimal, iterations };
        };
        if iterations >= most_iterations {
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
            let blocking = (0..P)
                .filter(|&i| free[i] && target[i] <= 0.0)
                .map(|i| (i, beta[i] / (beta[i] - target[i])))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((leaving, share)) = blocking else {
                beta = target;
                barred = [false; P];
                break;
            };
            beta += share * (target - beta);
            if leaving == entering && share <= 0.0 {
                // Rounding made its descent look positive.
                barred[entering] = true;
            }
            for i in 0..P {
                if free[i] && (i == leaving || beta[i] <= 0.0) {
                    free[i] = false;
                    beta[i] = 0.0;
                }
            }
            if iterations >= most_iterations {
                break;
            }
        }
    }
}

/// The least-squares solution with only the free coefficients; `None` where their columns depend on
/// each other.
fn unconstrained<const P: usize>(problem: &Scaled<P>, free: &[bool; P]) -> Option<Vector<P>> {
    let used: Vec<usize> = (0..P).filter(|&i| free[i]).collect();
    let matrix = DMatrix::from_fn(used.len(), used.len(), |i, j| problem.xx[(used[i], used[j])]);
    let right = DVector::from_fn(used.len(), |i, _| problem.xp[used[i]]);
    let factor = matrix.cholesky()?;
    if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot < DEPENDENT) {
        return None;
    }
    let solution = factor.solve(&right);
    let mut beta = Vector::<P>::zeros();
    for (value, i) in solution.iter().zip(used) {
        beta[i] = *value;
    }
    Some(beta)
}
