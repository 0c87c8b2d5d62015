//! The noise of the power: its autoregression, its variance, and the weight of each row.

mod regression;
pub mod spread;
pub mod whiten;

use logs::runs::Runs;
use numerics::robust::scale_of_sizes;

use self::regression::{Columns, Regression};
use self::spread::Spread;
use self::whiten::{Signal, Whitener};
use super::thresholds::detect::NO_DIFFERENCE;
use super::thresholds::noise::{BLOCKS_S, LEAST_QUIET, PASSES, QUIETER, WHITE_FLOOR};

/// Which runs the autoregression of the noise is estimated from.
#[derive(Debug, Clone, Copy)]
pub enum Memory<'a> {
    /// None: it is known.
    Known(&'a Whitener),
    /// Clean runs, where there are any: in the field a step would look like a long memory, and be
    /// whitened away.
    OfClean,
    /// All runs: those of a simulator have no noise.
    OfAll,
}

/// The noise of the residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Its autoregression.
    pub whitener: Whitener,
    /// Standard deviation of the whitened noise, W.
    pub std_w: f64,
    /// Root of each row's weight; 0 where the past is not known.
    pub weights: Signal,
    /// Residual without its smooth content: whitened, weighted, per standard deviation.
    pub residual: Signal,
    /// The same before whitening, W.
    pub residual_w: Signal,
    /// Mean square of `residual_w` with the noise that the fit absorbed, W².
    pub floor_w2: f64,
}

impl Noise {
    /// From the columns of each run, the residual last: its regression on the others leaves the
    /// noise, before and after whitening.
    pub fn estimate(runs: &Runs, columns: &[Vec<Vec<f64>>], memory: Memory<'_>) -> Self {
        let has_clean = runs.runs.iter().any(|run| run.clean);
        let raw: Vec<Columns> = columns.iter().map(|columns| Columns::new(columns)).collect();
        let mut residual_w = Regression::of(&raw).left;
        let everything: Signal = runs.runs.iter().map(|run| vec![1.0; run.rows.len()]).collect();
        let mut noise = Self {
            whitener: Whitener { coefficients: Vec::new() },
            std_w: 1.0,
            weights: everything,
            residual: Signal::new(),
            residual_w: Signal::new(),
            floor_w2: 0.0,
        };
        let mut last = None;
        // The whitener of the first residual shows a better one.
        let passes = if matches!(memory, Memory::Known(_)) { 1 } else { PASSES };
        for _ in 0..passes {
            noise.whitener = match memory {
                Memory::Known(whitener) => whitener.clone(),
                Memory::OfClean if has_clean => {
                    Whitener::estimate(runs, &residual_w, |place| runs.runs[place].clean)
                }
                Memory::OfClean | Memory::OfAll => Whitener::estimate(runs, &residual_w, |_| true),
            };
            let known = noise.whitener.known(runs);
            noise.weights = known
                .iter()
                .map(|run| run.iter().map(|known| f64::from(u8::from(*known))).collect())
                .collect();
            noise.std_w = 1.0;
            let white: Vec<Columns> = raw
                .iter()
                .enumerate()
                .map(|(place, columns)| columns.map(|values| noise.whitener.apply_run(runs, place, values)))
                .collect();
            for _ in 0..PASSES {
                let weighted: Vec<Columns> = white
                    .iter()
                    .zip(&noise.weights)
                    .map(|(columns, weights)| {
                        let weigh = |(x, weight): (&f64, &f64)| x * weight / noise.std_w;
                        columns.map(|values| values.iter().zip(weights).map(weigh).collect())
                    })
                    .collect();
                let regression = Regression::of(&weighted);
                residual_w = raw.iter().map(|columns| columns.left_by(&regression.values)).collect();
                noise.residual = regression.left.clone();
                noise.weigh(runs);
                last = Some(regression);
            }
        }
        // Only rows that took part count: the past of the others is not known.
        let takes_part = |(x, weight): (&f64, &f64)| if *weight > 0.0 { *x } else { 0.0 };
        let raw: Vec<Columns> = raw
            .iter()
            .zip(&noise.weights)
            .map(|(columns, weights)| columns.map(|x| x.iter().zip(weights).map(takes_part).collect()))
            .collect();
        let left = residual_w.iter().zip(&noise.weights).flat_map(|(x, weights)| x.iter().zip(weights));
        let left: f64 = left.map(takes_part).map(|x| x * x).sum();
        let rows = noise.weights.iter().flatten().filter(|weight| **weight > 0.0).count();
        let absorbed = last.map_or(0.0, |last| last.absorbed(&raw));
        noise.floor_w2 = (left + absorbed) / rows.max(1) as f64;
        noise.residual_w = residual_w;
        noise
    }

