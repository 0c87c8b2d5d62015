//! Marginal likelihoods of Gaussian hypotheses, by sums of products.
//!
//! Whitened rows of run r: y = J δ + Φ (g + u_r + d in the field) + X c in the field + ε. What
//! differs from run to run is integrated out of each run's products, the rest out of their sums:
//! −2 ln p(y) = y'V⁻¹y + ln|V|, up to what all hypotheses share.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::normal::log_within;

/// Columns of a run's products: what was measured, base, functions, then effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Parameters of the base.
    pub base: usize,
    /// Functions of which the form may get something wrong.
    pub functions: usize,
}

impl Shape {
    /// The first function.
    pub fn first(self) -> usize {
        1 + self.base
    }

    /// The first effect.
    pub fn further(self) -> usize {
        1 + self.base + self.functions
    }
}

/// Variances of what is integrated out, in variances of the noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Variances {
    /// Precision of the base's parameters.
    pub base: DMatrix<f64>,
    /// Of each function in all runs alike.
    pub shared: Vec<f64>,
    /// Of each function from run to run.
    pub runs: Vec<f64>,
}

/// Products of one run, what is of this run alone integrated out.
#[derive(Debug, Clone, PartialEq)]
pub struct Marginal {
    /// The products.
    pub products: DMatrix<f64>,
    /// ln |I + Λ Φ'Φ|.
    pub log_det: f64,
}

impl Marginal {
    /// With the first columns alone.
    pub fn cut(&self, size: usize) -> Self {
        Self { products: self.products.view((0, 0), (size, size)).into_owned(), log_det: self.log_det }
    }

    /// Coefficients of the functions, of this run alone and with these variances, integrated out;
    /// `None` where the variances are no numbers.
    pub fn of(products: &DMatrix<f64>, shape: Shape, variances: &[f64]) -> Option<Self> {
        let roots: Vec<f64> = variances.iter().map(|variance| variance.sqrt()).collect();
        let mut along = products.rows(shape.first(), shape.functions).into_owned();
        for (mut row, root) in along.row_iter_mut().zip(&roots) {
            row *= *root;
        }
        let mut inner = along.columns(shape.first(), shape.functions).into_owned();
        for (mut column, root) in inner.column_iter_mut().zip(&roots) {
            column *= *root;
        }
        inner += DMatrix::identity(shape.functions, shape.functions);
        let factor = Cholesky::new(inner)?;
        let solved = factor.l_dirty().solve_lower_triangular_mut(&mut along);
        let products = products - along.transpose() * &along;
        solved.then(|| Self { products, log_det: log_det(&factor) })
    }
}

/// ln of the determinant.
fn log_det(factor: &Cholesky<f64, Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>()
}

/// Sums over runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Totals {
    /// Of all runs: no effects.
    pub all: DMatrix<f64>,
    /// Of those in question.
    pub field: DMatrix<f64>,
    /// Of the determinants.
    pub log_det: f64,
}

impl Totals {
    /// Of runs, each with whether it is in question.
    pub fn of<'a>(shape: Shape, runs: impl Iterator<Item = (bool, &'a Marginal)>) -> Self {
        let size = shape.further();
        let mut totals = Self { all: DMatrix::zeros(size, size), field: DMatrix::zeros(0, 0), log_det: 0.0 };
        for (field, run) in runs {
            totals.all += run.products.view((0, 0), (size, size));
            totals.log_det += run.log_det;
            if field && totals.field.is_empty() {
                totals.field = run.products.clone();
            } else if field {
                totals.field += &run.products;
            }
        }
        if totals.field.is_empty() {
            totals.field = DMatrix::zeros(size, size);
        }
        totals
    }
}

/// What is left to effects when all else is integrated out.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Products in V⁻¹ of what was measured, then effects.
    pub products: DMatrix<f64>,
    /// −2 ln p(y) without effects.
    pub minus_two_log: f64,
    /// What was integrated out: its factor, the scales of its columns, and its products with the
    /// first column, solved.
    pub(super) nuisance: Nuisance,
}

/// The equations of what was integrated out.
#[derive(Debug, Clone)]
pub(super) struct Nuisance {
    factor: Cholesky<f64, Dyn>,
    scales: DVector<f64>,
    /// L⁻¹ of its products with what was measured.
    pub(super) measured: DVector<f64>,
}

impl Nuisance {
    /// How many coefficients were integrated out.
    pub(super) fn count(&self) -> usize {
        self.scales.len()
    }

    /// L⁻¹ of products of base and functions (rows) with columns.
    pub(super) fn solved(&self, mut products: DMatrix<f64>) -> DMatrix<f64> {
        for (mut row, scale) in products.row_iter_mut().zip(self.scales.iter()) {
            row /= *scale;
        }
        self.factor.l_dirty().solve_lower_triangular_mut(&mut products);
        products
    }
}

