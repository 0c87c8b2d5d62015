//! How far mass estimates stray on windows that the fit has not seen, beyond what its noise
//! explains.
//!
//! Each window of the training logs is left out in turn: the coefficients move by one step of Gauss
//! and Newton without its rows, and what its own rows then say of the mass is held against the
//! noise of the fit. A model that lacks something errs alike for as long as a robot drives alike.
//! Residuals of the fit itself hide that: every window has pulled the coefficients its own way.

use model_core::model::Model;
use model_core::payload::{Noise, huber};
use nalgebra::{DMatrix, DVector};
use numerics::intervals::student_95;
use numerics::robust::NORMAL_95;
use numerics::scaled_inverse::ScaledInverse;
use numerics::search::bisect;

use super::dataset::{Dataset, Row};

/// Half a window, s. A window of 25 s is the estimators' default; every half of one ends a window.
const HALF_S: f64 = 12.5;

/// Whole windows below which nothing is concluded: the scatter of fewer is chance.
const LEAST_WINDOWS: f64 = 6.0;

/// Sums over rows: what they pulled the fit by, and what they say of the mass.
#[derive(Clone)]
struct Sums {
    /// Σ w x xᵀ with x = ∂P/∂θ and the fit's weights w.
    normal: DMatrix<f64>,
    /// Σ w x e, e being measured less predicted power.
    pull: DVector<f64>,
    /// Σ v g e with g = ∂P/∂m and the estimators' weights v.
    score: f64,
    /// Σ v g x: by what the score changes with the parameters.
    leverage: DVector<f64>,
    /// Σ v g².
    information: f64,
    /// Σ v g: what a constant error of 1 W adds to the score.
    slope: f64,
}

impl Sums {
    fn new(parameters: usize) -> Self {
        let (normal, none) = (DMatrix::zeros(parameters, parameters), DVector::zeros(parameters));
        Self { normal, pull: none.clone(), score: 0.0, leverage: none, information: 0.0, slope: 0.0 }
    }

    fn merged(mut self, other: &Self) -> Self {
        self.normal += &other.normal;
        self.pull += &other.pull;
        self.score += other.score;
        self.leverage += &other.leverage;
        self.information += other.information;
        self.slope += other.slope;
        self
    }

    /// The score once the rows are left out of the fit of all, whose normal matrix is `whole`.
    fn unseen_score(&self, whole: &DMatrix<f64>) -> f64 {
        let others = ScaledInverse::of(&(whole - &self.normal));
        let step = others.unscaled(&others.inverse) * &self.pull;
        self.score + self.leverage.dot(&step)
    }
}

/// A window's score beside what is expected of it.
struct Stray {
    /// (W²/kg)²
    square: f64,
    /// By the fit's noise, (W²/kg)².
    expected: f64,
    /// By a constant error of 1 W, (W²/kg)².
    lasting: f64,
}

/// The constant error of the power in W that explains how mass estimates over 25 s stray on windows
/// left out of the fit, beside `noise`; 0 where noise alone explains it or windows are too few.
/// Wider than the estimate itself by as much as Student's t is wider than the normal distribution:
/// so few windows know a scatter only so well.
///
/// `gradient` gives ∂P/∂θ of a row, 0 for parameters that are held; `weights` what each row of the
/// store counted for.
pub(super) fn lasting_error<const N: usize>(
    dataset: &Dataset<N>,
    model: &Model<f64>,
    weights: &[f64],
    gradient: impl Fn(&Row<N>) -> DVector<f64>,
    noise: &Noise<f64>,
) -> f64 {
    let halves = halves(dataset, model, weights, gradient, noise);
    let Some((_, first)) = halves.first() else { return 0.0 };
    let mut whole = DMatrix::zeros(first.normal.nrows(), first.normal.ncols());
    for (_, half) in &halves {
        whole += &half.normal;
    }
    let density = noise.density / dataset.store_period_s();
    let strays = halves.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| {
        let window = pair[0].1.clone().merged(&pair[1].1);
        Stray {
            square: window.unseen_score(&whole).powi(2),
            expected: density * window.information,
            lasting: window.slope * window.slope,
        }
    });
    let strays: Vec<Stray> = strays.filter(|stray| stray.expected > 0.0 && stray.lasting > 0.0).collect();
    // Each half is in two windows.
    let count = 0.5 * strays.len() as f64;
    if count < LEAST_WINDOWS {
        return 0.0;
    }
    student_95(count).map_or(0.0, |student| between(&strays).sqrt() * student / NORMAL_95)
}

