//! Would as much be seen if other runs were called the field?
//!
//! Without an effect, clean and field runs of like drives may change places. Each run tells how
//! much of every cause and smooth function it has. The greatest difference between field and clean
//! runs is held against that of other labels, and so is how much more field runs scatter. This is
//! exact at any level (Westfall and Young 1993) but for the variances, which the given labels told.

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::evidence::{Marginal, Totals, reduce};
use super::priors::{BETWEEN_RUNS, RELABELLED};
use super::products::{Posed, RunProducts};
use super::scored::Scales;
use super::step_times::SingleRuns;
use super::variances::{self, Solved};

/// What relabelled runs say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// Share of relabelled sets, the given one included, whose greatest difference is as great.
    pub share: f64,
    /// What is allowed.
    pub level: f64,
}

impl Gate {
    /// Whether what is seen may be what labels do by chance.
    pub fn is_shut(self) -> bool {
        self.share > self.level
    }

    /// Of some runs.
    ///
    /// # Errors
    /// Why labels tell nothing: they can be changed in too few ways for the level.
    pub fn of(posed: &Posed<'_>, scales: &Scales, level: f64) -> Result<Self, String> {
        let labels: Vec<bool> = (0..posed.runs.len()).map(|run| posed.is_field(run)).collect();
        let field = labels.iter().filter(|label| **label).count();
        if choose(labels.len(), field).recip() > level {
            return Err(format!("these runs can be relabelled in too few ways for a level of {level}"));
        }
        let causes = causes(posed, scales, &labels).ok_or("sums of products are no numbers")?;
        let greatest = |labels: &[bool]| {
            let signs =
                DVector::from_iterator(labels.len(), labels.iter().map(|label| f64::from(u8::from(*label))));
            causes.iter().map(|cause| cause.difference(&signs)).fold(0.0, f64::max)
        };
        let scatter = scatter(posed, scales).ok_or("sums of products are no numbers")?;
        let of = |labels: &[bool]| [greatest(labels), more_in_field(&scatter, labels)];
        // With the given one as many as the level needs.
        let sets = RELABELLED.max(level.recip().ceil() as usize - 1);
        let others = (0..sets).into_par_iter().map(|seed| of(&relabelled(&labels, seed as u64)));
        let all: Vec<[f64; 2]> = [of(&labels)].into_iter().chain(others.collect::<Vec<_>>()).collect();
        Ok(Self { share: share_as_great(&all), level })
    }
}

/// Share of sets, the first included, in which one of two figures is as rarely reached as in the
/// first (the least p of Westfall and Young).
fn share_as_great(all: &[[f64; 2]]) -> f64 {
    let of = |k: usize| {
        let mut sorted: Vec<f64> = all.iter().map(|both| both[k]).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        move |value: f64| sorted.len() - sorted.partition_point(|other| *other < value)
    };
    let (first, second) = (of(0), of(1));
    let rarest: Vec<usize> = all.iter().map(|[a, b]| first(*a).min(second(*b))).collect();
    rarest.iter().filter(|count| **count <= rarest[0]).count() as f64 / all.len() as f64
}

/// ln mean square of what base and functions leave of each run, standard deviations of the noise.
fn scatter(posed: &Posed<'_>, scales: &Scales) -> Option<Vec<f64>> {
    let shape = posed.shape;
    let size = shape.further();
    let runs = scales.in_case(scales.likeliest());
    let sums = Totals::of(shape, runs.iter().map(|run| (false, run)));
    let solved = Solved::of(&sums.all, shape, &scales.variances)?;
    let mut leaves = DVector::from_element(size, 1.0);
    leaves.rows_mut(1, size - 1).copy_from(&-solved.values);
    let of = |run: &RunProducts| {
        let square = leaves.dot(&(run.products.view((0, 0), (size, size)) * &leaves));
        (square / run.weight.max(f64::MIN_POSITIVE)).ln()
    };
    Some(posed.runs.iter().map(of).collect())
}

