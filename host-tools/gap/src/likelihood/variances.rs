//! Variances of what the form gets wrong, in all runs alike and from run to run: by the restricted
//! likelihood of clean runs (REML).
//!
//! Each step of the minorise–maximise algorithm for variance components (Zhou and others 2019)
//! raises the likelihood: v² ← (û'û) / tr, with the half-Cauchy prior of each root in both. Steps
//! are small where little is known, so two of them are extrapolated (Varadhan and Roland 2008).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::evidence::{Shape, Variances};
use super::priors::{DISCREPANCY, DISCREPANCY_RANGE, FARTHEST, SETTLED, VARIANCE_ROUNDS};

/// Of some runs' products. `groups` says which functions vary alike. `others` are runs that share
/// something of any size: they tell only what differs from run to run.
pub fn told(
    products: &[&DMatrix<f64>],
    others: &[&DMatrix<f64>],
    shape: Shape,
    groups: &[usize],
    base: &DMatrix<f64>,
    start: Option<&Variances>,
) -> Option<Variances> {
    let count = groups.iter().copied().max().map_or(0, |most| most + 1);
    let problem = Problem { products, others, shape, groups, count, base };
    let mut now = DVector::from_element(2 * count, 2.0 * DISCREPANCY.ln());
    if let Some(start) = start {
        for ((group, shared), runs) in groups.iter().zip(&start.shared).zip(&start.runs) {
            now[*group] = shared.ln();
            now[count + group] = runs.ln();
        }
    }
    for _ in 0..VARIANCE_ROUNDS {
        let once = problem.step(&now)?;
        let twice = problem.step(&once)?;
        let (first, bend) = (&once - &now, &twice - 2.0 * &once + &now);
        if first.amax() < SETTLED {
            now = twice;
            break;
        }
        let far = (first.norm() / bend.norm()).clamp(1.0, FARTHEST);
        now = problem.step(&problem.allowed(&now + 2.0 * far * first + far * far * bend))?;
    }
    Some(problem.variances(&now))
}

/// Variance of what the others share, in variances of the noise.
const ANY_SIZE: f64 = 1e2;

/// Added to a diagonal of ones, so that rounding takes none of it below nothing. Chosen: 1e-12 is
/// too little between two floors of a Husky.
const RIDGE: f64 = 1e-10;

/// What does not change from step to step. Unknowns are logarithms of the groups' variances: in all
/// runs alike, then from run to run.
struct Problem<'a> {
    products: &'a [&'a DMatrix<f64>],
    others: &'a [&'a DMatrix<f64>],
    shape: Shape,
    groups: &'a [usize],
    /// Groups.
    count: usize,
    base: &'a DMatrix<f64>,
}

impl Problem<'_> {
    fn variances(&self, now: &DVector<f64>) -> Variances {
        let of = |first: usize| self.groups.iter().map(|group| now[first + group].exp()).collect();
        Variances { base: self.base.clone(), shared: of(0), runs: of(self.count) }
    }

    fn allowed(&self, mut now: DVector<f64>) -> DVector<f64> {
        let (least, most) = DISCREPANCY_RANGE;
        now.apply(|x| *x = x.clamp(2.0 * least.ln(), 2.0 * most.ln()));
        now
    }

    fn step(&self, now: &DVector<f64>) -> Option<DVector<f64>> {
        let shape = self.shape;
        let variances = self.variances(now);
        let mut shared = vec![Sum::default(); self.count];
        let mut from_run_to_run = vec![Sum::default(); self.count];
        let any = Variances { shared: vec![ANY_SIZE; self.groups.len()], ..variances.clone() };
        for (products, variances) in [(self.products, &variances), (self.others, &any)] {
            if products.is_empty() {
                continue;
            }
            let runs: Option<Vec<Run>> =
                products.iter().map(|products| Run::of(products, shape, &variances.runs)).collect();
            let runs = runs?;
            let mut all = DMatrix::zeros(shape.further(), shape.further());
            for run in &runs {
                all += &run.products;
            }
            let solved = Solved::of(&all, shape, variances)?;
            if std::ptr::eq(products, self.products) {
                for (k, group) in self.groups.iter().enumerate() {
                    let place = shape.base + k;
                    let square = solved.values[place].powi(2);
                    shared[*group].add(square, solved.covariance[(place, place)], variances.shared[k]);
                }
            }
            for run in &runs {
                let values = &run.measured - &run.slopes * &solved.values;
                let through = &run.slopes * &solved.covariance;
                for (k, group) in self.groups.iter().enumerate() {
                    let variance = run.inverse[(k, k)] + through.row(k).dot(&run.slopes.row(k));
                    let between = variances.runs[k];
                    from_run_to_run[*group].add(values[k].powi(2) * between, variance * between, between);
                }
            }
        }
        let sums = shared.iter().chain(&from_run_to_run).zip(now.iter());
        let next = sums.map(|(sum, now)| sum.best(now.exp()).ln());
        Some(self.allowed(DVector::from_iterator(now.len(), next)))
    }
}

