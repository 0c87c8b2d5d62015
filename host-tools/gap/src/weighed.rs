//! What rules found, weighed by the likelihood: is a gap without a name more than relabelled runs
//! show, and is a name probable among the listed effects?
//!
//! Rules name what explains most, and the locked runs confirm that it is there in part. Both rank
//! with noise models of their own: a name that the likelihood ranks far behind another is none.

use std::collections::BTreeSet;

use logs::runs::Runs;

use super::likelihood::posterior::smallest_sure;
use super::likelihood::priors::SURE;
use super::likelihood::question::Question;
use super::likelihood::round::Asked;
use super::likelihood::scored::Scales;
use super::likelihood::{Cause, Gate};
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

    /// Takes a name back that is improbable among the listed effects, with all that it ties with. Of
    /// a tie, strikes the rivals that are outside the smallest sure set; an effect that is likelier
    /// than the name joins it. Whether it is something else is for the rules to say: a measured
    /// robot always has something else, too.
    fn held_to_probabilities(mut self, asked: &Asked<'_>) -> Self {
        // Of several names each explains what the others leave.
        let [named] = &self.effects[..] else { return self };
        let Some(weighed) = asked.weighed(&[]) else { return self };
        let named = named.candidate.id.clone();
        let mut causes = weighed.posterior.effects;
        causes.sort_by(|a, b| b.among_effects.total_cmp(&a.among_effects));
        if causes.iter().all(|cause| cause.id != named) {
            return self;
        }
        let is_tied = |cause: &&Cause| cause.id == named || self.ambiguous_with.contains(&cause.id);
        let tied: Vec<&Cause> = causes.iter().filter(is_tied).collect();
        let all: f64 = tied.iter().map(|cause| cause.among_effects).sum();
        let likely = causes.iter().filter(|cause| cause.among_effects >= LEAST_SAID);
        let rivals = likely.map(|cause| (cause.id.clone(), cause.among_effects)).collect();
        if all < 1.0 - SURE {
            return Self { rivals, ..self.without_names(Verdict::Unexplained) };
        }
        let sure = smallest_sure(tied.iter().map(|cause| cause.among_effects), all);
        let likelier = causes.iter().take_while(|cause| cause.id != named);
        let others = likelier.chain(tied[..sure].iter().copied()).map(|cause| cause.id.clone());
        // What one mass cannot tell apart is in doubt without a tie, and stays so.
        let is_in_a_tie = |id: &String| self.ties.iter().flatten().any(|rival| rival.candidate.id == *id);
        let doubted = self.ambiguous_with.iter().filter(|id| !is_in_a_tie(id)).cloned();
        let others: BTreeSet<String> = others.chain(doubted).filter(|id| *id != named).collect();
        let is_kept = |rival: &Rival| rival.candidate.id == named || others.contains(&rival.candidate.id);
        self.ties.iter_mut().for_each(|tie| tie.retain(is_kept));
        self.verdict = if others.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
        if others.is_empty() {
            self.ties.clear();
        }
        Self { ambiguous_with: others.into_iter().collect(), rivals, ..self }
    }
}