/// Mean of the field's values less that of the others.
fn more_in_field(values: &[f64], field: &[bool]) -> f64 {
    let mean = |wanted: bool| {
        let of = values.iter().zip(field).filter(|(_, field)| **field == wanted);
        let (sum, count) = of.fold((0.0, 0.0), |(sum, count), (value, _)| (sum + value, count + 1.0));
        sum / count
    };
    mean(true) - mean(false)
}

/// Every cause that shows as one column, and every smooth function.
fn causes(posed: &Posed<'_>, scales: &Scales, labels: &[bool]) -> Option<Vec<Cause>> {
    let (shape, end) = (posed.shape, posed.mass_column());
    let products: Vec<DMatrix<f64>> =
        posed.runs.iter().map(|run| run.products.view((0, 0), (end, end)).into_owned()).collect();
    let of = |wanted: bool| {
        let runs = products.iter().zip(labels);
        runs.filter(|(_, label)| **label == wanted).map(|(products, _)| products).collect::<Vec<_>>()
    };
    let (start, groups) = (Some(&scales.variances), &posed.groups);
    let variances = variances::told(&of(false), &of(true), shape, groups, &posed.base, start)?;
    let runs = products.par_iter().map(|run| Marginal::of(run, shape, &variances.runs));
    let runs: Vec<Marginal> = runs.collect::<Option<_>>()?;
    let totals = Totals::of(shape, labels.iter().copied().zip(&runs));
    let form = scales.cases[scales.likeliest()].form;
    let reduced = reduce(&totals, shape, &variances, form)?;
    let runs: Vec<(bool, &Marginal)> = labels.iter().copied().zip(&runs).collect();
    let further = shape.further();
    let single = posed.ways.iter().filter(|way| way.units.len() == 1);
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let functions = (shape.first()..further).map(|column| (column, any));
    let asked: Vec<(usize, (f64, f64))> =
        single.map(|way| (further + way.first, way.candidate.range)).chain(functions).collect();
    let cause = |(column, range): &(usize, (f64, f64))| {
        let columns: Vec<_> = runs.iter().map(|_| *column..*column + 1).collect();
        Cause::of(&SingleRuns::of(&reduced, shape, &runs, &columns), *range)
    };
    Some(asked.par_iter().filter_map(cause).collect())
}

/// How much of a cause each run has, at each variance of that between runs.
struct Cause {
    /// ln likelihood of a run with none, what each run pulls by, and by how much it resists.
    at: Vec<(f64, DVector<f64>, DMatrix<f64>)>,
    /// In which an effect may be.
    range: (f64, f64),
}

impl Cause {
    fn of(runs: &SingleRuns, range: (f64, f64)) -> Option<Self> {
        let count = runs.along.len();
        let at = BETWEEN_RUNS.map(|std_dev| {
            let variance = std_dev * std_dev;
            // (I + τ² A)⁻¹, which does not ask for A's own inverse.
            let root = Cholesky::new(&runs.gram * variance + DMatrix::identity(count, count))?;
            let pull = root.solve(&runs.along);
            let log = 0.5 * variance * runs.along.dot(&pull) - root.l_dirty().diagonal().map(f64::ln).sum();
            Some((log, pull, root.solve(&runs.gram)))
        });
        Some(Self { at: at.into_iter().collect::<Option<_>>()?, range })
    }

    /// By how much likelier runs are, nats, where those of the field have another mean than the
    /// others; 0 where it is one that the effect cannot have.
    fn difference(&self, field: &DVector<f64>) -> f64 {
        let (mut with, mut without) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for (log, pull, resist) in &self.at {
            let resisted = resist * field;
            let (all, cross, of_field) = (resist.sum(), resisted.sum(), resisted.dot(field));
            let common = log + 0.5 * pull.sum().powi(2) / all.max(f64::MIN_POSITIVE);
            let along = pull.dot(field) - cross * pull.sum() / all.max(f64::MIN_POSITIVE);
            let rest = of_field - cross * cross / all.max(f64::MIN_POSITIVE);
            let is_allowed = if along > 0.0 { self.range.1 > 0.0 } else { self.range.0 < 0.0 };
            let may = is_allowed && rest > 1e-9 * of_field;
            without = without.max(common);
            with = with.max(common + if may { 0.5 * along * along / rest } else { 0.0 });
        }
        with - without
    }
}

