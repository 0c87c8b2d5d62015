//! Probabilities of causes, and the verdict that they come to.

use super::bagged;
use super::normal::{log_mean, log_sum};
use super::priors::{ELSE, NONE, SURE};
use super::scored::{Other, Scored};
use residuals::types::Verdict;

/// A cause of the dictionary.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// Its id.
    pub id: String,
    /// ln evidence over none.
    pub evidence: f64,
    /// Probability.
    pub probability: f64,
    /// The way in which it shows best, by its place.
    pub best: usize,
}

/// How probable each cause is.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// That nothing is new.
    pub none: f64,
    /// Something that the dictionary lacks.
    pub something_else: f64,
    /// Each effect, the likeliest first.
    pub effects: Vec<Cause>,
}

impl Posterior {
    /// By evidences over none. All runs as they are tell whether something is new;
    /// [weights](bagged) of the field runs tell what it is.
    pub fn of(scored: &[Scored], other: &Other) -> Self {
        let mut effects = Cause::all(scored);
        let each = ((1.0 - NONE - ELSE) / effects.len().max(1) as f64).ln();
        let runs = other.by_run.len();
        let by_run = effects.iter().map(|cause| cause.by_run(scored, runs));
        let by_run: Vec<Vec<f64>> = by_run.chain([other.by_run.clone()]).collect();
        let values = effects.iter().map(|cause| cause.evidence + each).chain([ELSE.ln() + other.evidence]);
        let values: Vec<f64> = values.collect();
        let total = log_sum(values.iter().copied().chain([NONE.ln()]));
        let none = (NONE.ln() - total).exp();
        let causes: Vec<(f64, &[f64])> = values.into_iter().zip(by_run.iter().map(Vec::as_slice)).collect();
        let mut shares = bagged::shares(&causes);
        let something_else = (1.0 - none) * shares.pop().unwrap_or(0.0);
        for (cause, share) in effects.iter_mut().zip(shares) {
            cause.probability = (1.0 - none) * share;
        }
        effects.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        Self { none, something_else, effects }
    }

    /// Whether something is new, and if so the smallest set of causes that is sure, with the
    /// effects that are in it. Where something else may be it, no name.
    pub fn verdict(&self) -> (Verdict, Vec<&Cause>) {
        if self.none > 1.0 - SURE {
            return (Verdict::None, Vec::new());
        }
        let effects = self.effects.iter().map(|cause| (cause.probability, Some(cause)));
        let mut all: Vec<(f64, Option<&Cause>)> = effects.chain([(self.something_else, None)]).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let sure = smallest_sure(all.iter().map(|(probability, _)| *probability), 1.0 - self.none);
        let set: Vec<Option<&Cause>> = all.into_iter().take(sure).map(|(_, cause)| cause).collect();
        let names: Vec<&Cause> = set.iter().copied().flatten().collect();
        match (names.len() == set.len(), names.len()) {
            (false, _) | (true, 0) => (Verdict::Unexplained, Vec::new()),
            (true, 1) => (Verdict::Named, names),
            (true, _) => (Verdict::Ambiguous, names),
        }
    }
}

/// Ids and probabilities of the effects if it is one of them, the likeliest first. `runs`: of the
/// field.
pub fn among_effects(scored: &[Scored], runs: usize) -> Vec<(String, f64)> {
    let effects = Cause::all(scored);
    let by_run: Vec<Vec<f64>> = effects.iter().map(|cause| cause.by_run(scored, runs)).collect();
    let each = effects.iter().map(|cause| cause.evidence).zip(by_run.iter().map(Vec::as_slice));
    let shares = bagged::shares(&each.collect::<Vec<_>>());
    let mut all: Vec<_> = effects.into_iter().map(|cause| cause.id).zip(shares).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

/// How many of these, the likeliest first, are sure together.
pub fn smallest_sure(probabilities: impl Iterator<Item = f64>, of_all: f64) -> usize {
    let mut remaining = SURE * of_all;
    let is_wanted = |probability: &f64| {
        let wanted = remaining > 0.0;
        remaining -= probability;
        wanted
    };
    probabilities.take_while(is_wanted).count()
}

impl Cause {
    /// Each cause of some ways.
    pub fn all(scored: &[Scored]) -> Vec<Self> {
        let mut ids: Vec<&str> = scored.iter().map(|each| each.way.candidate.id.as_str()).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.iter().filter_map(|id| Self::of(id, scored)).collect()
    }

    /// What each of so many field runs adds to its evidence, nats.
    fn by_run(&self, scored: &[Scored], runs: usize) -> Vec<f64> {
        match &scored[self.best].by_run[..] {
            // Far behind: about as much of each run.
            [] => vec![self.evidence / runs as f64; runs],
            asked => asked.to_vec(),
        }
    }

    /// Families of its ways are as likely as each other, and ways within one.
    fn of(id: &str, scored: &[Scored]) -> Option<Self> {
        let mut rest: Vec<usize> = (0..scored.len()).filter(|&k| scored[k].way.candidate.id == id).collect();
        let best = rest.iter().copied().max_by(|a, b| scored[*a].evidence.total_cmp(&scored[*b].evidence))?;
        let mut families = Vec::new();
        while let Some(&first) = rest.first() {
            let (same, other): (Vec<usize>, Vec<usize>) = rest.iter().partition(|&&k| {
                scored[k].in_single_runs == scored[first].in_single_runs
                    && scored[k].way.is_of_family(&scored[first].way)
            });
            families.push(log_mean(same.iter().map(|&k| scored[k].evidence)));
            rest = other;
        }
        Some(Self { id: id.to_owned(), evidence: log_mean(families), probability: 0.0, best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn posterior(none: f64, something_else: f64, effects: &[(&str, f64)]) -> Posterior {
        let cause = |(id, probability): &(&str, f64)| Cause {
            id: (*id).to_owned(),
            evidence: 0.0,
            probability: *probability,
            best: 0,
        };
        Posterior { none, something_else, effects: effects.iter().map(cause).collect() }
    }

    #[test]
    fn the_smallest_sure_set_is_the_verdict() {
        let verdict = |none, other, effects: &[(&str, f64)]| {
            let posterior = posterior(none, other, effects);
            let (verdict, names) = posterior.verdict();
            (verdict, names.iter().map(|cause| cause.id.clone()).collect::<Vec<_>>())
        };
        assert_eq!(verdict(0.01, 0.01, &[("a", 0.96), ("b", 0.02)]), (Verdict::Named, vec!["a".to_owned()]));
        let tie = verdict(0.02, 0.01, &[("a", 0.60), ("b", 0.37)]);
        assert_eq!(tie, (Verdict::Ambiguous, vec!["a".to_owned(), "b".to_owned()]));
        assert_eq!(verdict(0.06, 0.0, &[("a", 0.90), ("b", 0.04)]).0, Verdict::None);
        assert_eq!(verdict(0.97, 0.0, &[("a", 0.03)]).0, Verdict::None);
        assert_eq!(verdict(0.0, 0.07, &[("a", 0.93)]).0, Verdict::Unexplained);
        assert_eq!(verdict(0.0, 0.98, &[("a", 0.02)]).0, Verdict::Unexplained);
        assert_eq!(verdict(0.03, 0.0, &[("a", 0.955), ("b", 0.015)]).0, Verdict::Named);
        // Something new is sure: the set is of what it may be, and none is not in it.
        let tie = verdict(0.04, 0.0, &[("a", 0.50), ("b", 0.44), ("c", 0.02)]);
        assert_eq!(tie, (Verdict::Ambiguous, vec!["a".to_owned(), "b".to_owned()]));
    }
}
