//! What rules found, weighed by the likelihood: is a gap without a name more than relabelled runs
//! show, and is a name probable among the listed effects?
//!
//! Rules name what explains most, and the locked runs confirm that it is there in part. Both rank
//! with noise models of their own: a name that the likelihood ranks far behind another is none.

use std::collections::BTreeSet;

use logs::runs::Runs;

use super::likelihood::Gate;
use super::likelihood::posterior::smallest_sure;
use super::likelihood::priors::SURE;
use super::likelihood::question::Question;
use super::likelihood::round::Asked;
use super::likelihood::scored::Scales;
use super::report::{Report, Rival};
use residuals::types::{Base, Options, Verdict};

/// Probabilities below this share are not said.
const LEAST_SAID: f64 = 0.01;

impl Report {
    /// Takes back a gap that relabelled runs show as well, and names that are improbable.
    #[must_use]
    pub fn weighed(self, runs: &Runs, clean: &Runs, base: &Base, options: &Options, level: f64) -> Self {
        let weigh = match self.verdict {
            Verdict::Unexplained => Self::held_to_labels,
            Verdict::Named | Verdict::Ambiguous => Self::held_to_probabilities,
            Verdict::None => return self,
        };
        let question = Question::of(runs, Some(clean), base, options);
        weigh(self, &question.asked(base, options, level))
    }

    fn held_to_labels(mut self, asked: &Asked<'_>) -> Self {
        let posed = asked.posed(&[]).ok_or("too few steady rows tell the noise of the power".to_owned());
        let gate = posed.and_then(|posed| {
            let scales = Scales::told(&posed).ok_or("sums of products are no numbers")?;
            Gate::of(&posed, &[], &scales, asked.level)
        });
        match gate {
            Ok(gate) => {
                let verdict = if gate.is_shut() { Verdict::None } else { self.verdict };
                Self { relabelled: Some(gate), ..self.without_names(verdict) }
            }
            Err(why) => {
                let note = format!("{why}: whether relabelled runs would show as much was not asked");
                self.notes.push(note);
                self
            }
        }
    }

    fn held_to_probabilities(self, asked: &Asked<'_>) -> Self {
        // Of several names each explains what the others leave.
        if self.effects.len() != 1 {
            return self;
        }
        let Some(weighed) = asked.weighed(&[]) else { return self };
        self.held_to(weighed.among_effects())
    }

    /// Takes the name back if it is improbable among the listed effects, with all that it ties
    /// with. Of a tie, strikes the rivals that are outside the smallest sure set; an effect that is
    /// likelier than the name joins it. Whether it is something else is for the rules to say: a
    /// measured robot always has something else, too. `shares`: ids and probabilities, the
    /// likeliest first.
    fn held_to(mut self, shares: Vec<(String, f64)>) -> Self {
        let named = self.effects[0].candidate.id.clone();
        let Some(place) = shares.iter().position(|(id, _)| *id == named) else { return self };
        let is_tied = |id: &String| *id == named || self.ambiguous_with.contains(id);
        let tied: Vec<&(String, f64)> = shares.iter().filter(|(id, _)| is_tied(id)).collect();
        let all: f64 = tied.iter().map(|(_, share)| share).sum();
        let rivals = shares.iter().filter(|(_, share)| *share >= LEAST_SAID).cloned().collect();
        if all < 1.0 - SURE {
            return Self { rivals, ..self.without_names(Verdict::Unexplained) };
        }
        let sure = smallest_sure(tied.iter().map(|(_, share)| *share), all);
        let kept = shares[..place].iter().chain(tied[..sure].iter().copied()).map(|(id, _)| id);
        // What one mass cannot tell apart is in doubt without a tie, and stays so.
        let is_in_a_tie = |id: &String| self.ties.iter().flatten().any(|rival| rival.candidate.id == *id);
        let doubted = self.ambiguous_with.iter().filter(|id| !is_in_a_tie(id));
        let others: BTreeSet<String> = kept.chain(doubted).filter(|id| **id != named).cloned().collect();
        let is_kept = |rival: &Rival| rival.candidate.id == named || others.contains(&rival.candidate.id);
        self.ties.iter_mut().for_each(|tie| tie.retain(is_kept));
        self.verdict = if others.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
        if others.is_empty() {
            self.ties.clear();
        }
        Self { ambiguous_with: others.into_iter().collect(), rivals, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::example::report;
    use super::*;

    /// `grade` is named, with these in doubt, the first `tied` of them in a tie; weighed.
    fn weighed(in_doubt: &[&str], tied: usize, shares: &[(&str, f64)]) -> (Verdict, Vec<String>) {
        let mut report = report(Verdict::Named);
        report.effects.truncate(1);
        let candidate = report.effects[0].candidate.clone();
        let rival = |id: &str| Rival {
            candidate: model::effects::Candidate { id: id.to_owned(), ..candidate.clone() },
            state: report.state.clone(),
        };
        report.ties = vec![["grade"].iter().chain(&in_doubt[..tied]).map(|id| rival(id)).collect()];
        report.ambiguous_with = in_doubt.iter().map(|&id| id.to_owned()).collect();
        let shares = shares.iter().map(|&(id, share)| (id.to_owned(), share)).collect();
        let held = report.held_to(shares);
        (held.verdict, held.ambiguous_with)
    }

    fn ids(ids: &[&str]) -> Vec<String> {
        ids.iter().map(|&id| id.to_owned()).collect()
    }

    #[test]
    fn an_improbable_name_is_taken_back_unless_what_it_ties_with_is_probable() {
        assert_eq!(weighed(&[], 0, &[("windage", 0.96), ("grade", 0.04)]), (Verdict::Unexplained, vec![]));
        let tie = weighed(&["windage"], 1, &[("windage", 0.96), ("grade", 0.04)]);
        assert_eq!(tie, (Verdict::Ambiguous, ids(&["windage"])));
    }

    #[test]
    fn a_likelier_effect_joins_the_name_and_an_improbable_rival_is_struck() {
        let joined = weighed(&[], 0, &[("windage", 0.6), ("grade", 0.4)]);
        assert_eq!(joined, (Verdict::Ambiguous, ids(&["windage"])));
        let struck = weighed(&["windage"], 1, &[("grade", 0.99), ("windage", 0.01)]);
        assert_eq!(struck, (Verdict::Named, vec![]));
    }

    /// No probability says more than the drives do.
    #[test]
    fn what_one_mass_cannot_tell_apart_stays_in_doubt() {
        let doubted = weighed(&["windage", "stribeck"], 1, &[("grade", 0.99), ("windage", 0.005)]);
        assert_eq!(doubted, (Verdict::Ambiguous, ids(&["stribeck"])));
    }
}
