//! Would as much be seen if other runs were called the field? Under "none" clean and field runs of
//! like drives may change places: the share of relabelled sets that show as much is exact.

use rayon::prelude::*;

use super::evidence::{Marginal, Totals, reduce};
use super::priors::{ELSE_SIZES, RELABELLED};
use super::products::Posed;
use super::scored::variances_of;
use super::ways::sizes;

/// What relabelled runs say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// Share of relabelled sets, the given one included, whose greatest evidence is as great.
    pub share: f64,
    /// What is allowed.
    pub level: f64,
}

impl Gate {
    /// Whether what is seen may be what labels do by chance.
    pub fn is_shut(self) -> bool {
        self.share > self.level
    }

    /// Of some runs; `None` where they can be relabelled in too few ways for the level.
    pub fn of<const N: usize>(posed: &Posed<'_, N>, level: f64) -> Option<Self> {
        let count = posed.runs.len();
        let field = (0..count).filter(|&run| posed.is_field(run)).count();
        if choose(count, field).recip() > level {
            return None;
        }
        let size = posed.own_first();
        let greatest = |labels: &[bool]| {
            // All anew by these labels: what was told by the given ones would favour them.
            let clean: Vec<usize> = (0..count).filter(|&run| !labels[run]).collect();
            let variances = variances_of(posed, &clean)?;
            let runs: Option<Vec<Marginal>> = posed
                .runs
                .iter()
                .map(|run| {
                    let own = run.products.view((0, 0), (size, size)).into_owned();
                    Marginal::of(&own, posed.shape, &variances.runs)
                })
                .collect();
            let totals = Totals::of(posed.shape, labels.iter().copied().zip(&runs?));
            let sizes = sizes(posed.power);
            let none = reduce(&totals, posed.shape, &variances, 0.0)?;
            let ways = posed.ways.iter().map(|way| way.gain(&none, &sizes)).fold(f64::NEG_INFINITY, f64::max);
            let middle = ELSE_SIZES[ELSE_SIZES.len() / 2];
            let further = posed.shape.further();
            let cut = Totals { field: totals.field.view((0, 0), (further, further)).into_owned(), ..totals };
            let other = reduce(&cut, posed.shape, &variances, middle * middle)?;
            Some(ways.max(0.5 * (none.minus_two_log - other.minus_two_log)))
        };
        let labels: Vec<bool> = (0..count).map(|run| posed.is_field(run)).collect();
        let seen = greatest(&labels)?;
        let as_great = (0..RELABELLED)
            .into_par_iter()
            .filter(|seed| greatest(&relabelled(&labels, *seed as u64)).is_some_and(|value| value >= seen))
            .count();
        Some(Self { share: (1 + as_great) as f64 / (1 + RELABELLED) as f64, level })
    }
}

/// In how many ways so many of some are chosen.
fn choose(count: usize, chosen: usize) -> f64 {
    (1..=chosen).fold(1.0, |ways, k| ways * (count - chosen + k) as f64 / k as f64)
}

/// Labels in another order: the shuffle of Fisher and Yates with a multiplier's numbers.
fn relabelled(labels: &[bool], seed: u64) -> Vec<bool> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % below
    };
    let mut labels = labels.to_vec();
    for last in (1..labels.len()).rev() {
        labels.swap(last, next(last + 1));
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

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
