//! What rules found, weighed by the likelihood: is a gap without a name more than relabelled runs
//! show, and how probable is each rival of a tie?
//!
//! A name is confirmed on the locked runs. A gap without one has no such check, so labels give it
//! one: an exact one, where drives are alike.

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};

use super::likelihood::posterior::smallest_sure;
use super::likelihood::products::Posed;
use super::likelihood::question::Question;
use super::likelihood::round::Asked;
use super::likelihood::scored::Scales;
use super::likelihood::ways::Way;
use super::likelihood::{Gate, bagged, relinearise};
use super::report::{Report, Rival};
use residuals::types::{Base, Options, Verdict};

impl Report {
    /// Takes back a gap that relabelled runs show as well, and strikes rivals that are improbable.
    #[must_use]
    pub fn weighed(self, runs: &Runs, clean: &Runs, base: &Base, options: &Options, level: f64) -> Self {
        let weigh = match self.verdict {
            Verdict::Unexplained => Self::held_to_labels,
            Verdict::Ambiguous => Self::with_probabilities,
            Verdict::None | Verdict::Named => return self,
        };
        let question = Question::of(runs, Some(clean), base, options);
        weigh(self, &question.asked(base, options, level))
    }

    fn held_to_labels(mut self, asked: &Asked<'_>) -> Self {
        let gate = |(posed, scales)| Gate::of(&posed, &[], &scales, asked.level);
        match posed(asked).and_then(gate) {
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

    /// Strikes the rivals that are not in the smallest sure set; the name stays.
    fn with_probabilities(mut self, asked: &Asked<'_>) -> Self {
        let ([named], [tie]) = (&self.effects[..], &self.ties[..]) else { return self };
        let Ok((posed, scales)) = posed(asked) else { return self };
        let Some(probable) = probabilities(tie, &posed, &scales) else { return self };
        let sure = smallest_sure(probable.iter().map(|(_, share)| *share), 1.0);
        let kept = probable[..sure].iter().map(|(id, _)| id).chain([&named.candidate.id]);
        let kept: Vec<&String> = kept.collect();
        self.ambiguous_with.retain(|id| kept.contains(&id));
        self.ties[0].retain(|rival| kept.contains(&&rival.candidate.id));
        if self.ambiguous_with.is_empty() {
            self.verdict = Verdict::Named;
            self.ties.clear();
        }
        self.rivals = probable;
        self
    }
}

fn posed<'a>(asked: &Asked<'a>) -> Result<(Posed<'a>, Scales), String> {
    let posed = asked.posed(&[]).ok_or("too few steady rows tell the noise of the power")?;
    let scales = Scales::told(&posed).ok_or("sums of products are no numbers")?;
    Ok((posed, scales))
}

/// Of each cause of a tie, the likeliest first; `None` where one of them lives in single runs,
/// which have no evidence of all.
fn probabilities(tie: &[Rival], posed: &Posed<'_>, scales: &Scales) -> Option<Vec<(String, f64)>> {
    let bent = |rival: &Rival| {
        let Rival { candidate, state } = rival;
        let of_it = |(regressor, _): &&(Regressor, f64)| candidate.regressors.contains(regressor);
        let start: Vec<f64> = state.effects.iter().filter(of_it).map(|(_, size)| *size).collect();
        let way = Way::about(posed, candidate, &start);
        (!is_of_single_runs(candidate)).then(|| relinearise::about(posed, scales, &way, &start))?
    };
    let bent: Vec<_> = tie.iter().map(bent).collect::<Option<_>>()?;
    let causes: Vec<(f64, &[f64])> = bent.iter().map(|bent| (bent.evidence, &bent.by_run[..])).collect();
    let mut probable: Vec<(String, f64)> = Vec::new();
    for (rival, share) in tie.iter().zip(bagged::shares(&causes)) {
        match probable.iter_mut().find(|(id, _)| *id == rival.candidate.id) {
            Some((_, sum)) => *sum += share,
            None => probable.push((rival.candidate.id.clone(), share)),
        }
    }
    probable.sort_by(|a, b| b.1.total_cmp(&a.1));
    Some(probable)
}

fn is_of_single_runs(candidate: &Candidate) -> bool {
    let of_single =
        |regressor: &Regressor| regressor.run().is_some() || matches!(regressor, Regressor::Switch(..));
    candidate.regressors.iter().any(of_single)
}
