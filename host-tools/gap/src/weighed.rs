//! What rules found, weighed by the likelihood: is a gap without a name more than relabelled runs
//! show, and is a name probable among the listed effects?
//!
//! Rules name what explains most, and the locked runs confirm that it is there in part. The
//! likelihood knows what the form may get wrong: a name that it ranks far behind another is none.

use std::collections::BTreeSet;

use logs::runs::Runs;
use model::effects::Regressor;
use support::error::Result;

use super::clean_base;
use super::investigate;
use super::likelihood::Gate;
use super::likelihood::asked::{Asked, Known};
use super::likelihood::posterior::smallest_sure;
use super::likelihood::priors::SURE;
use super::likelihood::question::Question;
use super::likelihood::scored::Scales;
use super::report::{Report, Rival};
use residuals::types::{Base, Named, Options, Standing, Verdict};

/// Probabilities below this share are not said. Layout: no verdict depends on it.
const LEAST_SAID: f64 = 0.01;

/// Analyses what field runs have that clean ones lack. `level` is that of the gate: how often a gap
/// may be reported of runs without any.
///
/// # Errors
/// Too few runs.
pub fn investigate(
    runs: &Runs,
    clean: Option<&Runs>,
    base: &Base,
    options: &Options,
    level: f64,
) -> Result<Report> {
    let given = base.torque;
    let Some(clean) = clean else {
        return Ok(investigate::investigate(runs, None, base, options)?.without_faint_names());
    };
    let base = &Base { torque: clean_base::fitted(clean, base), ..base.clone() };
    let report = investigate::investigate(runs, Some(clean), base, options)?;
    // A simulator's runs and measured ones cannot change places.
    let report = if base.of_simulator {
        report.without_faint_names()
    } else {
        report.weighed(runs, clean, base, options, level)
    };
    Ok(report.about(given))
}

impl Report {
    /// Takes back what relabelled runs show as well, unless it stands out, and names that are
    /// improbable.
    #[must_use]
    pub fn weighed(self, runs: &Runs, clean: &Runs, base: &Base, options: &Options, level: f64) -> Self {
        if self.verdict == Verdict::None {
            return self;
        }
        let question = Question::of(runs, clean, base, options);
        let asked = question.asked(base, level);
        let is_sure = self.verdict.stands() && self.standing == Standing::Clear;
        let report = if is_sure { self } else { self.held_to_labels(&asked) };
        if report.verdict.stands() { report.held_to_probabilities(&asked) } else { report }
    }

    /// Where no labels say whether there is a gap, names need to stand out.
    fn without_faint_names(self) -> Self {
        let is_faint = self.verdict.stands() && self.standing != Standing::Clear;
        let verdict = self.standing.without_a_name();
        if is_faint { self.without_names(verdict) } else { self }
    }

    fn held_to_labels(mut self, asked: &Asked<'_>) -> Self {
        let posed = asked.posed(&[]).ok_or("too few steady rows tell the noise of the power".to_owned());
        let gate = posed.and_then(|posed| {
            let scales = Scales::told(&posed).ok_or("sums of products are no numbers")?;
            Gate::of(&posed, &scales, asked.level)
        });
        match gate {
            Ok(gate) => {
                let verdict = if gate.is_shut() { Verdict::None } else { self.verdict };
                let held = if verdict.stands() { self } else { self.without_names(verdict) };
                Self { relabelled: Some(gate), ..held }
            }
            Err(why) => {
                let note = format!("{why}: whether relabelled runs would show as much was not asked");
                self.notes.push(note);
                self.without_faint_names()
            }
        }
    }

    /// Weighs each name, the others being known.
    fn held_to_probabilities(self, asked: &Asked<'_>) -> Self {
        let of = |named: &Named| (named.candidate.clone(), named.coefficients.clone());
        let known: Vec<Known> = self.effects.iter().map(of).collect();
        // Places of runs are those of the open ones; here all take part.
        let is_of_runs =
            |regressor: &Regressor| regressor.run().is_some() || matches!(regressor, Regressor::Switch(..));
        let has_runs = |(candidate, _): &Known| candidate.regressors.iter().any(is_of_runs);
        let tied: Vec<Vec<String>> = known.iter().map(|(named, _)| self.tied_with(&named.id)).collect();
        tied.iter().enumerate().fold(self, |report, (place, tied)| {
            let mut others = known.clone();
            let (named, _) = others.remove(place);
            if !report.verdict.stands() || others.iter().any(has_runs) {
                return report;
            }
            match asked.among_effects(&others) {
                Some(shares) => report.held_to(&named.id, tied, &shares),
                None => report,
            }
        })
    }

