//! How probable each cause is.

use super::bagged;
use super::normal::log_mean;
use super::priors::SURE;
use super::scored::Scored;

/// A cause of the dictionary.
struct Cause {
    id: String,
    /// ln evidence over none.
    evidence: f64,
    /// The way in which it shows best, by its place.
    best: usize,
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
    fn all(scored: &[Scored]) -> Vec<Self> {
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
        Some(Self { id: id.to_owned(), evidence: log_mean(families), best })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_is_sure_from_95_percent_on() {
        let count = |probabilities: &[f64], of_all| smallest_sure(probabilities.iter().copied(), of_all);
        assert_eq!(count(&[0.96, 0.02], 1.0), 1);
        assert_eq!(count(&[0.94, 0.04, 0.02], 1.0), 2);
        assert_eq!(count(&[0.48, 0.01], 0.5), 1);
    }
}
