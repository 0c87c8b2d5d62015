//! The noise of the power, told of clean runs: an autoregression whose scale follows the power,
//! spikes where the power changes fast, and Student's t.
//!
//! No model of filtered signals is right where a wheel starts or stops: nine tenths of what it gets
//! wrong is in a tenth of the rows. These have a further error, a spike, and tell nothing of the
//! memory of the others.

use nalgebra::{DMatrix, DVector};
use numerics::robust::{quantile, scale};
use statrs::function::gamma::ln_gamma;

use super::precision::Precision;
use super::priors::{
    FREEDOMS, JERK_LEVELS, LEAST_SPIKE, LEVEL_ROWS, MOST_SIGMAS, NORMAL, ORDER, POWER_LEVELS, WHITE_FLOOR,
};
use super::rows::Kept;

/// Rounds of memory, scale and spikes: each is told given the others.
const ROUNDS: usize = 3;

/// One run of those that tell: kept values.
#[derive(Debug, Clone, Copy)]
pub struct Told<'a> {
    /// Which rows.
    pub kept: &'a Kept,
    /// Predicted power, W.
    pub power: &'a [f64],
    /// What is left of the measured one, W.
    pub residual: &'a [f64],
}

/// What the rows of a run scatter.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// x_t − Σ a_k x_{t−k} is without memory.
    pub memory: Vec<f64>,
    /// Standard deviation of that, where the scale is 1, W.
    pub innovation: f64,
    /// The same of the autoregression as a model: with the white noise that keeps it apart from
    /// what a filter leaves empty. Without it all that the filter passes would look a third
    /// smaller.
    pub modelled: f64,
    /// Power, and the scale of the noise there.
    scales: Vec<(f64, f64)>,
    /// Where levels of jerk end, and the variance of the spikes of each.
    edges: Vec<f64>,
    spikes: Vec<f64>,
    /// Of Student's t.
    pub freedom: f64,
    /// Standard deviation of a steady row, W.
    pub std_w: f64,
}