/// The sums of each half window, with its run.
fn halves<const N: usize>(
    dataset: &Dataset<N>,
    model: &Model<f64>,
    weights: &[f64],
    gradient: impl Fn(&Row<N>) -> DVector<f64>,
    noise: &Noise<f64>,
) -> Vec<(u32, Sums)> {
    let range = &dataset.robot.range;
    let linear_beyond = noise.linear_beyond(dataset.robot.cutoff_hz);
    let mut halves: Vec<(u32, Sums)> = Vec::new();
    let mut current: Option<(u32, i64)> = None;
    for (row, &weight) in dataset.store.iter().zip(weights) {
        let Some(predicted) = model.power(&row.motion, row.mass) else { continue };
        let along = gradient(row);
        let key = (row.run, (row.time / HALF_S).floor() as i64);
        if current != Some(key) {
            halves.push((row.run, Sums::new(along.len())));
            current = Some(key);
        }
        let Some((_, half)) = halves.last_mut() else { continue };
        let error = row.power - predicted;
        if weight > 0.0 {
            half.normal.ger(weight, &along, &along, 1.0);
            half.pull.axpy(weight * error, &along, 1.0);
        }
        let response = model.response(&row.motion, range);
        if !response.may_clamp {
            let slope = response.polynomial.slope(row.mass - range.middle());
            let weighted = huber(error, linear_beyond) * slope;
            half.score += weighted * error;
            half.leverage.axpy(weighted, &along, 1.0);
            half.information += weighted * slope;
            half.slope += weighted;
        }
    }
    halves
}

/// The variance between windows by Paule and Mandel (1982), W²: that at which Σ s² / (expected + σ²
/// lasting) is the number of windows.
fn between(strays: &[Stray]) -> f64 {
    let excess = |variance: f64| {
        let ratio = |stray: &Stray| stray.square / (stray.expected + variance * stray.lasting);
        strays.iter().map(ratio).sum::<f64>() - strays.len() as f64
    };
    if strays.is_empty() || excess(0.0) <= 0.0 {
        return 0.0;
    }
    // There no window strays by more than its share.
    let most = strays.iter().map(|stray| stray.square / stray.lasting).sum::<f64>();
    bisect(0.0, most, excess)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Left out of least squares, a window's score is the one by the coefficients that the other
    /// windows alone give.
    #[test]
    fn a_window_left_out_is_judged_by_a_fit_of_the_others() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        let windows: Vec<Vec<(DVector<f64>, f64)>> = (0..5)
            .map(|_| (0..20).map(|_| (DVector::from_fn(3, |_, _| normal()), normal())).collect())
            .collect();
        let fitted = |left_out: Option<usize>| {
            let (mut matrix, mut right) = (DMatrix::zeros(3, 3), DVector::zeros(3));
            for (number, rows) in windows.iter().enumerate() {
                for (x, y) in rows.iter().filter(|_| left_out != Some(number)) {
                    matrix.ger(1.0, x, x, 1.0);
                    right.axpy(*y, x, 1.0);
                }
            }
            let solution = matrix.clone().cholesky().unwrap().solve(&right);
            (matrix, solution)
        };
        let (whole, all) = fitted(None);
        for (number, rows) in windows.iter().enumerate() {
            let others = fitted(Some(number)).1;
            let mut sums = Sums::new(3);
            let mut expected = 0.0;
            for (x, y) in rows {
                let slope = x[0] - 0.5 * x[2];
                sums.normal.ger(1.0, x, x, 1.0);
                sums.pull.axpy(y - x.dot(&all), x, 1.0);
                sums.score += slope * (y - x.dot(&all));
                sums.leverage.axpy(slope, x, 1.0);
                expected += slope * (y - x.dot(&others));
            }
            let found = sums.unseen_score(&whole);
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found} {expected}");
        }
    }

    /// Scores by noise and by an error of their own in each window: its variance is found, and none
    /// where there is none.
    #[test]
    fn the_variance_between_windows_is_that_of_the_errors_that_last() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut mean_of = |lasting_std: f64| {
            let one = |random: &mut ChaCha8Rng| {
                let strays: Vec<Stray> = (0..40)
                    .map(|window| {
                        let (expected, slope) = (f64::from(1 + window % 3), f64::from(1 + window % 4));
                        let noise: f64 = random.sample(StandardNormal);
                        let lasting: f64 = random.sample(StandardNormal);
                        let score = expected.sqrt() * noise + slope * lasting_std * lasting;
                        Stray { square: score * score, expected, lasting: slope * slope }
                    })
                    .collect();
                between(&strays)
            };
            (0..100).map(|_| one(&mut random)).sum::<f64>() / 100.0
        };
        let (none, two) = (mean_of(0.0), mean_of(2.0));
        // An estimate that cannot be below 0 is a little above it on average.
        assert!(none < 0.1, "{none}");
        assert!((two / 4.0 - 1.0).abs() < 0.1, "{two}");
    }
}