/// One run with what is of this run alone integrated out.
struct Run {
    /// Sums of products of what is left.
    products: DMatrix<f64>,
    /// B = (I + Λ^½ Φ'Φ Λ^½)⁻¹.
    inverse: DMatrix<f64>,
    /// B Λ^½ Φ'y.
    measured: DVector<f64>,
    /// B Λ^½ Φ' [J Φ]: by how much base and functions in all runs alike change that.
    slopes: DMatrix<f64>,
}

impl Run {
    /// Φ is among the columns itself, so that B alone has to be solved for.
    fn of(products: &DMatrix<f64>, shape: Shape, variances: &[f64]) -> Option<Self> {
        let (first, count, size) = (shape.first(), shape.functions, shape.further());
        let roots = DVector::from_iterator(count, variances.iter().map(|variance| variance.sqrt()));
        let inner = DMatrix::from_fn(count, count, |i, j| {
            roots[i] * roots[j] * products[(first + i, first + j)] + f64::from(u8::from(i == j))
        });
        let inverse = inverse(inner)?;
        let right = DMatrix::from_fn(count, first, |i, j| roots[i] * products[(first + i, j)]);
        let solved = &inverse * &right;
        let mut reduced = DMatrix::zeros(size, size);
        let block = products.view((0, 0), (first, first)) - right.transpose() * &solved;
        reduced.view_mut((0, 0), (first, first)).copy_from(&block);
        let mut slopes = DMatrix::zeros(count, size - 1);
        slopes.columns_mut(0, shape.base).copy_from(&solved.columns(1, shape.base));
        for i in 0..count {
            for j in 0..first {
                reduced[(first + i, j)] = solved[(i, j)] / roots[i];
                reduced[(j, first + i)] = reduced[(first + i, j)];
            }
            for j in 0..count {
                let of_one = f64::from(u8::from(i == j)) - inverse[(i, j)];
                slopes[(i, shape.base + j)] = of_one / roots[j];
                reduced[(first + i, first + j)] = of_one / roots[i] / roots[j];
            }
        }
        Some(Self { products: reduced, inverse, measured: solved.column(0).into_owned(), slopes })
    }
}

/// Base and functions as they are likeliest.
pub(super) struct Solved {
    pub(super) values: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Solved {
    pub(super) fn of(all: &DMatrix<f64>, shape: Shape, variances: &Variances) -> Option<Self> {
        let size = shape.base + shape.functions;
        let mut matrix = all.view((1, 1), (size, size)).into_owned();
        let mut inner = matrix.view_mut((0, 0), (shape.base, shape.base));
        inner += &variances.base;
        for (k, variance) in variances.shared.iter().enumerate() {
            matrix[(shape.base + k, shape.base + k)] += 1.0 / variance;
        }
        let scales = matrix.diagonal().map(|x| x.sqrt().recip());
        let ridge = |i, j| if i == j { RIDGE } else { 0.0 };
        let scaled =
            DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * scales[i] * scales[j] + ridge(i, j));
        let inverse = inverse(scaled)?;
        let covariance = DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] * scales[i] * scales[j]);
        let right = all.view((1, 0), (size, 1)).column(0).into_owned();
        let values = &covariance * &right;
        Some(Self { values, covariance })
    }
}

/// Of a symmetric matrix by halves: nearly all is then products of matrices, which are fast.
fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    const SMALL: usize = 16;
    let size = matrix.nrows();
    if size <= SMALL {
        return Some(Cholesky::new(matrix)?.inverse());
    }
    let (first, last) = (size / 2, size - size / 2);
    let upper = inverse(matrix.view((0, 0), (first, first)).into_owned())?;
    let beside = matrix.view((0, first), (first, last));
    let through = &upper * beside;
    let lower = inverse(matrix.view((first, first), (last, last)) - beside.transpose() * &through)?;
    let cross = &through * &lower;
    let mut all = DMatrix::zeros(size, size);
    all.view_mut((0, 0), (first, first)).copy_from(&(upper + &cross * through.transpose()));
    all.view_mut((0, first), (first, last)).copy_from(&-&cross);
    all.view_mut((first, 0), (last, first)).copy_from(&-cross.transpose());
    all.view_mut((first, first), (last, last)).copy_from(&lower);
    Some(all)
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
        (1.0 + (1.0 + 4.0 * self.squares * slope).sqrt()) / (2.0 * slope)
    }
}