    /// Standard deviation of the whitened noise of the rows that count, W: as if all scattered
    /// alike.
    pub fn usual_w(&self) -> f64 {
        let known = || self.weights.iter().flatten().filter(|weight| **weight > 0.0);
        let square: f64 = known().map(|weight| weight * weight).sum();
        self.std_w / (square / known().count().max(1) as f64).sqrt().max(1e-300)
    }

    /// Variance of the autoregression as a model, in that of what it leaves. It has the white noise
    /// that keeps it apart from what a filter leaves empty; without that all that the filter passes
    /// would look a third smaller.
    pub fn modelled(&self) -> f64 {
        let white = WHITE_FLOOR / (1.0 + WHITE_FLOOR) * self.floor_w2;
        let through = 1.0 + self.whitener.coefficients.iter().map(|a| a * a).sum::<f64>();
        1.0 + white * through / self.usual_w().powi(2)
    }

    /// Whitened, weighted, per standard deviation.
    pub fn whiten(&self, runs: &Runs, place: usize, values: &[f64]) -> Vec<f64> {
        let mut white = self.whitener.apply_run(runs, place, values);
        for (x, weight) in white.iter_mut().zip(&self.weights[place]) {
            *x *= weight / self.std_w;
        }
        white
    }

    /// Weighted values of each run without their weights.
    pub fn unweighted<'a>(&self, runs: impl Iterator<Item = &'a [f64]>) -> Signal {
        let plain = |(x, w): (&f64, &f64)| if *w > 0.0 { x / w } else { 0.0 };
        runs.zip(&self.weights).map(|(run, w)| run.iter().zip(w).map(plain).collect()).collect()
    }

    /// Weights and standard deviation from the residual.
    fn weigh(&mut self, runs: &Runs) {
        let plain = self.unweighted(self.residual.iter().map(Vec::as_slice));
        let mut spread = Spread::fit(runs, &plain, &self.weights, |_| true).of(runs);
        quieten_clean(runs, &plain, &self.weights, &mut spread);
        let mut sizes: Vec<f64> = Vec::new();
        for ((plain, spread), weights) in plain.iter().zip(&spread).zip(&self.weights) {
            let known = plain.iter().zip(spread).zip(weights).filter(|(_, w)| **w > 0.0);
            sizes.extend(known.map(|((x, spread), _)| (x / spread).abs()));
        }
        let Some(usual) = scale_of_sizes(&mut sizes) else { return };
        let (mut sum, mut count) = (0.0, 0.0);
        for ((plain, spread), weights) in plain.iter().zip(&spread).zip(&mut self.weights) {
            let rows = plain.iter().zip(spread).zip(weights.iter_mut());
            for ((x, spread), weight) in rows.filter(|(_, weight)| **weight > 0.0) {
                *weight = (NO_DIFFERENCE * usual * spread / x.abs().max(1e-300)).min(1.0).sqrt() / spread;
                sum += (*weight * x).powi(2);
                count += 1.0;
            }
        }
        if sum > 0.0 {
            let factor = (sum / count).sqrt();
            self.std_w *= factor;
            for ((residual, plain), weights) in self.residual.iter_mut().zip(&plain).zip(&self.weights) {
                for ((residual, x), weight) in residual.iter_mut().zip(plain).zip(weights) {
                    *residual = x * weight / factor;
                }
            }
        }
    }

    /// Variance of Σ x e, where e is the residual: from the scatter of blocks of some seconds, or
    /// of whole runs, whichever is greater. For white normal noise it is Σ x².
    pub fn score_variance(&self, period_s: f64, column: &Signal) -> f64 {
        let along = along(column.iter().flatten(), self.residual.iter().flatten());
        let (mut blocks, mut runs) = ([0.0; BLOCKS_S.len()], 0.0);
        for (x, e) in column.iter().zip(&self.residual) {
            let (square, sum) = block_scores(period_s, x, e, along);
            for (blocks, square) in blocks.iter_mut().zip(square) {
                *blocks += square;
            }
            runs += sum * sum;
        }
        blocks.into_iter().fold(runs, f64::max)
    }

    /// As [`score_variance`](Self::score_variance) for a column that lives in one run.
    pub fn run_score_variance(&self, period_s: f64, run: usize, column: &[f64]) -> f64 {
        let residual = &self.residual[run];
        let along = along(column.iter(), residual.iter());
        let variance = column.iter().zip(residual).map(|(x, e)| (e - along * x).powi(2)).sum::<f64>()
            / residual.len().max(1) as f64;
        let square = column.iter().map(|x| x * x).sum::<f64>();
        block_scores(period_s, column, residual, along).0.into_iter().fold(variance * square, f64::max)
    }
}

