//! The six parameters of the signed torque model: Levenberg–Marquardt with bounds, on a Gram matrix.
//!
//! Away from the clamp the power is linear in 15 products of the six parameters ([`TorqueModel::expand`]), so a Gram matrix
//! of the rows in which no wheel is clamped holds the whole problem. Which rows those are depends on the parameters:
//! fit, mark, fit again, until the marks stay.

use model_core::motion::Motion;
use model_core::torque::{Drive, PARAMETERS, TorqueModel};
use nalgebra::{SMatrix, SVector};

use super::dataset::{Dataset, Row};
use super::gram::{Gram, Matrix, Vector};
use model_core::eq18::{self, Gate, REGRESSORS};

/// The six parameters in the order of [`TorqueModel::to_array`].
pub type Parameters = SVector<f64, PARAMETERS>;
/// A covariance of the six.
pub type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// How the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// No step within the bounds lowers the cost, and the marks of clamped rows stay.
    Converged,
    /// Steps were still being found when their number was used up.
    IterationLimit,
    /// The marks of clamped rows kept changing; the last fit is returned.
    MaskLimit,
}

/// A fitted torque model.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The parameters.
    pub torque: TorqueModel<f64>,
    /// How the search ended.
    pub ending: Ending,
    /// Steps taken, over all masks.
    pub iterations: u32,
    /// Which rows of the store were used.
    pub used: Vec<bool>,
}

const MOST_STEPS: u32 = 500;
const MOST_MASKS: u32 = 30;
/// Cost reductions below this share of the cost end the search.
const SMALLEST_GAIN: f64 = 1e-13;

/// Fits the rows of the store.
pub fn solve<const N: usize>(dataset: &Dataset<N>, drive: Drive) -> Solution {
    let store = &dataset.store;
    let mut used: Vec<bool> = match drive {
        Drive::Regenerative => vec![true; store.len()],
        Drive::Dissipative => {
            let limit = 0.1 * acceleration_rms(store);
            store.iter().map(|row| !brakes(&row.motion, limit)).collect()
        }
    };
    let mut iterations = 0;
    let mut best = {
        let problem = Problem::new(&masked_gram(store, &used));
        let ends = starts(&problem).into_iter().map(|start| problem.descend(start));
        ends.min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or_else(|| problem.descend(Parameters::zeros()))
    };
    iterations += best.steps;
    let mut ending = best.ending;
    if drive == Drive::Dissipative {
        ending = Ending::MaskLimit;
        for _ in 0..MOST_MASKS {
            let torque = TorqueModel::from_array(best.parameters.into());
            let next: Vec<bool> = store.iter().map(|row| !is_clamped(&torque, row)).collect();
            let changed = next.iter().zip(&used).filter(|(a, b)| a != b).count();
            used = next;
            // One row in ten thousand moves the parameters by far less than their errors.
            if changed * 10_000 <= store.len() {
                ending = best.ending;
                break;
            }
            best = Problem::new(&masked_gram(store, &used)).descend(best.parameters);
            iterations += best.steps;
        }
    }
    Solution { torque: TorqueModel::from_array(best.parameters.into()), ending, iterations, used }
}

/// A wheel decelerates by more than `limit`, rad/s².
fn brakes<const N: usize>(motion: &Motion<f64, N>, limit: f64) -> bool {
    motion.wheels.iter().any(|wheel| wheel.acceleration * wheel.direction < -limit)
}

fn acceleration_rms<const N: usize>(rows: &[Row<N>]) -> f64 {
    let squares: f64 =
        rows.iter().flat_map(|row| &row.motion.wheels).map(|wheel| wheel.acceleration.powi(2)).sum();
    (squares / (rows.len() * N).max(1) as f64).sqrt()
}

/// A wheel's torque opposes its motion at the row's mass: the drive may clamp it.
fn is_clamped<const N: usize>(torque: &TorqueModel<f64>, row: &Row<N>) -> bool {
    row.motion.wheels.iter().any(|wheel| torque.torque(wheel, row.mass) * wheel.direction < 0.0)
}

/// The ungated regressors of a row.
pub fn regressors<const N: usize>(row: &Row<N>) -> [f64; REGRESSORS] {
    eq18::regressors(Gate::Signed, &eq18::products(Gate::Signed, &row.motion), row.mass)
}

fn masked_gram<const N: usize>(rows: &[Row<N>], used: &[bool]) -> Gram {
    let mut gram = Gram::default();
    for (row, _) in rows.iter().zip(used).filter(|(_, used)| **used) {
        gram.add(&regressors(row), row.power);
    }
    gram
}

