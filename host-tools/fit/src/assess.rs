//! What a fit is worth: errors on its own rows, standard errors, and the noise that payload
//! estimates have to expect.

use std::collections::{BTreeMap, BTreeSet};

use model_core::model::Model;
use model_core::payload::{Noise, huber};
use nalgebra::{DMatrix, DVector};
use numerics::intervals::student_95;
use numerics::robust::{NORMAL_95, median, quantile, scale_of_sizes};
use numerics::scaled_inverse::ScaledInverse;
use support::metrics::{Metrics, Quality};

use super::dataset::{Dataset, Kept};
use super::kinds::{Kinds, PAIRS};

/// Blocks that standard errors are drawn from, at most.
const MOST_BLOCKS: usize = 64;

/// Shortest block, s: several correlation times of power after the filter.
const SHORTEST_BLOCK_S: f64 = 2.0;

/// Blocks in which the scatter of mass scores is measured, s: two buckets of a payload estimator,
/// to see the correlation of neighbours.
pub const BLOCK_S: f64 = 2.0;

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
pub fn quality(dataset: &Dataset, model: &Model<f64>, floor_w: f64) -> Option<Quality> {
    let mut metrics = Metrics::new(floor_w);
    for row in dataset.store.iter() {
        if let Some(predicted) = row.predicted(model) {
            metrics.add(row.power, predicted);
        }
    }
    metrics.quality()
}