/// Clean runs much quieter than the field come from a simulator. Their spread is reduced, but not
/// so far that they outweigh everything.
fn quieten_clean(runs: &Runs, plain: &Signal, weights: &Signal, spread: &mut Signal) {
    let usual = |clean: bool| {
        let of = runs.runs.iter().zip(plain).zip(spread.iter().zip(weights));
        let sizes =
            of.filter(|((run, _), _)| run.clean == clean).flat_map(|((_, plain), (spread, weights))| {
                let known = plain.iter().zip(spread).zip(weights).filter(|(_, weight)| **weight > 0.0);
                known.map(|((x, spread), _)| (x / spread).abs())
            });
        scale_of_sizes(&mut sizes.collect::<Vec<f64>>())
    };
    let (Some(field), Some(clean)) = (usual(false), usual(true)) else { return };
    if QUIETER * clean >= field {
        return;
    }
    let share = (clean / field).max(LEAST_QUIET);
    for (_, spread) in runs.runs.iter().zip(spread).filter(|(run, _)| run.clean) {
        spread.iter_mut().for_each(|spread| *spread *= share);
    }
}

/// Coefficient of a column in the residual: an effect of single runs, which no smooth function
/// takes out, is no noise.
fn along<'a>(column: impl Iterator<Item = &'a f64>, residual: impl Iterator<Item = &'a f64>) -> f64 {
    let (with, square) =
        column.zip(residual).fold((0.0, 0.0), |(with, square), (x, e)| (with + x * e, square + x * x));
    if square > 0.0 { with / square } else { 0.0 }
}

/// Σ (Σ x e)² over blocks of each length, and Σ x e, with e less `along` times x.
fn block_scores(period_s: f64, x: &[f64], e: &[f64], along: f64) -> ([f64; BLOCKS_S.len()], f64) {
    let score = |x: &[f64], e: &[f64]| x.iter().zip(e).map(|(x, e)| x * (e - along * x)).sum::<f64>();
    let squares = BLOCKS_S.map(|length| {
        let rows = (length / period_s).round().max(1.0) as usize;
        x.chunks(rows).zip(e.chunks(rows)).map(|(x, e)| score(x, e).powi(2)).sum()
    });
    (squares, score(x, e))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::problem::example;
    use crate::smooth;

    /// Noise of 0.07 W, alone or with a memory of one row: the floor is its mean square, though
    /// some forty functions absorbed up to an eighth of it.
    #[test]
    fn a_floor_is_the_mean_square_of_the_noise() {
        const SETS: u64 = 20;
        let runs = example::runs_of([0.4, 0.9], 3000);
        let functions = smooth::functions(&runs);
        for (memory, most_left) in [(0.0, 0.98), (0.6, 0.96), (0.9_f64, 0.9)] {
            let (mut floor, mut left) = (0.0, 0.0);
            for seed in 0..SETS {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let columns = runs.runs.iter().enumerate().map(|(place, run)| {
                    let mut last: f64 = StandardNormal.sample(&mut rng);
                    let noise = run.rows.iter().map(|_| {
                        let fresh: f64 = StandardNormal.sample(&mut rng);
                        last = memory * last + (1.0 - memory * memory).sqrt() * fresh;
                        example::STD_W * last
                    });
                    let noise = noise.collect();
                    functions.iter().map(|function| function[place].clone()).chain([noise]).collect()
                });
                let noise = Noise::estimate(&runs, &columns.collect::<Vec<_>>(), Memory::OfAll);
                let squares: Vec<f64> = noise.residual_w.iter().flatten().map(|x| x * x).collect();
                floor += noise.floor_w2 / SETS as f64;
                left += squares.iter().sum::<f64>() / (squares.len() as f64 * SETS as f64);
            }
            let [floor, left] = [floor, left].map(|square| square / example::STD_W.powi(2));
            assert!((floor - 1.0).abs() < 0.04 && left < most_left, "{memory}: {floor} {left}");
        }
    }
}
