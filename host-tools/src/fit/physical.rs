//! The six parameters of the signed torque model: Levenberg–Marquardt with bounds, on a Gram matrix.
//!
//! Away from the clamp the power is linear in 15 products of the six parameters ([`TorqueModel::expand`]), so a Gram matrix
//! over the wheels that are not clamped holds the whole problem. Which wheels those are depends on the parameters: fit, mark,
//! fit again, until the parameters stay.

use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::motion::{Motion, Wheel};
use model_core::torque::{self, Drive, PARAMETERS, SCRUB_PRODUCTS, TorqueModel};
use nalgebra::{SMatrix, SVector};

use super::assess::{MEDIAN_TO_STD, median};
use super::dataset::{Dataset, Row};
use super::gram::{self, Gram};
use super::levenberg::{self, LeastSquares, Limits};

/// Products that the parameters multiply: the 15 of Eq. 18 without gates, and those of the scrub.
pub const PRODUCTS: usize = REGRESSORS + SCRUB_PRODUCTS;

type Matrix = gram::Matrix<PRODUCTS>;
type Vector = gram::Vector<PRODUCTS>;
type Descent = levenberg::Descent<PARAMETERS>;

/// The parameters in the order of [`TorqueModel::to_array`].
pub type Parameters = SVector<f64, PARAMETERS>;
/// A covariance of the six.
pub type Covariance = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// How the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// No step within the bounds lowers the cost, and the weights of rows stay.
    Converged,
    /// Steps were still being found when their number was used up.
    IterationLimit,
    /// The weights of rows kept changing; the last fit is returned.
    WeightLimit,
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
    /// Weight of each row of the store: 0 where no wheel draws power, 1 as a rule.
    pub weights: Vec<f64>,
}

const MOST_STEPS: u32 = 500;
const MOST_ROUNDS: u32 = 40;
/// Cost reductions below this share of the cost end the search.
const SMALLEST_GAIN: f64 = 1e-13;

/// Fits the rows of the store.
///
/// A clamped wheel draws nothing, so a row's products are summed over the other wheels only. Rows weigh by Huber's rule:
/// residuals far beyond the usual count linearly, not squared. Where acceleration starts or a clamp lets go within the
/// filter's memory no model of filtered signals is right, and on clean data those few rows would decide the fit.
pub fn solve<const N: usize>(dataset: &Dataset<N>, drive: Drive) -> Solution {
    let store = &dataset.store;
    let limit = 0.1 * acceleration_rms(store);
    // Before anything is known of the torques, rows in which a wheel brakes are left out.
    let mut gram = Gram::default();
    let first = store.iter().filter(|row| drive == Drive::Regenerative || !brakes(&row.motion, limit));
    gram.extend(first.map(|row| (regressors(&row.motion, row.mass), row.power)));
    let problem = Problem::new(&gram);
    let ends = starts(&problem).into_iter().map(|start| problem.descend(start));
    let mut best =
        ends.min_by(|a, b| a.cost.total_cmp(&b.cost)).unwrap_or_else(|| problem.descend(Parameters::zeros()));
    let mut iterations = best.steps;
    let mut ending = Ending::WeightLimit;
    let mut weights = Vec::new();
    for _ in 0..MOST_ROUNDS {
        let torque = TorqueModel::from_array(best.parameters.into());
        weights = weigh(store, &torque, drive);
        let mut gram = Gram::default();
        let weighted = store.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
        gram.extend(weighted.map(|(row, weight)| {
            let root = weight.sqrt();
            let products = regressors(&driving(&torque, row, drive), row.mass);
            (products.map(|x| x * root), row.power * root)
        }));
        let next = Problem::new(&gram).descend(best.parameters);
        iterations += next.steps;
        let moved = (next.parameters - best.parameters).abs();
        let still = moved.iter().zip(&next.parameters).all(|(moved, value)| *moved <= STILL * value.abs());
        best = next;
        if still {
            ending = if best.converged { Ending::Converged } else { Ending::IterationLimit };
            break;
        }
    }
    Solution { torque: TorqueModel::from_array(best.parameters.into()), ending, iterations, weights }
}