/// In how many ways so many of some are chosen.
fn choose(count: usize, chosen: usize) -> f64 {
    (1..=chosen).fold(1.0, |ways, k| ways * (count - chosen + k) as f64 / k as f64)
}

/// Labels in another order.
fn relabelled(labels: &[bool], seed: u64) -> Vec<bool> {
    let mut labels = labels.to_vec();
    labels.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs that know nothing of each other: weighted means of the field's and of all runs.
    #[test]
    fn a_difference_is_that_of_weighted_means() {
        let (sizes, known) = ([0.9, 1.4, 1.1, 0.1, -0.2, 0.3], [4.0, 9.0, 25.0, 16.0, 4.0, 9.0]);
        let runs = SingleRuns {
            along: DVector::from_iterator(6, sizes.iter().zip(known).map(|(c, a)| c * a)),
            gram: DMatrix::from_diagonal(&DVector::from_row_slice(&known)),
            firsts: (0..=6).collect(),
        };
        let field = DVector::from_row_slice(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        // ln likelihood at a variance between runs, each group at its weighted mean.
        let log = |variance: f64, groups: &[(usize, usize)]| -> f64 {
            let weight = |run: usize| (1.0 / known[run] + variance).recip();
            let of = |&(first, end): &(usize, usize)| {
                let total: f64 = (first..end).map(weight).sum();
                let mean = (first..end).map(|run| weight(run) * sizes[run]).sum::<f64>() / total;
                let square = |run: usize| weight(run) * (sizes[run] - mean).powi(2) - weight(run).ln();
                -0.5 * (first..end).map(square).sum::<f64>()
            };
            groups.iter().map(of).sum()
        };
        let best = |groups: &[(usize, usize)]| {
            BETWEEN_RUNS.map(|sd| log(sd * sd, groups)).into_iter().fold(f64::NEG_INFINITY, f64::max)
        };
        let expected = best(&[(0, 3), (3, 6)]) - best(&[(0, 6)]);
        let any = Cause::of(&runs, (f64::NEG_INFINITY, f64::INFINITY)).unwrap();
        assert!((any.difference(&field) - expected).abs() < 1e-9, "{} {expected}", any.difference(&field));
        // Less in the field is nothing that grows.
        let less = DVector::from_element(6, 1.0) - &field;
        assert_eq!(Cause::of(&runs, (0.0, f64::INFINITY)).unwrap().difference(&less), 0.0);
    }

    /// The first set is greatest in one figure, the second in the other.
    #[test]
    fn the_rarer_of_two_figures_counts() {
        assert_eq!(share_as_great(&[[5.0, 0.0], [1.0, 9.0], [2.0, 1.0], [3.0, 2.0]]), 0.5);
        assert_eq!(share_as_great(&[[1.0, 0.0], [1.0, 9.0], [2.0, 1.0], [3.0, 2.0]]), 1.0);
        assert_eq!(more_in_field(&[1.0, 3.0, 0.5, 1.5], &[true, true, false, false]), 1.0);
    }

    #[test]
    fn ways_to_choose() {
        assert_eq!(choose(18, 12).round(), 18_564.0);
        assert_eq!(choose(13, 12).round(), 13.0);
    }

    /// Of 18 runs with 12 in the field each is clean in a third of the relabelled sets.
    #[test]
    fn every_run_is_as_often_clean() {
        let labels: Vec<bool> = (0..18).map(|run| run < 12).collect();
        let mut clean = [0; 18];
        for seed in 0..3000 {
            let other = relabelled(&labels, seed);
            assert_eq!(other.iter().filter(|label| **label).count(), 12);
            for (count, label) in clean.iter_mut().zip(&other) {
                *count += usize::from(!label);
            }
        }
        // 1000 ± 26, one standard deviation.
        assert!(clean.iter().all(|count| (880..1120).contains(count)), "{clean:?}");
    }
}