/// Standard errors that hold for autocorrelated residuals: scores are summed over blocks of time,
/// and the scatter of the sums is what counts (the sandwich estimator, clustered by block).
///
/// `gradient` gives ∂P/∂θ of a row, `weights` what each row of the store counted for.
pub fn uncertainty(
    dataset: &Dataset,
    weights: &[f64],
    predict: impl Fn(&Kept<'_>) -> f64,
    gradient: impl Fn(&Kept<'_>) -> DVector<f64>,
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
        let slope = gradient(&row);
        normal.ger(weight, &slope, &slope, 1.0);
        if let Some(score) = scores.last_mut() {
            score.axpy(weight * (row.power - predict(&row)), &slope, 1.0);
        }
        rows += 1;
    }
    sandwich(&normal, &scores, rows)
}

/// The sandwich of a normal matrix Σ xxᵀ and the scores Σ x e of clusters with independent
/// residuals; `rows` were summed.
pub fn sandwich(normal: &DMatrix<f64>, scores: &[DVector<f64>], rows: usize) -> Uncertainty {
    let parameters = normal.nrows();
    let inverse = ScaledInverse::of(normal);
    let mut meat = DMatrix::<f64>::zeros(parameters, parameters);
    for score in scores {
        let score = DVector::from_fn(parameters, |i, _| score[i] * inverse.unit[i]);
        meat.ger(1.0, &score, &score, 1.0);
    }
    let blocks = scores.len() as f64;
    let spare = (blocks - parameters as f64).max(1.0);
    let sandwich = &inverse.inverse * meat * &inverse.inverse * (blocks / spare);
    let prediction = (&sandwich * &inverse.scaled).trace() / rows.max(1) as f64;
    Uncertainty {
        covariance: inverse.unscaled(&sandwich),
        condition: inverse.condition,
        undetermined: inverse.undetermined,
        prediction_std_w: prediction.max(0.0).sqrt(),
    }
}

fn block_length(dataset: &Dataset) -> f64 {
    let duration = dataset.store.len() as f64 * dataset.store_period_s();
    (duration / MOST_BLOCKS as f64).max(SHORTEST_BLOCK_S)
}

/// Windows over which an error that lasts is judged, s.
pub const WINDOW_S: f64 = 10.0;

/// The constant error in W that would disturb mass estimates over ten seconds as the coefficients'
/// uncertainty does.
///
/// A coefficient's error δ adds Σ g xᵀδ to the score of a window, a constant error e adds e Σ g
/// (g = ∂P/∂m, x = ∂P/∂θ); their standard deviations are equated window by window, and the median
/// taken.
pub fn lasting_error(
    dataset: &Dataset,
    model: &Model<f64>,
    gradient: impl Fn(&Kept<'_>) -> DVector<f64>,
    covariance: &DMatrix<f64>,
    noise: &Noise<f64>,
) -> f64 {
    let range = &dataset.robot.range();
    let linear_beyond = noise.linear_beyond(dataset.robot.cutoff_hz());
    let mut errors = Vec::new();
    let mut close = |score: &DVector<f64>, slope: f64| {
        if slope != 0.0 {
            errors.push((covariance * score).dot(score).max(0.0).sqrt() / slope.abs());
        }
    };
    let mut current: Option<(u32, i64)> = None;
    let (mut score, mut slope_sum) = (DVector::zeros(covariance.nrows()), 0.0);
    for row in dataset.store.iter() {
        let key = (row.run, (row.time / WINDOW_S).floor() as i64);
        if current != Some(key) {
            close(&score, slope_sum);
            score.fill(0.0);
            slope_sum = 0.0;
            current = Some(key);
        }
        let response = row.response(model, range);
        if !response.may_clamp {
            let from_middle = row.mass - range.middle();
            let weight = huber(row.power - response.polynomial.at(from_middle), linear_beyond);
            let slope = weight * response.polynomial.slope(from_middle);
            score.axpy(slope, &gradient(&row), 1.0);
            slope_sum += slope;
        }
    }
    close(&score, slope_sum);
    median(&mut errors).unwrap_or(0.0)
}

/// Runs from which on each counts as one drive; of fewer, stretches of [`DRIVE_S`] do.
const ENOUGH_RUNS: usize = 6;

/// A stretch that counts as a drive where there are few runs, s: the estimators' default window.
const DRIVE_S: f64 = 25.0;

/// Standard deviation of a drive's energy about the model's, beyond what the noise explains, as a
/// share of it. Between runs, which differ by floor, warmth and battery, where there are enough; or
/// between kinds of driving in a run (slow or fast, straight or turning), whichever stray more: a
/// task may be of one kind.
/// As much wider as Student's t is for so many; 0 where there are too few to tell.
pub fn energy_spread(dataset: &Dataset, model: &Model<f64>, noise: &Noise<f64>) -> f64 {
    let runs: BTreeSet<u32> = dataset.store.iter().map(|row| row.run).collect();
    let stretch = |time: f64| if runs.len() < ENOUGH_RUNS { (time / DRIVE_S).floor() as i64 } else { 0 };
    let kinds = Kinds::of(&dataset.store);
    let period = dataset.store_period_s();
    let mut drives = BTreeMap::new();
    let mut of_kinds = PAIRS.map(|_| BTreeMap::new());
    for row in dataset.store.iter() {
        let Some(predicted) = row.predicted(model) else { continue };
        let one = [(row.power - predicted) * period, predicted.abs() * period, period];
        let drive: &mut [f64; 3] = drives.entry((row.run, stretch(row.time))).or_default();
        let add = |sums: &mut [f64; 3]| sums.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
        add(drive);
        for (pair, of_kind) in PAIRS.iter().zip(&mut of_kinds) {
            add(of_kind.entry((row.run, kinds.kind(&row) & pair)).or_default());
        }
    }
    let of_kinds = of_kinds.iter().map(|of_kind| share(of_kind.values(), noise));
    of_kinds.fold(share(drives.values(), noise), f64::max)
}

/// Of drives: error and energy in J, and time in s.
fn share<'a>(drives: impl Iterator<Item = &'a [f64; 3]> + Clone, noise: &Noise<f64>) -> f64 {
    let all: f64 = drives.clone().map(|[_, energy, _]| energy).sum();
    // Each weighs by its energy: the least say nothing of shares.
    let told = drives.clone().filter(|[_, energy, _]| *energy > 0.0);
    let squares: f64 =
        told.map(|[error, energy, time]| (error * error - noise.density * time) / energy).sum();
    let effective = all * all / drives.map(|[_, energy, _]| energy * energy).sum::<f64>();
    let wider = student_95(effective).map_or(0.0, |student| student / NORMAL_95);
    let share = wider * (squares / all).max(0.0).sqrt();
    if share.is_finite() { share } else { 0.0 }
}

/// How far the residuals stray as a payload estimator sees them: the scatter of Σ g e over two
/// seconds, per Σ g², g = ∂P/∂m. The median block counts: the few blocks in which no model of
/// filtered signals is right show in the estimator's own windows. Longer-lasting errors stay 0.
///
/// Residuals beyond what most samples leave count linearly, as there.
pub fn noise(dataset: &Dataset, model: &Model<f64>) -> Noise<f64> {
    let residual_std = usual_residual(dataset, model);
    let usual = Noise { residual_std, ..Noise::default() };
    Noise { residual_std, ..scatter(dataset, model, usual.linear_beyond(dataset.robot.cutoff_hz())) }
}

/// Standard deviation of the residuals from which a payload estimator learns, W, by their median
/// size.
fn usual_residual(dataset: &Dataset, model: &Model<f64>) -> f64 {
    let range = &dataset.robot.range();
    let size = |row: Kept<'_>| {
        let response = row.response(model, range);
        let from_middle = row.mass - range.middle();
        let tells = !response.may_clamp && response.polynomial.slope(from_middle) != 0.0;
        tells.then(|| (row.power - response.polynomial.at(from_middle)).abs())
    };
    let mut sizes: Vec<f64> = dataset.store.iter().filter_map(size).collect();
    scale_of_sizes(&mut sizes).unwrap_or(0.0)
}

