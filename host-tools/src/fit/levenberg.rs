//! Levenberg–Marquardt under θ ≥ 0, for a sum of squares that gives its derivatives.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// A sum of squares as a function of `P` parameters.
pub trait LeastSquares<const P: usize> {
    /// The sum.
    fn cost(&self, parameters: &SVector<f64, P>) -> f64;

    /// ½ of its gradient, and the Gauss–Newton matrix JᵀJ.
    fn derivatives(&self, parameters: &SVector<f64, P>) -> (SVector<f64, P>, SMatrix<f64, P, P>);
}

/// When to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most steps, those that were taken back included.
    pub steps: u32,
    /// A step that lowers the cost by no more than this is the last.
    pub smallest_gain: f64,
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Descent<const P: usize> {
    /// The parameters, each at least 0.
    pub parameters: SVector<f64, P>,
    /// Their cost.
    pub cost: f64,
    /// Steps, those that were taken back included.
    pub steps: u32,
    /// No step within the bounds lowers the cost; false where their number was used up first.
    pub converged: bool,
}

/// Goes downhill from `start` within θ ≥ 0.
pub fn descend<const P: usize>(
    problem: &impl LeastSquares<P>,
    start: SVector<f64, P>,
    limits: Limits,
) -> Descent<P> {
    let mut parameters = start.map(|value| value.max(0.0));
    let mut cost = problem.cost(&parameters);
    let mut damping = 1e-3;
    let mut converged = false;
    let mut steps = 0;
    let mut derivatives = problem.derivatives(&parameters);
    while steps < limits.steps && !converged {
        steps += 1;
        let (gradient, hessian) = &derivatives;
        let Some(next) = step(&parameters, gradient, hessian, damping) else {
            converged = true;
            break;
        };
        let next_cost = problem.cost(&next);
        if next_cost < cost {
            converged = cost - next_cost <= limits.smallest_gain;
            parameters = next;
            cost = next_cost;
            damping = (damping / 5.0).max(1e-12);
            derivatives = problem.derivatives(&parameters);
        } else {
            damping *= 4.0;
            converged = damping > 1e12;
        }
    }
    Descent { parameters, cost, steps, converged }
}

/// One damped step, projected on θ ≥ 0. Parameters at 0 that the gradient pushes outwards stay there. `None` where none is
/// left to move.
fn step<const P: usize>(
    parameters: &SVector<f64, P>,
    gradient: &SVector<f64, P>,
    hessian: &SMatrix<f64, P, P>,
    damping: f64,
) -> Option<SVector<f64, P>> {
    let free: Vec<usize> =
        (0..P).filter(|&i| hessian[(i, i)] > 0.0 && (parameters[i] > 0.0 || gradient[i] < 0.0)).collect();
    if free.is_empty() {
        return None;
    }
    // In units of each column's length, so that damping and Cholesky see no units.
    let scale: Vec<f64> = free.iter().map(|&i| hessian[(i, i)].sqrt()).collect();
    let mut matrix =
        DMatrix::from_fn(free.len(), free.len(), |i, j| hessian[(free[i], free[j])] / (scale[i] * scale[j]));
    for i in 0..free.len() {
        matrix[(i, i)] += damping;
    }
    let right = DVector::from_fn(free.len(), |i, _| -gradient[free[i]] / scale[i]);
    let move_by = matrix.cholesky()?.solve(&right);
    let mut next = *parameters;
    for ((&index, delta), scale) in free.iter().zip(move_by.iter()).zip(&scale) {
        next[index] = (next[index] + delta / scale).max(0.0);
    }
    Some(next)
}
