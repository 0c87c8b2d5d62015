//! The score of pure noise is N(0, 1), whatever the noise: white; correlated, after an
//! autoregressive whitener estimated from what is left, as the gap workflow does; heteroscedastic,
//! weighed by the variance of each row.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use statrs::distribution::{ContinuousCDF, Normal};

use super::super::{FurtherColumn, NormalEquations};

const DRAWS: u64 = 1000;
const ROWS: usize = 400;

/// Greatest distance between the draws' distribution and N(0, 1) (Kolmogorov and Smirnov).
fn distance(mut draws: Vec<f64>) -> f64 {
    draws.sort_by(f64::total_cmp);
    let (normal, count) = (Normal::standard(), draws.len() as f64);
    let gaps = draws.iter().enumerate().map(|(index, z)| {
        let expected = normal.cdf(*z);
        (expected - index as f64 / count).max((index as f64 + 1.0) / count - expected)
    });
    gaps.fold(0.0, f64::max)
}

/// Of 1,000 draws of N(0, 1) one sample in a thousand deviates more: 1.949/√n (Smirnov's limit
/// law). A standard deviation off by 15 % moves the distribution by 0.036, 1.5 times less than
/// this; by 30 % by 0.07.
fn critical() -> f64 {
    1.949 / (DRAWS as f64).sqrt()
}

/// Slopes as a robot's: a level, a slow sway and a fast one, and the column in question, correlated
/// with the second.
fn columns(random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    let phase: f64 = random.random();
    let wave = |rate: f64, t: usize| (rate * t as f64 + 6.0 * phase).sin();
    let column = |of: &dyn Fn(usize) -> f64| (0..ROWS).map(of).collect::<Vec<f64>>();
    vec![
        column(&|_| 1.0),
        column(&|t| wave(0.02, t)),
        column(&|t| wave(0.3, t)),
        column(&|t| wave(0.021, t) + wave(0.11, t)),
    ]
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    random.sample(StandardNormal)
}

/// z of the last column, the others moving along.
fn score(columns: &[Vec<f64>], residual: &[f64]) -> f64 {
    let all: Vec<f64> = columns.iter().flatten().chain(residual).copied().collect();
    let panel = DMatrix::from_vec(residual.len(), columns.len() + 1, all);
    let products = panel.tr_mul(&panel);
    let places: Vec<usize> = (0..columns.len() - 1).collect();
    let factored = NormalEquations::from_products(&products, &places).factor(1e-10).unwrap();
    factored.score(&FurtherColumn::from_products(&products, &places, columns.len() - 1), 1e-3).unwrap().z()
}

/// The residual after a fit of all columns but the last.
fn residual_of(columns: &[Vec<f64>], residual: &[f64]) -> Vec<f64> {
    let mut problem = NormalEquations::zeros(columns.len() - 1);
    let row = |t: usize| columns[..columns.len() - 1].iter().map(|column| column[t]).collect::<Vec<f64>>();
    for (t, residual) in residual.iter().enumerate() {
        problem.add_row(&row(t), *residual, 1.0);
    }
    let by = problem.factor(1e-10).unwrap().solution();
    residual.iter().enumerate().map(|(t, r)| r - DVector::from_vec(row(t)).dot(&by)).collect()
}

#[test]
fn of_white_noise() {
    let draws = (0..DRAWS).map(|seed| {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let columns = columns(random);
        let residual: Vec<f64> = (0..ROWS).map(|_| normal(random)).collect();
        score(&columns, &residual)
    });
    let apart = distance(draws.collect());
    assert!(apart < critical(), "{apart}");
}

/// e_t = 0.9 e_{t−1} + n_t. The autoregression is estimated from what the other columns leave and
/// applied to columns and residual; its own scatter of what is left is the standard deviation.
/// Without the whitening the scores would scatter some 4 times as much.
#[test]
fn of_noise_with_a_memory_behind_the_whitener() {
    let draw = |seed: u64, whiten: bool| {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut columns = columns(random);
        let mut now = normal(random) / (1.0_f64 - 0.81).sqrt();
        let mut residual: Vec<f64> = (0..ROWS)
            .map(|_| {
                now = 0.9 * now + normal(random);
                now
            })
            .collect();
        if whiten {
            let a = autoregression(&residual_of(&columns, &residual));
            let whitened = |values: &[f64]| values.windows(2).map(|pair| pair[1] - a * pair[0]).collect();
            columns = columns.iter().map(|column| whitened(column)).collect();
            residual = whitened(&residual);
        }
        let rest = residual_of(&columns, &residual);
        let std = (rest.iter().map(|x| x * x).sum::<f64>() / (rest.len() - columns.len() + 1) as f64).sqrt();
        residual.iter_mut().for_each(|value| *value /= std);
        score(&columns, &residual)
    };
    let apart = distance((0..DRAWS).map(|seed| draw(seed, true)).collect());
    assert!(apart < critical(), "{apart}");
    let raw = distance((0..DRAWS).map(|seed| draw(seed, false)).collect());
    assert!(raw > 3.0 * critical(), "{raw}");
}

/// Lag one of the autocorrelation.
fn autoregression(values: &[f64]) -> f64 {
    let product: f64 = values.windows(2).map(|pair| pair[0] * pair[1]).sum();
    product / values.iter().map(|value| value * value).sum::<f64>()
}

/// Noise that grows with the fourth column: rows weigh by the inverse of their variance; if all
/// weighed alike, the scores would be too wide.
#[test]
fn of_heteroscedastic_noise() {
    let draw = |seed: u64, weigh: bool| {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let columns = columns(random);
        let std: Vec<f64> = columns[3].iter().map(|x| 0.2 + x * x).collect();
        let residual: Vec<f64> = std.iter().map(|std| std * normal(random)).collect();
        let mean = (std.iter().map(|std| std * std).sum::<f64>() / ROWS as f64).sqrt();
        let by = |values: &[f64]| {
            let each = values.iter().zip(&std).map(|(x, std)| x / if weigh { *std } else { mean });
            each.collect::<Vec<f64>>()
        };
        let whitened: Vec<Vec<f64>> =
            columns.iter().map(|column| if weigh { by(column) } else { column.clone() }).collect();
        score(&whitened, &by(&residual))
    };
    let apart = distance((0..DRAWS).map(|seed| draw(seed, true)).collect());
    assert!(apart < critical(), "{apart}");
    let equal = distance((0..DRAWS).map(|seed| draw(seed, false)).collect());
    assert!(equal > critical(), "{equal}");
}
