//! Effects about their own sizes, for any labels of the runs.
//!
//! An effect that bends has other slopes at its size than at none. Where it is linear there, it is
//! a column of what the linear model adds at none, with a coefficient of one, and its slopes. The
//! model's form may get these wrong in clean runs too, so they are functions besides.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::evidence::Shape;
use super::products::{Posed, RunProducts};
use super::relinearise;
use super::ways::Way;

/// Products with these columns.
pub struct Extended {
    /// With the functions that follow the others.
    pub shape: Shape,
    /// Groups of the functions: each new one may vary as much as what it is most like.
    pub groups: Vec<usize>,
    /// Of each run: measured, base, functions, effects as functions, ways, effects.
    pub products: Vec<DMatrix<f64>>,
    /// The effects, by their columns among those that may be in the field.
    pub effects: Vec<Way>,
}

impl Extended {
    /// By effects and the coefficients about which they are linear. `ways` is how many columns of
    /// the ways are kept.
    pub fn of(posed: &Posed<'_>, effects: &[(&Way, &[f64])], ways: usize) -> Self {
        let further = posed.shape.further();
        let cut = further + ways;
        let columns = about(posed, effects);
        let count = columns.first().map_or(0, DMatrix::ncols);
        let rows: f64 = columns.iter().map(|run| run.nrows() as f64).sum();
        let square = |k: usize| columns.iter().map(|run| run.column(k).norm_squared()).sum::<f64>();
        let units: Vec<f64> = (0..count)
            .map(|k| (square(k) / rows.max(1.0)).sqrt() / posed.noise.std_w)
            .map(|unit| if unit > 0.0 { unit } else { 1.0 })
            .collect();
        let place = |k: usize| match k {
            _ if k < further => (k, 1.0),
            _ if k < further + count => (cut + k - further, units[k - further].recip()),
            _ => (k - count, 1.0),
        };
        let of_run = |(run, columns): (&RunProducts, &DMatrix<f64>)| {
            let solved = run.precision.inverse_times(columns);
            let mut all = DMatrix::zeros(cut + count, cut + count);
            all.view_mut((0, 0), (cut, cut)).copy_from(&run.products.view((0, 0), (cut, cut)));
            let cross = run.columns.columns(0, cut).tr_mul(&solved);
            all.view_mut((0, cut), (cut, count)).copy_from(&cross);
            all.view_mut((cut, 0), (count, cut)).copy_from(&cross.transpose());
            all.view_mut((cut, cut), (count, count)).copy_from(&columns.tr_mul(&solved));
            DMatrix::from_fn(cut + 2 * count, cut + 2 * count, |i, j| {
                let ((i, a), (j, b)) = (place(i), place(j));
                all[(i, j)] * a * b
            })
        };
        let products: Vec<DMatrix<f64>> = posed.runs.par_iter().zip(&columns).map(of_run).collect();
        let shape = Shape { functions: posed.shape.functions + count, ..posed.shape };
        let sum = |i: usize, j: usize| products.iter().map(|run| run[(i, j)]).sum::<f64>();
        let first = shape.first();
        let likeness = |k: usize, function: usize| {
            let column = first + function;
            sum(column, k).powi(2) / sum(column, column).max(f64::MIN_POSITIVE)
        };
        let most_like = |k: usize| {
            let each = (0..posed.groups.len()).map(|function| (function, likeness(k, function)));
            each.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |most| most.0)
        };
        let more = (further..further + count).map(|k| posed.groups[most_like(k)]);
        let groups = posed.groups.iter().copied().chain(more).collect();
        let mut next = ways;
        let with_place = |(way, _): &(&Way, &[f64])| {
            let way = Way { first: next + 1, ..(*way).clone() };
            next += 1 + way.units.len();
            way
        };
        let effects = effects.iter().map(with_place).collect();
        Self { shape, groups, products, effects }
    }
}

impl Extended {
    /// What each effect adds to a run at its size, as a sum of its columns.
    pub fn at_their_sizes(&self, effects: &[(&Way, &[f64])]) -> Vec<DVector<f64>> {
        let (size, first) = (self.products[0].nrows(), self.shape.further());
        let of = |(way, (given, at)): (&Way, &(&Way, &[f64]))| {
            let mut sum = DVector::zeros(size);
            sum[first + way.first - 1] = -1.0;
            for (k, (c, unit)) in at.iter().zip(&given.units).enumerate() {
                sum[first + way.first + k] = c * unit;
            }
            sum
        };
        self.effects.iter().zip(effects).map(of).collect()
    }
}

/// Columns of each run, whatever its label: what the linear model about each size adds where there
/// is none of the effect, then its slopes.
fn about(posed: &Posed<'_>, effects: &[(&Way, &[f64])]) -> Vec<DMatrix<f64>> {
    let width: usize = effects.iter().map(|(way, _)| 1 + way.units.len()).sum();
    let of_run = |run: usize| {
        let products = &posed.runs[run];
        let start = posed.start_of(run);
        let power = posed.free.power(run, &start);
        let mut columns = DMatrix::zeros(products.columns.nrows(), width);
        let mut first = 0;
        for (way, at) in effects {
            let about = relinearise::columns(&posed.free, &start, products, run, way, at, &power);
            columns.columns_mut(first, about.ncols()).copy_from(&about);
            first += about.ncols();
        }
        columns
    };
    (0..posed.runs.len()).into_par_iter().map(of_run).collect()
}
