//! What rules found, weighed by the likelihood: is a gap without a name more than relabelled runs
//! show, and is a name probable beside all other causes and something else?
//!
//! Rules name what explains most of the listed effects, and the locked runs confirm that it is
//! there in part. That it is not another cause, or one that no list has, only its probability says.

use std::collections::BTreeSet;

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};

use super::likelihood::posterior::smallest_sure;
use super::likelihood::priors::SURE;
use super::likelihood::question::Question;
use super::likelihood::round::{Asked, Known, Weighed};
use super::likelihood::scored::Scales;
use super::likelihood::{Cause, Gate, Likelihood};
use super::report::{Report, Rival};
use residuals::types::{Base, Options, Verdict};

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

    /// Takes the names back where one of them is in no set of causes that is sure, whatever it is
    /// in a tie with. Of a tie, rivals that are improbable among all of it are struck.
    fn held_to_probabilities(mut self, asked: &Asked<'_>) -> Self {
        for place in 0..self.effects.len() {
            let Some(weighed) = self.known_beside(place).and_then(|others| asked.weighed(&others)) else {
                continue;
            };
            let named = &self.effects[place].candidate.id;
            let tied: Vec<&String> = [named].into_iter().chain(&self.ambiguous_with).collect();
            let together: f64 = tied.iter().filter_map(|id| weighed.posterior.of_id(id)).sum();
            let is_asked = weighed.posterior.of_id(named).is_some();
            if is_asked && together < 1.0 - SURE {
                self.likelihood = Some(Likelihood { posterior: weighed.posterior, predictive: None });
                return self.without_names(Verdict::Unexplained);
            }
            if is_asked && self.effects.len() == 1 {
                return self.with_probabilities(weighed);
            }
        }
        self
    }

    /// Of one name: strikes the rivals that are not in the smallest sure set, and adds effects that
    /// are likelier than the name; the name stays.
    fn with_probabilities(mut self, weighed: Weighed<'_>) -> Self {
        let causes = &weighed.posterior.effects;
        let named = self.effects[0].candidate.id.clone();
        let is_tied = |cause: &&Cause| cause.id == named || self.ambiguous_with.contains(&cause.id);
        let tied: Vec<&Cause> = causes.iter().filter(is_tied).collect();
        let all = tied.iter().map(|cause| cause.probability).sum();
        let sure = smallest_sure(tied.iter().map(|cause| cause.probability), all);
        let likelier = causes.iter().take_while(|cause| cause.id != named);
        let others = likelier.chain(tied[..sure].iter().copied()).map(|cause| cause.id.clone());
        let others: BTreeSet<String> = others.filter(|id| *id != named).collect();
        let is_kept = |rival: &Rival| rival.candidate.id == named || others.contains(&rival.candidate.id);
        self.ties.iter_mut().for_each(|tie| tie.retain(is_kept));
        if others.is_empty() {
            self.verdict = Verdict::Named;
            self.ties.clear();
        } else {
            self.verdict = Verdict::Ambiguous;
        }
        self.ambiguous_with = others.into_iter().collect();
        let cause = causes.iter().find(|cause| cause.id == named);
        let predictive = cause.and_then(|cause| weighed.predictive(cause));
        Self { likelihood: Some(Likelihood { posterior: weighed.posterior, predictive }), ..self }
    }

    /// The names but one, as all field runs have them; `None` where one of these begins at times of
    /// its own, which are known of the open runs only.
    fn known_beside(&self, place: usize) -> Option<Vec<Known>> {
        let everywhere = |regressor: &Regressor| match regressor {
            Regressor::Mass(run) => Some(Regressor::Mass(*self.split.open.get(*run)?)),
            Regressor::InRun(run, term) => Some(Regressor::InRun(*self.split.open.get(*run)?, *term)),
            Regressor::Switch(..) => None,
            other => Some(other.clone()),
        };
        let others = self.effects.iter().enumerate().filter(|(other, _)| *other != place);
        let known = others.map(|(_, named)| {
            let regressors = named.candidate.regressors.iter().map(everywhere).collect::<Option<_>>()?;
            Some((Candidate { regressors, ..named.candidate.clone() }, named.coefficients.clone()))
        });
        known.collect()
    }
}
