//! What a fit is worth: errors on its own rows, standard errors, and the noise that payload estimates have to expect.

use model_core::coefficients::Robot as CoreRobot;
use model_core::model::Model;
use model_core::payload::Noise;
use nalgebra::{DMatrix, DVector};

use super::dataset::{Dataset, Row};
use crate::metrics::{Metrics, Quality};

/// Blocks that standard errors are drawn from, at most.
const MOST_BLOCKS: usize = 64;

/// Shortest block, s: several correlation times of power behind the filter.
const SHORTEST_BLOCK_S: f64 = 2.0;

/// Buckets in which the scatter of mass scores is measured, s: those of the payload estimators.
const BUCKET_S: f64 = 1.0;

/// A covariance, with the directions in which the data say nothing.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// Covariance of the parameters within what the data determine.
    pub covariance: DMatrix<f64>,
    /// Directions (unit vectors of scaled parameters) that the data do not determine.
    pub undetermined: Vec<DVector<f64>>,
    /// Ratio of the extreme eigenvalues of the scaled normal matrix.
    pub condition: f64,
    /// Root mean square of what the covariance does to the predicted power of these rows, W.
    pub prediction_std_w: f64,
}

/// Errors of the model on the rows it was fitted to, at their true mass.
pub fn quality<const N: usize>(dataset: &Dataset<N>, model: &Model<f64>, floor_w: f64) -> Option<Quality> {
    let mut metrics = Metrics::new(floor_w);
    for row in &dataset.store {
        if let Some(predicted) = model.power(&row.motion, row.mass) {
            metrics.add(row.power, predicted);
        }
    }
    metrics.quality()
}

/// Standard errors that hold for autocorrelated residuals: scores are summed over blocks of time, and the scatter of the
/// sums is what counts (the sandwich estimator, clustered by block).
///
/// `gradient` gives ∂P/∂θ of a row, `weights` what each row of the store counted for.
pub fn uncertainty<const N: usize>(
    dataset: &Dataset<N>,
    weights: &[f64],
    predict: impl Fn(&Row<N>) -> f64,
    gradient: impl Fn(&Row<N>) -> DVector<f64>,
    parameters: usize,
) -> Uncertainty {
    let block_s = block_length(dataset);
    let mut normal = DMatrix::<f64>::zeros(parameters, parameters);
    let mut scores: Vec<DVector<f64>> = Vec::new();
    let mut current: Option<(u32, i64)> = None;
    let mut rows = 0_usize;
    for (row, &weight) in dataset.store.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
        let key = (row.run, (row.time / block_s).floor() as i64);
        if current != Some(key) {
            current = Some(key);
            scores.push(DVector::zeros(parameters));
        }
        let slope = gradient(row);
        normal.ger(weight, &slope, &slope, 1.0);
        if let Some(score) = scores.last_mut() {
            score.axpy(weight * (row.power - predict(row)), &slope, 1.0);
        }
        rows += 1;
    }
    let scale = DVector::from_fn(parameters, |i, _| normal[(i, i)].max(0.0).sqrt());
    let unit = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
    let scaled = DMatrix::from_fn(parameters, parameters, |i, j| normal[(i, j)] * unit(i) * unit(j));
    let eigen = scaled.clone().symmetric_eigen();
    let most = eigen.eigenvalues.max();
    let mut inverse = DMatrix::<f64>::zeros(parameters, parameters);
    let mut undetermined = Vec::new();
    let mut least = f64::INFINITY;
    for (index, value) in eigen.eigenvalues.iter().enumerate() {
        let direction = eigen.eigenvectors.column(index).into_owned();
        if *value > 1e-9 * most {
            inverse.ger(1.0 / value, &direction, &direction, 1.0);
            least = least.min(*value);
        } else {
            undetermined.push(direction);
        }
    }
    let mut meat = DMatrix::<f64>::zeros(parameters, parameters);
    for score in &scores {
        let score = DVector::from_fn(parameters, |i, _| score[i] * unit(i));
        meat.ger(1.0, &score, &score, 1.0);
    }
    let blocks = scores.len() as f64;
    let spare = (blocks - parameters as f64).max(1.0);
    let sandwich = &inverse * meat * &inverse * (blocks / spare);
    let prediction = (&sandwich * &scaled).trace() / rows.max(1) as f64;
    Uncertainty {
        covariance: DMatrix::from_fn(parameters, parameters, |i, j| sandwich[(i, j)] * unit(i) * unit(j)),
        condition: if undetermined.is_empty() { most / least } else { f64::INFINITY },
        undetermined,
        prediction_std_w: prediction.max(0.0).sqrt(),
    }
}

fn block_length<const N: usize>(dataset: &Dataset<N>) -> f64 {
    let duration = dataset.store.len() as f64 * dataset.store_period_s();
    (duration / MOST_BLOCKS as f64).max(SHORTEST_BLOCK_S)
}

/// How far the residuals stray as a payload estimator sees them: the scatter of Σ g e over a second, per Σ g², g = ∂P/∂m.
pub fn noise<const N: usize>(dataset: &Dataset<N>, model: &Model<f64>, model_std: f64) -> Noise<f64> {
    let robot: &CoreRobot<f64, N> = &dataset.robot;
    let middle = robot.range.middle();
    let (mut squares, mut neighbours, mut information) = (0.0, 0.0, 0.0);
    let mut current: Option<(u32, i64)> = None;
    let (mut score, mut last_score) = (0.0, 0.0);
    let mut close = |score: f64, last: f64| {
        squares += score * score;
        neighbours += score * last;
    };
    for row in &dataset.store {
        let key = (row.run, (row.time / BUCKET_S).floor() as i64);
        if current != Some(key) {
            close(score, last_score);
            let follows = current.is_some_and(|(run, second)| key == (run, second + 1));
            last_score = if follows { score } else { 0.0 };
            score = 0.0;
            current = Some(key);
        }
        let response = model.response(&row.motion, &robot.range);
        if response.may_clamp {
            continue;
        }
        let slope = response.polynomial.slope(row.mass - middle);
        score += slope * (row.power - response.polynomial.at(row.mass - middle));
        information += slope * slope;
    }
    close(score, last_score);
    let scatter = (squares + 2.0 * neighbours).max(squares / 2.0);
    let density = if information > 0.0 { dataset.store_period_s() * scatter / information } else { 0.0 };
    Noise { density, model_std }
}
