//! A step of one size at a time of its own in each run, or in some: times are summed over.

use nalgebra::{DMatrix, DVector};

use super::evidence::{Marginal, Reduced, Shape, gain};
use super::normal::{log_mean, log_sum};
use super::priors::WITHOUT_STEP;

/// Sweeps over the runs, at most: each settles given the others.
const SWEEPS: usize = 6;

/// Products, in V⁻¹, of what lives in single field runs, run after run.
#[derive(Debug, Clone)]
pub struct SingleRuns {
    /// X'V⁻¹y.
    pub along: DVector<f64>,
    /// X'V⁻¹X, over all runs.
    pub gram: DMatrix<f64>,
    /// Where each run's columns begin, and the end.
    pub firsts: Vec<usize>,
}

impl SingleRuns {
    /// Of `columns` of each run's products; runs with whether they are in the field.
    pub fn of(
        reduced: &Reduced,
        shape: Shape,
        runs: &[(bool, &Marginal)],
        columns: &[std::ops::Range<usize>],
    ) -> Self {
        let nuisances = shape.further() - 1;
        // Something else in the field has the functions once more.
        let size = reduced.nuisance.count();
        let mut firsts = vec![0];
        let (mut solved, mut along) = (Vec::new(), Vec::new());
        for ((field, run), range) in runs.iter().zip(columns) {
            let count = range.len();
            let mut cross = DMatrix::zeros(size, count);
            let products = |first, rows| run.products.view((first, range.start), (rows, count));
            cross.rows_mut(0, nuisances).copy_from(&products(1, nuisances));
            let again = size - nuisances;
            if *field {
                cross.rows_mut(nuisances, again).copy_from(&products(shape.first(), again));
            }
            let cross = reduced.nuisance.solved(cross);
            let taken = cross.tr_mul(&reduced.nuisance.measured);
            along.extend((0..count).map(|k| run.products[(range.start + k, 0)] - taken[k]));
            firsts.push(along.len());
            solved.push(cross);
        }
        let total = along.len();
        let mut all = DMatrix::zeros(size, total);
        for (cross, first) in solved.iter().zip(&firsts) {
            all.view_mut((0, *first), (size, cross.ncols())).copy_from(cross);
        }
        let mut gram = -(all.transpose() * &all);
        for (((_, run), range), first) in runs.iter().zip(columns).zip(&firsts) {
            let mut block = gram.view_mut((*first, *first), (range.len(), range.len()));
            block += run.products.view((range.start, range.start), (range.len(), range.len()));
        }
        Self { along: DVector::from_vec(along), gram, firsts }
    }

    fn runs(&self) -> usize {
        self.firsts.len() - 1
    }
}

/// What the search for times found.
#[derive(Debug, Clone, PartialEq)]
pub struct Times {
    /// ln evidence over none, times summed over.
    pub evidence: f64,
    /// What the best times alone gain, without their prior.
    pub gain: f64,
    /// The best time of each run, by its place.
    pub at: Vec<Option<usize>>,
}

/// ln evidence of steps of one size.
pub fn steps(of: &SingleRuns, sizes: &[f64], range: (f64, f64)) -> Option<Times> {
    let each: Vec<Times> =
        WITHOUT_STEP.iter().filter_map(|without| best(of, sizes, range, *without)).collect();
    let evidence = log_mean(each.iter().map(|times| times.evidence));
    let best = each.into_iter().max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    Some(Times { evidence, ..best })
}

fn best(of: &SingleRuns, sizes: &[f64], range: (f64, f64), without: f64) -> Option<Times> {
    let starts = sizes.iter().flat_map(|size| [*size, -size]);
    let inside = starts.filter(|size| (range.0..=range.1).contains(size));
    let times = inside.filter_map(|size| Search { of, sizes, range, without }.from(size));
    times.max_by(|a, b| a.evidence.total_cmp(&b.evidence))
}

struct Search<'a> {
    of: &'a SingleRuns,
    sizes: &'a [f64],
    range: (f64, f64),
    without: f64,
}

impl Search<'_> {
    /// Times that are best for a size, then better ones of each run given the others.
    fn from(&self, size: f64) -> Option<Times> {
        let of = self.of;
        let alone = |column: usize| size * of.along[column] - 0.5 * size * size * of.gram[(column, column)];
        let first = |run: usize| {
            let columns = of.firsts[run]..of.firsts[run + 1];
            let best = columns.max_by(|a, b| alone(*a).total_cmp(&alone(*b)));
            best.filter(|column| alone(*column) > 0.0)
        };
        let mut at: Vec<Option<usize>> = (0..of.runs()).map(first).collect();
        let (mut last, mut spare) = (f64::NEG_INFINITY, 0.0);
        for _ in 0..SWEEPS {
            spare = 0.0;
            for run in 0..at.len() {
                let options = self.options(&at, run);
                let (place, best) = options
                    .iter()
                    .enumerate()
                    .max_by(|a, b| a.1.total_cmp(b.1))
                    .map(|(place, best)| (place, *best))?;
                at[run] = (place > 0).then(|| of.firsts[run] + place - 1);
                spare += log_sum(options) - best;
            }
            let now = self.value(&at);
            if now < last + 1e-3 {
                break;
            }
            last = now;
        }
        let gain = self.gain_of(&at);
        let evidence = self.value(&at) + spare;
        let at = at.iter().zip(&of.firsts).map(|(at, first)| at.map(|column| column - first)).collect();
        Some(Times { evidence, gain, at })
    }

    /// Of a run: without a step, then with one at each time, the others as they are.
    fn options(&self, at: &[Option<usize>], run: usize) -> Vec<f64> {
        let of = self.of;
        let others: Vec<usize> =
            at.iter().enumerate().filter(|(place, _)| *place != run).filter_map(|(_, at)| *at).collect();
        let along: f64 = others.iter().map(|column| of.along[*column]).sum();
        let gram: f64 = others.iter().flat_map(|a| others.iter().map(|b| of.gram[(*a, *b)])).sum();
        let count = (of.firsts[run + 1] - of.firsts[run]).max(1) as f64;
        let with = |column: usize| {
            let cross: f64 = others.iter().map(|other| of.gram[(column, *other)]).sum();
            let gain = self.gain(along + of.along[column], gram + 2.0 * cross + of.gram[(column, column)]);
            gain + ((1.0 - self.without) / count).ln()
        };
        let none = self.gain(along, gram) + self.without.ln();
        [none].into_iter().chain((of.firsts[run]..of.firsts[run + 1]).map(with)).collect()
    }

    fn gain(&self, along: f64, gram: f64) -> f64 {
        log_mean(self.sizes.iter().map(|size| gain(along, gram.max(0.0), *size, self.range)))
    }

    fn gain_of(&self, at: &[Option<usize>]) -> f64 {
        let on: Vec<usize> = at.iter().filter_map(|at| *at).collect();
        let along: f64 = on.iter().map(|column| self.of.along[*column]).sum();
        let gram: f64 = on.iter().flat_map(|a| on.iter().map(|b| self.of.gram[(*a, *b)])).sum();
        self.gain(along, gram)
    }

    /// With the prior of the times.
    fn value(&self, at: &[Option<usize>]) -> f64 {
        let prior = |(run, at): (usize, &Option<usize>)| match at {
            None => self.without.ln(),
            Some(_) => ((1.0 - self.without) / (self.of.firsts[run + 1] - self.of.firsts[run]) as f64).ln(),
        };
        self.gain_of(at) + at.iter().enumerate().map(prior).sum::<f64>()
    }
}
