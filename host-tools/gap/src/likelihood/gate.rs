//! Would as much be seen if other runs were called the field? Under "none" clean and field runs of
//! like drives may change places: the share of relabelled sets that show as much is exact, but for
//! the size about which a named effect is linear, which the given labels told.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::evidence::{Marginal, Totals, reduce};
use super::extended::Extended;
use super::normal::log_sum;
use super::posterior::Posterior;
use super::priors::{ELSE_SIZES, RELABELLED};
use super::products::Posed;
use super::scored::{Scales, Scored};
use super::variances;
use super::ways::Way;

/// Relabelled sets that are asked before it is looked whether more are needed.
const AT_ONCE: usize = 7;

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

    /// Of some runs; `None` where they can be relabelled in too few ways for the level. `bent` are
    /// ways with the coefficients about which they are linear; where there are none, something else
    /// is asked for as well.
    pub fn of(posed: &Posed<'_>, bent: &[(&Way, &[f64])], scales: &Scales, level: f64) -> Option<Self> {
        let count = posed.runs.len();
        let field = (0..count).filter(|&run| posed.is_field(run)).count();
        if choose(count, field).recip() > level {
            return None;
        }
        let ways = posed.own_first() - posed.shape.further();
        let extended = Extended::of(posed, bent, ways);
        let asked =
            Asked { ways: &posed.ways, base: &posed.base, scales, extended, is_named: !bent.is_empty() };
        let labels: Vec<bool> = (0..count).map(|run| posed.is_field(run)).collect();
        let seen = asked.odds(&labels)?;
        let is_as_great =
            |seed: &usize| asked.odds(&relabelled(&labels, *seed as u64)).is_some_and(|value| value >= seen);
        // With the given one as many as the level needs.
        let sets = RELABELLED.max(level.recip().ceil() as usize - 1);
        let mut gate = Self { share: 0.0, level };
        let mut as_great = 0;
        // Once too many were as great, the rest cannot change that.
        for first in (0..sets).step_by(AT_ONCE) {
            let next = sets.min(first + AT_ONCE);
            as_great += (first..next).into_par_iter().filter(is_as_great).count();
            gate.share = (1 + as_great) as f64 / (1 + next) as f64;
            if (1 + as_great) as f64 > level * (1 + sets) as f64 {
                break;
            }
        }
        Some(gate)
    }
}

/// What is asked of any labels: every way about no effect, and what was named about its size.
struct Asked<'a> {
    ways: &'a [Way],
    base: &'a DMatrix<f64>,
    scales: &'a Scales,
    extended: Extended,
    is_named: bool,
}

impl Asked<'_> {
    /// ln of how much more probable effects are than none, by these labels. All anew by them: what
    /// was told by the given ones would favour them.
    fn odds(&self, labels: &[bool]) -> Option<f64> {
        let [clean, field] = [false, true]
            .map(|of| (0..labels.len()).filter(|&run| labels[run] == of).collect::<Vec<usize>>());
        let own = &self.extended;
        let of = |runs: &[usize]| runs.iter().map(|&run| &own.products[run]).collect::<Vec<_>>();
        let start = Some(&self.scales.variances);
        let variances = variances::told(&of(&clean), &of(&field), own.shape, &own.groups, self.base, start)?;
        let all: Vec<&Way> = self.ways.iter().chain(&own.effects).collect();
        let runs: Option<Vec<Marginal>> =
            own.products.iter().map(|run| Marginal::of(run, own.shape, &variances.runs)).collect();
        let totals = Totals::of(own.shape, labels.iter().copied().zip(&runs?));
        let form = self.scales.cases[self.scales.likeliest()].form;
        let none = reduce(&totals, own.shape, &variances, form)?;
        let scored = |(way, evidence): (&&Way, f64)| Scored {
            way: (*way).clone(),
            evidence,
            coefficients: Vec::new(),
            searched: 0.0,
            in_runs: false,
        };
        let each = all.iter().enumerate().map(|(place, way)| match place < self.ways.len() {
            true => way.gain(&none, &self.scales.sizes),
            false => way.gain_about(&none, &self.scales.sizes),
        });
        let scored: Vec<Scored> = all.iter().zip(each).map(scored).collect();
        let effects = Posterior::of(&scored, f64::NEG_INFINITY).effects;
        let named = log_sum(effects.iter().map(|own| own.evidence)) - (effects.len() as f64).ln();
        if self.is_named {
            return Some(named);
        }
        let further = own.shape.further();
        let field = totals.field.view((0, 0), (further, further)).into_owned();
        let size = ELSE_SIZES[ELSE_SIZES.len() / 2];
        let other = form + size * size;
        let other = reduce(&Totals { field, ..totals }, own.shape, &variances, other)?;
        Some(named.max(0.5 * (none.minus_two_log - other.minus_two_log)))
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