/// Parameters that move by less than this share from round to round stay.
const STILL: f64 = 1e-4;

/// Residuals beyond this many standard deviations count linearly.
const HUBER: f64 = 4.0;

/// The motion of the wheels that draw power; those that the drive clamps are put at rest.
pub fn driving<const N: usize>(torque: &TorqueModel<f64>, row: &Row<N>, drive: Drive) -> Motion<f64, N> {
    let mut motion = row.motion;
    if drive == Drive::Dissipative {
        for wheel in &mut motion.wheels {
            if torque.wheel_power(wheel, row.mass) < 0.0 {
                *wheel = Wheel::default();
            }
        }
    }
    motion
}

/// 0 for rows in which no wheel draws power, Huber's weight for the others.
fn weigh<const N: usize>(rows: &[Row<N>], torque: &TorqueModel<f64>, drive: Drive) -> Vec<f64> {
    let residual = |row: &Row<N>| {
        let motion = driving(torque, row, drive);
        motion.is_moving().then(|| {
            let predicted: f64 = motion.wheels.iter().map(|wheel| torque.wheel_power(wheel, row.mass)).sum();
            (row.power - predicted).abs()
        })
    };
    let residuals: Vec<Option<f64>> = rows.iter().map(residual).collect();
    let mut sizes: Vec<f64> = residuals.iter().flatten().copied().collect();
    let Some(middle) = median(&mut sizes) else { return vec![0.0; rows.len()] };
    let usual = MEDIAN_TO_STD * middle;
    residuals.iter().map(|size| size.map_or(0.0, |size| (HUBER * usual / size).min(1.0))).collect()
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

/// The ungated regressors of a motion at a total mass in kg.
pub fn regressors<const N: usize>(motion: &Motion<f64, N>, mass: f64) -> [f64; PRODUCTS] {
    let base = eq18::regressors(Gate::Signed, &eq18::products(Gate::Signed, motion), mass);
    let scrub = torque::scrub_products(motion);
    let mut all = [0.0; PRODUCTS];
    let (first, last) = all.split_at_mut(REGRESSORS);
    first.copy_from_slice(&base);
    for ((place, product), power) in last.iter_mut().zip(scrub).zip(torque::SCRUB_POWERS) {
        *place = product * mass.powi(i32::from(power));
    }
    all
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
    let scrub = alone(REGRESSORS);
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
                scale * scrub,
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

impl Problem {
    fn new(gram: &Gram<PRODUCTS>) -> Self {
        let zero = Vector::zeros();
        let rows = gram.rows().max(1) as f64;
        Self { xx: gram.xx(), xp: gram.xp(), pp: gram.cost(&zero) * rows, rows }
    }

    fn descend(&self, start: Parameters) -> Descent {
        let limits = Limits { steps: MOST_STEPS, smallest_gain: SMALLEST_GAIN * self.pp };
        levenberg::descend(self, start, limits)
    }
}

impl LeastSquares<PARAMETERS> for Problem {
    fn cost(&self, parameters: &Parameters) -> f64 {
        let beta = expand(parameters);
        self.pp - 2.0 * beta.dot(&self.xp) + beta.dot(&(self.xx * beta))
    }

    fn derivatives(&self, parameters: &Parameters) -> (Parameters, Covariance) {
        let beta = expand(parameters);
        let jacobian = jacobian(parameters);
        let gradient = jacobian.transpose() * (self.xx * beta - self.xp);
        (gradient, jacobian.transpose() * self.xx * jacobian)
    }
}

fn expand(parameters: &Parameters) -> Vector {
    let torque = TorqueModel::from_array((*parameters).into());
    Vector::from_iterator(torque.expand().into_iter().chain(torque.expand_scrub()))
}

/// ∂β/∂θ, one row a product, one column a parameter.
pub fn jacobian(parameters: &Parameters) -> SMatrix<f64, PRODUCTS, PARAMETERS> {
    let torque = TorqueModel::from_array((*parameters).into());
    let (base, scrub) = (torque.expansion_jacobian(), torque.scrub_jacobian());
    SMatrix::from_fn(|i, j| if i < REGRESSORS { base[i][j] } else { scrub[i - REGRESSORS][j] })
}