/// Start values: linear terms from power over speed, for several shares of winding loss.
fn starts(problem: &Problem) -> Vec<Parameters> {
    // Coulomb and rolling torque, viscous torque and inertias each alone explain this power.
    let alone = |index: usize| {
        let square = problem.xx[(index, index)];
        if square > 0.0 { (problem.xp[index] / square).max(0.0) } else { 0.0 }
    };
    let (coulomb, rolling, viscous) = (alone(6), alone(7), alone(3));
    let (rotor, gain) = (alone(12), alone(13));
    let torque_scale = coulomb.max(1e-9);
    // Speed per torque: there κ τ² equals τ w.
    let speed = if problem.xx[(6, 6)] > 0.0 { (problem.xx[(6, 6)] / problem.rows).sqrt() } else { 1.0 };
    let mut starts = Vec::new();
    for loss in [0.0, 0.1, 1.0, 10.0] {
        for share in [0.05, 0.5] {
            let scale = 0.3 / (1.0 + loss);
            starts.push(Parameters::from([
                scale * coulomb,
                scale * rolling,
                scale * viscous,
                share * rotor,
                share * gain,
                loss * speed / torque_scale,
            ]));
        }
    }
    starts
}

/// Sum of squares as a function of the six parameters.
struct Problem {
    xx: Matrix,
    xp: Vector,
    pp: f64,
    rows: f64,
}

struct Descent {
    parameters: Parameters,
    cost: f64,
    steps: u32,
    ending: Ending,
}

impl Problem {
    fn new(gram: &Gram) -> Self {
        let zero = Vector::zeros();
        let rows = gram.rows().max(1) as f64;
        Self { xx: gram.xx(), xp: gram.xp(), pp: gram.cost(&zero) * rows, rows }
    }

    fn cost(&self, parameters: &Parameters) -> f64 {
        let beta = expand(parameters);
        self.pp - 2.0 * beta.dot(&self.xp) + beta.dot(&(self.xx * beta))
    }

    /// ½ ∂cost/∂θ and the Gauss–Newton matrix.
    fn derivatives(&self, parameters: &Parameters) -> (Parameters, Covariance) {
        let beta = expand(parameters);
        let jacobian = jacobian(parameters);
        let gradient = jacobian.transpose() * (self.xx * beta - self.xp);
        (gradient, jacobian.transpose() * self.xx * jacobian)
    }

    fn descend(&self, start: Parameters) -> Descent {
        let mut parameters = start.map(|value| value.max(0.0));
        let mut cost = self.cost(&parameters);
        let mut damping = 1e-3;
        let mut ending = Ending::IterationLimit;
        let mut steps = 0;
        while steps < MOST_STEPS {
            steps += 1;
            let (gradient, hessian) = self.derivatives(&parameters);
            let Some(next) = step(&parameters, &gradient, &hessian, damping) else {
                ending = Ending::Converged;
                break;
            };
            let next_cost = self.cost(&next);
            if next_cost < cost {
                let gain = cost - next_cost;
                parameters = next;
                cost = next_cost;
                damping = (damping / 5.0).max(1e-12);
                if gain <= SMALLEST_GAIN * self.pp {
                    ending = Ending::Converged;
                    break;
                }
            } else {
                damping *= 4.0;
                if damping > 1e12 {
                    ending = Ending::Converged;
                    break;
                }
            }
        }
        Descent { parameters, cost, steps, ending }
    }
}

/// One damped step, projected on θ ≥ 0. Parameters at 0 that the gradient pushes outwards stay there. `None` where none is
/// left to move.
fn step(
    parameters: &Parameters,
    gradient: &Parameters,
    hessian: &Covariance,
    damping: f64,
) -> Option<Parameters> {
    let free: Vec<usize> = (0..PARAMETERS)
        .filter(|&i| hessian[(i, i)] > 0.0 && (parameters[i] > 0.0 || gradient[i] < 0.0))
        .collect();
    if free.is_empty() {
        return None;
    }
    // In units of each column's length, so that damping and Cholesky see no units.
    let scale: Vec<f64> = free.iter().map(|&i| hessian[(i, i)].sqrt()).collect();
    let mut matrix = nalgebra::DMatrix::from_fn(free.len(), free.len(), |i, j| {
        hessian[(free[i], free[j])] / (scale[i] * scale[j])
    });
    for i in 0..free.len() {
        matrix[(i, i)] += damping;
    }
    let right = nalgebra::DVector::from_fn(free.len(), |i, _| -gradient[free[i]] / scale[i]);
    let move_by = matrix.cholesky()?.solve(&right);
    let mut next = *parameters;
    for ((&index, delta), scale) in free.iter().zip(move_by.iter()).zip(&scale) {
        next[index] = (next[index] + delta / scale).max(0.0);
    }
    Some(next)
}

fn expand(parameters: &Parameters) -> Vector {
    Vector::from(TorqueModel::from_array((*parameters).into()).expand())
}

/// ∂β/∂θ, 15 × 6.
pub fn jacobian(parameters: &Parameters) -> SMatrix<f64, REGRESSORS, PARAMETERS> {
    let rows = TorqueModel::from_array((*parameters).into()).expansion_jacobian();
    SMatrix::from_fn(|i, j| rows[i][j])
}