impl Noise {
    /// Of some runs; `None` where they have no steady rows.
    pub fn told(runs: &[Told<'_>]) -> Option<Self> {
        let jerks: Vec<Vec<f64>> = runs.iter().map(|run| jerk(run.power)).collect();
        let mut all: Vec<f64> = jerks.iter().flatten().copied().collect();
        let edges: Vec<f64> =
            JERK_LEVELS.iter().map(|share| quantile(&mut all, *share)).collect::<Option<_>>()?;
        let mut powers: Vec<f64> = runs.iter().flat_map(|run| run.power).copied().collect();
        let mut knots: Vec<f64> = (0..POWER_LEVELS)
            .map(|k| quantile(&mut powers, (k as f64 + 0.5) / POWER_LEVELS as f64))
            .collect::<Option<_>>()?;
        knots.dedup_by(|a, b| *a - *b < 1e-9);
        let mut noise = Self {
            memory: vec![0.0; ORDER],
            innovation: 1.0,
            modelled: 1.0,
            scales: knots.into_iter().map(|power| (power, 1.0)).collect(),
            spikes: vec![0.0; edges.len() + 1],
            edges,
            freedom: NORMAL,
            std_w: 0.0,
        };
        for round in 0..ROUNDS {
            noise.round(runs, &jerks, round + 1 == ROUNDS)?;
        }
        Some(noise)
    }

    fn round(&mut self, runs: &[Told<'_>], jerks: &[Vec<f64>], last: bool) -> Option<()> {
        let scaled: Vec<Vec<f64>> = runs
            .iter()
            .map(|run| run.residual.iter().zip(run.power).map(|(x, p)| x / self.scale(*p)).collect())
            .collect();
        let quiet: Vec<Vec<bool>> =
            jerks.iter().map(|jerk| jerk.iter().map(|j| *j < self.edges[0]).collect()).collect();
        let steady: Vec<f64> = scaled
            .iter()
            .zip(&quiet)
            .flat_map(|(x, quiet)| x.iter().zip(quiet).filter(|(_, quiet)| **quiet).map(|(x, _)| *x))
            .collect();
        let limit = MOST_SIGMAS * scale(&steady)?.max(1e-12);
        let lags = self.autocovariance(runs, &scaled, &quiet, limit)?;
        self.memory = yule_walker(&lags)?;
        let mut innovations: Vec<(f64, f64)> = Vec::new();
        for ((run, x), quiet) in runs.iter().zip(&scaled).zip(&quiet) {
            for t in (0..x.len()).filter(|&t| run.kept.known[t]) {
                if quiet[t - ORDER..=t].iter().all(|quiet| *quiet) {
                    innovations.push((run.power[t], innovation(&self.memory, x, t)));
                }
            }
        }
        let values: Vec<f64> = innovations.iter().map(|(_, z)| *z).collect();
        if values.len() < 2 * ORDER {
            return None;
        }
        let bound = MOST_SIGMAS * scale(&values)?.max(1e-12);
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0.0), |(s, n), z| (s + z.abs().min(bound).powi(2), n + 1.0));
            (sum, count)
        };
        let (sum, count) = mean(&mut values.iter().copied());
        self.innovation = (sum / count).sqrt();
        if last {
            self.finish(runs, jerks, &scaled, &values, lags[0]);
            return Some(());
        }
        let usual = self.innovation.powi(2);
        let knots: Vec<f64> = self.scales.iter().map(|(power, _)| *power).collect();
        for (place, (_, scale)) in self.scales.iter_mut().enumerate() {
            let of_level = innovations.iter().filter(|(power, _)| nearest(&knots, *power) == place);
            let (sum, count) = mean(&mut of_level.map(|(_, z)| *z));
            *scale *= ((sum + LEVEL_ROWS * usual) / (count + LEVEL_ROWS) / usual).sqrt();
        }
        Some(())
    }

    /// Student's t, its scale, and the spikes.
    fn finish(
        &mut self,
        runs: &[Told<'_>],
        jerks: &[Vec<f64>],
        scaled: &[Vec<f64>],
        values: &[f64],
        variance: f64,
    ) {
        let best = FREEDOMS.iter().map(|freedom| student(values, *freedom));
        if let Some((_, freedom, scale)) = best.max_by(|a, b| a.0.total_cmp(&b.0)) {
            (self.freedom, self.innovation) = (freedom, scale);
        }
        let white = WHITE_FLOOR / (1.0 + WHITE_FLOOR) * variance;
        let through = 1.0 + self.memory.iter().map(|a| a * a).sum::<f64>();
        self.modelled = (self.innovation.powi(2) + white * through).sqrt();
        let rows = runs.iter().map(|run| run.power.len()).sum::<usize>().max(1) as f64;
        let usual = runs.iter().flat_map(|run| run.power).map(|p| self.scale(*p)).sum::<f64>() / rows;
        self.std_w = variance.sqrt() * usual;
        let mut sums = vec![(0.0, 0.0); self.spikes.len()];
        for (x, jerk) in scaled.iter().zip(jerks) {
            for (x, jerk) in x.iter().zip(jerk) {
                let level = &mut sums[self.level(*jerk)];
                *level = (level.0 + x * x, level.1 + 1.0);
            }
        }
        let means: Vec<f64> = sums.iter().map(|(sum, count): &(f64, f64)| sum / count.max(1.0)).collect();
        for (spike, mean) in self.spikes.iter_mut().zip(&means) {
            *spike = (mean - means[0]).max(LEAST_SPIKE * variance);
        }
    }

    fn autocovariance(
        &self,
        runs: &[Told<'_>],
        scaled: &[Vec<f64>],
        quiet: &[Vec<bool>],
        limit: f64,
    ) -> Option<Vec<f64>> {
        let mut sums = [(0.0, 0.0); ORDER + 1];
        for ((run, x), quiet) in runs.iter().zip(scaled).zip(quiet) {
            let mut first = 0;
            for t in 0..x.len() {
                let starts = t > 0 && run.kept.known[t - 1] && !run.kept.known[t];
                first = if starts { t } else { first };
                for (lag, sum) in sums.iter_mut().enumerate().take((t - first).min(ORDER) + 1) {
                    if quiet[t] && quiet[t - lag] {
                        let product = x[t].clamp(-limit, limit) * x[t - lag].clamp(-limit, limit);
                        *sum = (sum.0 + product, sum.1 + 1.0);
                    }
                }
            }
        }
        let mut lags: Vec<f64> = sums.iter().map(|(sum, count): &(f64, f64)| sum / count.max(1.0)).collect();
        lags[0] *= 1.0 + WHITE_FLOOR;
        (lags[0] > 0.0).then_some(lags)
    }

    /// Scale of the noise at a predicted power.
    fn scale(&self, power: f64) -> f64 {
        let after = self.scales.partition_point(|(knot, _)| *knot <= power);
        match (after.checked_sub(1).and_then(|k| self.scales.get(k)), self.scales.get(after)) {
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (power - a.0) / (b.0 - a.0),
            (Some(only), None) | (None, Some(only)) => only.1,
            (None, None) => 1.0,
        }
    }

    fn level(&self, jerk: f64) -> usize {
        self.edges.iter().filter(|edge| jerk >= **edge).count()
    }

    /// The inverse covariance of a run's kept rows.
    pub fn precision(&self, kept: &Kept, power: &[f64]) -> Precision {
        let scales = power.iter().map(|p| self.scale(*p)).collect();
        let spikes = jerk(power).into_iter().map(|jerk| self.spikes[self.level(jerk)]).collect();
        let known = kept.known.iter().map(|known| f64::from(u8::from(*known))).collect();
        Precision::new(self, scales, spikes, known)
    }

    /// Weight of an innovation, in standard deviations: of Student's t with what it knows less than
    /// its weights say, (ν + 1)/(ν + 3).
    pub fn weight(&self, z: f64) -> f64 {
        if self.freedom >= NORMAL {
            return 1.0;
        }
        (self.freedom + 1.0) / (self.freedom + z * z) * self.information()
    }

    /// What a row of Student's t knows of its place, per normal row of the same scale.
    pub fn information(&self) -> f64 {
        if self.freedom >= NORMAL { 1.0 } else { (self.freedom + 1.0) / (self.freedom + 3.0) }
    }
}

/// x_t − Σ a_k x_{t−k}.
pub fn innovation(memory: &[f64], x: &[f64], t: usize) -> f64 {
    memory.iter().enumerate().fold(x[t], |sum, (k, a)| sum - a * x[t - 1 - k])
}

/// How fast a power changes and bends near each row.
fn jerk(power: &[f64]) -> Vec<f64> {
    let at = |t: isize| power[t.clamp(0, power.len() as isize - 1) as usize];
    let changes: Vec<f64> = (0..power.len() as isize)
        .map(|t| {
            let (slope, bend) = (0.5 * (at(t + 1) - at(t - 1)), at(t + 1) - 2.0 * at(t) + at(t - 1));
            0.3 * slope.abs() + bend.abs()
        })
        .collect();
    let near = |t: usize| &changes[t.saturating_sub(1)..(t + 2).min(changes.len())];
    (0..changes.len()).map(|t| near(t).iter().copied().fold(0.0, f64::max)).collect()
}

fn nearest(knots: &[f64], value: f64) -> usize {
    let distance = |k: &usize| (knots[*k] - value).abs();
    (0..knots.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

/// The autoregression of an autocovariance whose lags were told of different rows: what is negative
/// of its spectrum is held at next to nothing.
fn yule_walker(lags: &[f64]) -> Option<Vec<f64>> {
    let order = lags.len() - 1;
    let eigen = DMatrix::from_fn(order, order, |i, j| lags[i.abs_diff(j)]).symmetric_eigen();
    let right = DVector::from_column_slice(&lags[1..]);
    let along = eigen.eigenvectors.tr_mul(&right);
    let least = 1e-3 * lags[0];
    let divided = DVector::from_fn(order, |i, _| along[i] / eigen.eigenvalues[i].max(least));
    let memory = eigen.eigenvectors * divided;
    memory.iter().all(|a| a.is_finite()).then(|| memory.as_slice().to_vec())
}

/// Log likelihood of values without memory by Student's t, its freedom and its best scale.
fn student(values: &[f64], freedom: f64) -> (f64, f64, f64) {
    let count = values.len() as f64;
    let mut scale = (values.iter().map(|z| z * z).sum::<f64>() / count).sqrt().max(1e-12);
    for _ in 0..30 {
        let weighted = |z: &f64| (freedom + 1.0) / (freedom + (z / scale).powi(2)) * z * z;
        scale = (values.iter().map(weighted).sum::<f64>() / count).sqrt().max(1e-12);
    }
    let constant = ln_gamma(0.5 * (freedom + 1.0))
        - ln_gamma(0.5 * freedom)
        - 0.5 * (freedom * std::f64::consts::PI).ln()
        - scale.ln();
    let tails: f64 = values.iter().map(|z| ((z / scale).powi(2) / freedom).ln_1p()).sum();
    (count * constant - 0.5 * (freedom + 1.0) * tails, freedom, scale)
}
