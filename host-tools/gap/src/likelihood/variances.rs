//! Variances of what the form gets wrong, in all runs alike and from run to run, and of the noise:
//! by the restricted likelihood of clean runs (REML).
//!
//! Each round of the minorise–maximise algorithm for variance components (Zhou and others 2019)
//! raises the likelihood: v² ← (û'û) / tr, with the half-Cauchy prior of each root in both.

use nalgebra::{Cholesky, DMatrix};

use super::evidence::{Marginal, Shape, Totals, Variances, own_part};
use super::priors::{DISCREPANCY, DISCREPANCY_RANGE};

/// What was found: the variances, and that of the noise as a multiple of what its own estimate
/// said.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// In variances of the noise.
    pub variances: Variances,
    /// Of the noise.
    pub noise: f64,
}

/// Of some runs' products. `groups` says which functions vary alike, `rows` how many rows speak
/// (those of Student's t for less than one).
pub fn told(
    products: &[&DMatrix<f64>],
    shape: Shape,
    groups: &[usize],
    base: &DMatrix<f64>,
    rows: f64,
    rounds: usize,
) -> Option<Found> {
    let count = groups.iter().copied().max().map_or(0, |most| most + 1);
    let size = shape.further();
    let clean: Vec<DMatrix<f64>> =
        products.iter().map(|own| own.view((0, 0), (size, size)).into_owned()).collect();
    let start = DISCREPANCY.powi(2);
    let (mut shared, mut runs, mut noise) = (vec![start; count], vec![start; count], 1.0);
    let spread = |groups: &[usize], values: &[f64]| groups.iter().map(|group| values[*group]).collect();
    for _ in 0..rounds {
        let own: Vec<f64> = spread(groups, &runs);
        let variances = Variances { base: base.clone(), shared: spread(groups, &shared), runs: own };
        let scaled: Vec<DMatrix<f64>> = clean.iter().map(|own| own / noise).collect();
        let parts: Option<Vec<_>> = scaled.iter().map(|own| own_part(own, shape, &variances.runs)).collect();
        let parts = parts?;
        let marginals: Vec<Marginal> = scaled
            .iter()
            .zip(&parts)
            .map(|(own, (part, _))| Marginal { products: own - part.tr_mul(part), log_det: 0.0 })
            .collect();
        let totals = Totals::of(shape, marginals.iter().map(|own| (false, own)));
        let solved = Solved::of(&totals, shape, &variances)?;
        let mut sums = vec![Sum::default(); count];
        for (k, group) in groups.iter().enumerate() {
            let place = shape.base + k;
            sums[*group].add(solved.values[place].powi(2), solved.covariance[(place, place)], shared[*group]);
        }
        let mut own_sums = vec![Sum::default(); count];
        for (part, factor) in &parts {
            // In units of each function's own deviation: v = B⁻¹ (Λ^½ Φ'y − Λ^½ Φ'N β).
            let mut back = part.columns(0, size).into_owned();
            factor.l_dirty().tr_solve_lower_triangular_mut(&mut back);
            let slopes = back.columns(1, size - 1);
            let values = back.column(0) - slopes * &solved.values;
            let inverse = factor.inverse();
            let through = slopes * &solved.covariance;
            for (k, group) in groups.iter().enumerate() {
                let variance = inverse[(k, k)] + through.row(k).dot(&slopes.row(k));
                own_sums[*group].add(values[k].powi(2) * runs[*group], variance * runs[*group], runs[*group]);
            }
        }
        shared = shared.iter().zip(&sums).map(|(now, sum)| sum.best(*now)).collect();
        runs = runs.iter().zip(&own_sums).map(|(now, sum)| sum.best(*now)).collect();
        let freedom = (rows - shape.base as f64).max(1.0);
        noise *= (solved.left / freedom).max(1e-12);
    }
    let variances =
        Variances { base: base.clone(), shared: spread(groups, &shared), runs: spread(groups, &runs) };
    Some(Found { variances, noise })
}

/// Base and functions as they are likeliest.
struct Solved {
    values: nalgebra::DVector<f64>,
    covariance: DMatrix<f64>,
    /// What is left, with what the priors take.
    left: f64,
}

impl Solved {
    fn of(totals: &Totals, shape: Shape, variances: &Variances) -> Option<Self> {
        let size = shape.base + shape.functions;
        let mut matrix = totals.all.view((1, 1), (size, size)).into_owned();
        let mut inner = matrix.view_mut((0, 0), (shape.base, shape.base));
        inner += &variances.base;
        for (k, variance) in variances.shared.iter().enumerate() {
            matrix[(shape.base + k, shape.base + k)] += 1.0 / variance;
        }
        let scales = matrix.diagonal().map(|x| x.sqrt().recip());
        let scaled = DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * scales[i] * scales[j]);
        let inverse = Cholesky::new(scaled)?.inverse();
        let covariance = DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] * scales[i] * scales[j]);
        let right = totals.all.view((1, 0), (size, 1)).column(0).into_owned();
        let values = &covariance * &right;
        let left = totals.all[(0, 0)] - right.dot(&values);
        Some(Self { values, covariance, left })
    }
}

/// What a group's coefficients say of their variance.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    /// Σ û².
    squares: f64,
    /// Σ (1 − var/v²)/v².
    trace: f64,
}

impl Sum {
    fn add(&mut self, square: f64, variance: f64, now: f64) {
        self.squares += square;
        self.trace += (1.0 - variance / now).max(0.0) / now;
    }

    /// The next variance: the least of a/v + b v − ln v, the last term and half of b's last one
    /// being the prior of the root's logarithm.
    fn best(self, now: f64) -> f64 {
        let slope = self.trace + 2.0 / (DISCREPANCY.powi(2) + now);
        let best = (1.0 + (1.0 + 4.0 * self.squares * slope).sqrt()) / (2.0 * slope);
        best.clamp(DISCREPANCY_RANGE.0.powi(2), DISCREPANCY_RANGE.1.powi(2))
    }
}