    /// What the rules doubt this name for: its tie, and what no tie has.
    fn tied_with(&self, named: &str) -> Vec<String> {
        let is_of_another = |id: &String| {
            let mut others = self.ties.iter().filter(|tie| !begins(tie, named)).flatten();
            others.any(|rival| rival.candidate.id == *id)
        };
        self.ambiguous_with.iter().filter(|id| !is_of_another(id)).cloned().collect()
    }

    /// Takes the names back if this one is improbable among the listed effects, with all that it
    /// ties with. Of its tie, strikes the rivals that are outside the smallest sure set; an effect
    /// that is likelier than the name joins it. Whether it is something else is for the rules to say: a
    /// measured robot always has something else, too. `tied_with`: what the rules doubt it for.
    /// `shares`: ids and probabilities, the likeliest first.
    fn held_to(mut self, named: &str, tied_with: &[String], shares: &[(String, f64)]) -> Self {
        let Some(place) = shares.iter().position(|(id, _)| id == named) else { return self };
        let is_in = |id: &str, own: bool| {
            let mut ties = self.ties.iter().filter(|tie| begins(tie, named) == own).flatten();
            ties.any(|rival| rival.candidate.id == id)
        };
        let is_tied = |id: &String| id == named || tied_with.contains(id);
        let tied: Vec<&(String, f64)> = shares.iter().filter(|(id, _)| is_tied(id)).collect();
        let all: f64 = tied.iter().map(|(_, share)| share).sum();
        let said = shares.iter().filter(|(_, share)| *share >= LEAST_SAID).cloned();
        if all < 1.0 - SURE {
            let verdict = self.standing.without_a_name();
            return Self { rivals: said.collect(), ..self.without_names(verdict) };
        }
        let sure = smallest_sure(tied.iter().map(|(_, share)| *share), all);
        let kept = shares[..place].iter().chain(tied[..sure].iter().copied()).map(|(id, _)| id);
        // What one mass cannot tell apart is in doubt without a tie, as is what joined another name.
        let doubted = self.ambiguous_with.iter().filter(|id| is_in(id, false) || !is_in(id, true));
        let others: BTreeSet<String> = kept.chain(doubted).filter(|id| *id != named).cloned().collect();
        let is_kept = |rival: &Rival| rival.candidate.id == named || others.contains(&rival.candidate.id);
        self.ties.iter_mut().filter(|tie| begins(tie, named)).for_each(|tie| tie.retain(is_kept));
        // Beside others only the name's own: each is asked among other effects.
        let is_alone = self.effects.len() == 1;
        self.rivals.extend(said.filter(|(id, _)| is_alone || id == named));
        self.verdict = if others.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
        if others.is_empty() {
            self.ties.clear();
        }
        Self { ambiguous_with: others.into_iter().collect(), ..self }
    }
}

/// Whether a tie is that of this name.
fn begins(tie: &[Rival], named: &str) -> bool {
    tie.first().is_some_and(|first| first.candidate.id == named)
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
        let shares: Vec<_> = shares.iter().map(|&(id, share)| (id.to_owned(), share)).collect();
        let tied = report.tied_with("grade");
        let held = report.held_to("grade", &tied, &shares);
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

    /// What is likelier than the first name has to be in the first one's tie: it is no reason to
    /// keep the second.
    #[test]
    fn what_joined_another_name_keeps_none() {
        let mut report = report(Verdict::Named);
        report.effects.truncate(2);
        let tied = ["grade", "viscous-change"].map(|name| report.tied_with(name));
        let shares =
            |name: &str, share: f64| vec![("windage".to_owned(), 1.0 - share), (name.to_owned(), share)];
        let joined = report.held_to("grade", &tied[0], &shares("grade", 0.4));
        assert_eq!(joined.ambiguous_with, ids(&["windage"]));
        let held = joined.held_to("viscous-change", &tied[1], &shares("viscous-change", 0.03));
        assert_eq!(held.verdict, Verdict::Unexplained);
    }

    /// No probability says more than the drives do.
    #[test]
    fn what_one_mass_cannot_tell_apart_stays_in_doubt() {
        let doubted = weighed(&["windage", "stribeck"], 1, &[("grade", 0.99), ("windage", 0.005)]);
        assert_eq!(doubted, (Verdict::Ambiguous, ids(&["stribeck"])));
    }
}