fn scatter(dataset: &Dataset, model: &Model<f64>, linear_beyond: f64) -> Noise<f64> {
    let range = &dataset.robot.range();
    let mut noise = Noise { density: 0.0, model_std: 0.0, tail: 1.0, residual_std: 0.0 };
    // Score and information of each block.
    let mut blocks: Vec<(f64, f64)> = Vec::new();
    let mut current: Option<(u32, i64)> = None;
    for row in dataset.store.iter() {
        let key = (row.run, (row.time / BLOCK_S).floor() as i64);
        if current != Some(key) {
            blocks.push((0.0, 0.0));
            current = Some(key);
        }
        let response = row.response(model, range);
        if let Some((score, information)) = blocks.last_mut()
            && !response.may_clamp
        {
            let from_middle = row.mass - range.middle();
            let slope = response.polynomial.slope(from_middle);
            let error = row.power - response.polynomial.at(from_middle);
            let weighted = huber(error, linear_beyond) * slope;
            *score += weighted * error;
            *information += weighted * slope;
        }
    }
    if let Some((usual, tail)) = scatter_of(&blocks) {
        noise.density = dataset.store_period_s() * usual * usual;
        noise.tail = tail.max(1.0);
    }
    noise
}

/// How mass scores scatter over blocks, each given by its score and its information: the usual
/// |score| / √information, and the factor by which its 95 % quantile exceeds that of a normal
/// variable. `None` without blocks.
pub fn scatter_of(blocks: &[(f64, f64)]) -> Option<(f64, f64)> {
    let most = blocks.iter().map(|(_, information)| *information).fold(0.0, f64::max);
    let told = blocks.iter().filter(|(_, information)| *information > LEAST_SHARE * most);
    let mut sizes: Vec<f64> = told.map(|(score, information)| score.abs() / information.sqrt()).collect();
    let usual = scale_of_sizes(&mut sizes)?;
    Some((usual, quantile(&mut sizes, 0.95)? / (NORMAL_95 * usual)))
}

/// Blocks with less than this share of the most informative one's information are left out.
const LEAST_SHARE: f64 = 0.01;