/// Integrates base and discrepancy out of sums; with `other` what a form gets wrong as well, of that
/// variance a function, in the field.
pub fn reduce(totals: &Totals, shape: Shape, variances: &Variances, other: f64) -> Option<Reduced> {
    let (base, count, further) = (shape.base, shape.functions, shape.further());
    let (all, field) = (&totals.all, &totals.field);
    let effects = field.ncols().checked_sub(further)?;
    let nuisances = base + count;
    let size = nuisances + if other > 0.0 { count } else { 0 };
    let mut matrix = DMatrix::zeros(size, size);
    matrix.view_mut((0, 0), (nuisances, nuisances)).copy_from(&all.view((1, 1), (nuisances, nuisances)));
    let mut inner = matrix.view_mut((0, 0), (base, base));
    inner += &variances.base;
    let mut log_prior = 0.0;
    for (k, variance) in variances.shared.iter().enumerate() {
        matrix[(base + k, base + k)] += 1.0 / variance;
        log_prior -= variance.ln();
    }
    let mut right = DMatrix::zeros(size, 1 + effects);
    right.view_mut((0, 0), (nuisances, 1)).copy_from(&all.view((1, 0), (nuisances, 1)));
    right.view_mut((0, 1), (nuisances, effects)).copy_from(&field.view((1, further), (nuisances, effects)));
    if other > 0.0 {
        let first = shape.first();
        let cross = field.view((1, first), (nuisances, count));
        matrix.view_mut((0, nuisances), (nuisances, count)).copy_from(&cross);
        matrix.view_mut((nuisances, 0), (count, nuisances)).copy_from(&cross.transpose());
        matrix
            .view_mut((nuisances, nuisances), (count, count))
            .copy_from(&field.view((first, first), (count, count)));
        for k in nuisances..size {
            matrix[(k, k)] += 1.0 / other;
        }
        log_prior -= count as f64 * other.ln();
        right.view_mut((nuisances, 0), (count, 1)).copy_from(&field.view((first, 0), (count, 1)));
        right
            .view_mut((nuisances, 1), (count, effects))
            .copy_from(&field.view((first, further), (count, effects)));
    }
    let scales = matrix.diagonal().map(f64::sqrt);
    for i in 0..size {
        for j in 0..size {
            matrix[(i, j)] /= scales[i] * scales[j];
        }
        matrix[(i, i)] += 1e-12;
    }
    let log_scales = 2.0 * scales.iter().map(|x| x.ln()).sum::<f64>();
    let factor = Cholesky::new(matrix)?;
    let log_det = log_det(&factor) + log_scales;
    let mut nuisance = Nuisance { factor, scales, measured: DVector::zeros(0) };
    let solved = nuisance.solved(right);
    nuisance.measured = solved.column(0).into_owned();
    let mut products = DMatrix::zeros(1 + effects, 1 + effects);
    products[(0, 0)] = all[(0, 0)];
    products.view_mut((0, 1), (1, effects)).copy_from(&field.view((0, further), (1, effects)));
    products.view_mut((1, 0), (effects, 1)).copy_from(&field.view((further, 0), (effects, 1)));
    products
        .view_mut((1, 1), (effects, effects))
        .copy_from(&field.view((further, further), (effects, effects)));
    products -= solved.transpose() * &solved;
    let minus_two_log = products[(0, 0)] + totals.log_det + log_det - log_prior;
    Some(Reduced { products, minus_two_log, nuisance })
}

/// ln of how much likelier data are with a coefficient that is normal about zero with a standard
/// deviation, and in its range, than without it. `along` is X'V⁻¹y, `gram` X'V⁻¹X.
pub fn gain(along: f64, gram: f64, std_dev: f64, range: (f64, f64)) -> f64 {
    // Where others explain a column to the last digit, rounding is left.
    let precision = gram.max(0.0) + std_dev.powi(-2);
    let mean = along / precision;
    let inside = log_within(range, mean, precision.powf(-0.5)) - log_within(range, 0.0, std_dev);
    0.5 * along * mean - 0.5 * (precision * std_dev * std_dev).ln() + inside
}

/// The same of several coefficients without bounds.
pub fn gain_of_several(along: &DVector<f64>, gram: &DMatrix<f64>, std_devs: &[f64]) -> f64 {
    let scale = DVector::from_column_slice(std_devs);
    let inner = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
        gram[(i, j)] * scale[i] * scale[j] + f64::from(u8::from(i == j))
    });
    let Some(factor) = Cholesky::new(inner) else { return f64::NEG_INFINITY };
    let right = along.component_mul(&scale);
    0.5 * right.dot(&factor.solve(&right)) - 0.5 * log_det(&factor)
}

/// Where several coefficients are likeliest.
pub fn likeliest(
    along: &DVector<f64>,
    gram: &DMatrix<f64>,
    std_devs: &[f64],
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let mut precision = gram.clone();
    for (k, std_dev) in std_devs.iter().enumerate() {
        precision[(k, k)] += std_dev.powi(-2);
    }
    let factor = Cholesky::new(precision)?;
    Some((factor.solve(along), factor.inverse()))
}
