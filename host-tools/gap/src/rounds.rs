//! Rounds over the open runs: name an effect, ask again for those named before it, and so on until
//! nothing stands out.

use model::effects::{Candidate, Regressor};
use residuals::detect::{Structure, structure};
use residuals::name::hypothesis::Hypothesis;
use residuals::name::{Choice, Naming, name};
use residuals::predictor::State;
use residuals::problem::Problem;
use residuals::problem::fit::Fitted;
use residuals::thresholds::detect::{INEXACT, NOTHING_LEFT};
use residuals::thresholds::name::{CHANCE, LEAST_FURTHER, MOST_ASKED};
use residuals::thresholds::problem::MOST_FIT_STEPS;
use residuals::types::{Options, Round, Standing, Status, Verdict};

/// What is known of an effect that was named, χ².
#[derive(Debug, Clone, Copy)]
struct Asked {
    /// What it gained when it was asked last, the others being known.
    gain: f64,
    /// What the search for it costs.
    price: f64,
}

/// What became of an effect that was asked for again.
enum Again {
    Stays,
    IsAnother,
    IsNotNeeded,
}

/// An effect that was taken out to be asked for again.
struct Taken {
    hypothesis: Hypothesis,
    /// Loss with it, and what the search for it costs.
    least: f64,
    gain: f64,
    /// The fit of all others.
    without: Fitted,
    /// The tie that it began.
    tie: Option<Vec<Hypothesis>>,
}

/// The result of the rounds over the open runs.
pub(crate) struct Findings {
    pub(crate) verdict: Verdict,
    pub(crate) state: State,
    pub(crate) named: Vec<Candidate>,
    /// The faintest of what was found.
    pub(crate) standing: Standing,
    /// What each gained when it was asked last, and what its search costs, χ².
    asked: Vec<Asked>,
    pub(crate) fitted: Option<Fitted>,
    /// Ids of hypotheses that explain as much as what was named.
    pub(crate) ambiguous: Vec<String>,
    pub(crate) ties: Vec<Vec<Hypothesis>>,
    pub(crate) rounds: Vec<Round>,
}

/// Round after round: is there structure, and what explains it? `by_noise`: the greatest |z| of
/// noise alone.
pub(crate) fn search(
    problem: &Problem<'_>,
    list: &[Candidate],
    by_noise: f64,
    options: &Options,
) -> Findings {
    let mut findings = Findings {
        verdict: Verdict::None,
        state: problem.start(),
        named: Vec::new(),
        standing: Standing::Clear,
        asked: Vec::new(),
        fitted: None,
        ambiguous: Vec::new(),
        ties: Vec::new(),
        rounds: Vec::new(),
    };
    let question = Question { problem, list, options };
    let (mut gained, mut mops_up) = (0.0, false);
    let mut left_to_name = MOST_ASKED * options.most_effects;
    while findings.named.len() <= options.most_effects {
        let left = question.of(&findings.state, &findings.named, gained);
        let greatest = left.structure.greatest;
        // What gained next to nothing may mop up after a wrong name, unless nothing at all is left.
        let is_enough = left.is_explained() && (!mops_up || greatest <= NOTHING_LEFT);
        // What noise or clean runs may show as well may have a name all the same.
        if is_enough && findings.named.is_empty() && greatest > NOTHING_LEFT {
            findings.standing = Standing::WithinClean;
        } else if is_enough {
            let outcome = if greatest <= by_noise {
                "no structure beyond the noise"
            } else {
                "no structure beyond what clean runs show of each other, or what was named leaves"
            };
            findings.rounds.push(left.into_round(outcome.to_owned()));
            break;
        }
        let room = !mops_up && findings.named.len() < options.most_effects && left_to_name > 0;
        let round = question.name(left, &findings.state, &findings.named);
        findings.rounds.push(round.record);
        match round.choice {
            Some(choice) if room => {
                left_to_name -= 1;
                gained += choice.gain;
                findings.add(choice);
                gained = findings.ask_again(&question, gained);
                mops_up = findings.asked.iter().any(|asked| asked.gain < LEAST_FURTHER * gained);
            }
            _ => {
                findings.verdict = Verdict::Unexplained;
                break;
            }
        }
    }
    findings.settle();
    findings
}

/// What every round asks.
struct Question<'a> {
    problem: &'a Problem<'a>,
    list: &'a [Candidate],
    options: &'a Options,
}

/// What a state leaves.
struct Left {
    structure: Structure,
    /// Greatest |z| that is no structure.
    allowed: f64,
}

impl Left {
    fn is_explained(&self) -> bool {
        self.structure.greatest <= self.allowed
    }

    fn into_round(self, outcome: String) -> Round {
        let Self { structure: Structure { greatest, scored, .. }, allowed } = self;
        Round { structure: greatest, allowed, candidates: scored, outcome }
    }
}

impl Question<'_> {
    /// Of a state with these names, which gained so much.
    fn of(&self, state: &State, named: &[Candidate], gained: f64) -> Left {
        Left {
            structure: structure(self.problem, state, self.list, named),
            allowed: (self.options.threshold.powi(2) + INEXACT * gained).sqrt(),
        }
    }

    fn name(&self, left: Left, state: &State, named: &[Candidate]) -> Naming {
        name(self.problem, state, self.list, named, left.structure, left.allowed, self.options)
    }
}

impl Findings {
    /// Whether all named effects are of single runs: no locked run has them.
    pub(crate) fn lives_in_single_runs(&self) -> bool {
        self.state.effects.iter().all(|(regressor, _)| regressor.run().is_some())
    }

    /// The fitted delay of the power, s.
    pub(crate) fn delay(&self) -> Option<f64> {
        let mut effects = self.state.effects.iter();
        effects.find(|(regressor, _)| *regressor == Regressor::Delay).map(|(_, delay)| *delay)
    }

    fn add(&mut self, choice: Choice) {
        if !choice.ties.is_empty() {
            let winner = choice.hypothesis.candidate.id.clone();
            let tied = |hypothesis: &Hypothesis| {
                hypothesis.candidate.id == winner || choice.ties.contains(&hypothesis.candidate.id)
            };
            let others = choice.others.into_iter().filter(tied);
            self.ties.push([choice.hypothesis.clone()].into_iter().chain(others).collect());
        }
        self.ambiguous.extend(choice.ties);
        if !choice.stands_out {
            self.standing = self.standing.max(Standing::Faint);
        }
        self.take(choice.hypothesis, choice.gain);
    }

    /// Forgets all names.
    pub(crate) fn forget(&mut self, start: State) {
        (self.named, self.asked, self.ties) = (Vec::new(), Vec::new(), Vec::new());
        (self.state, self.fitted) = (start, None);
    }

    /// Names an effect.
    fn take(&mut self, hypothesis: Hypothesis, gain: f64) {
        let Hypothesis { candidate, fitted, penalised } = hypothesis;
        self.asked.push(Asked { gain, price: penalised - fitted.loss });
        self.named.push(candidate);
        self.state = fitted.state.clone();
        self.fitted = Some(fitted);
        self.verdict = if self.ambiguous.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
    }

    /// Asks for each effect again, the others being known: what was named alone made up for them.
    /// Another one takes its place where the loss is less with it; one that is not needed any more
    /// goes. `gained`: by all. Returns what all gain afterwards.
    fn ask_again(&mut self, question: &Question<'_>, gained: f64) -> f64 {
        let before = self.loss();
        let gained_now = |findings: &Self| gained + before - findings.loss();
        // The last one was asked with all others known.
        let mut confirmed = 1;
        for _ in 0..MOST_ASKED * self.named.len() {
            if confirmed >= self.named.len() {
                break;
            }
            let gained = gained_now(self);
            let Some(first) = self.take_first(question.problem) else { return gained };
            confirmed = match self.ask(question, first, gained) {
                Again::Stays => confirmed + 1,
                Again::IsAnother => 1,
                // The others explain all that is there: nothing is asked of them.
                Again::IsNotNeeded => return gained_now(self),
            };
        }
        // Each that stayed has gone to the end: one more, and they are in the order of the rounds.
        if confirmed > 1
            && let Some(first) = self.take_first(question.problem)
        {
            self.give_back(first);
        }
        gained_now(self)
    }

    /// Takes the effect out that was named first; `None` where the rest cannot be fitted.
    fn take_first(&mut self, problem: &Problem<'_>) -> Option<Taken> {
        let mut others = self.state.clone();
        let own: Vec<(Regressor, f64)> =
            others.effects.drain(..self.named.first()?.regressors.len()).collect();
        let without = problem.fit(&others, &[], MOST_FIT_STEPS)?;
        let fitted = problem.fit(&without.state, &own, MOST_FIT_STEPS)?;
        let (candidate, asked) = (self.named.remove(0), self.asked.remove(0));
        let tie = self.ties.iter().position(|tie| tie[0].candidate == candidate);
        let tie = tie.map(|place| self.ties.remove(place));
        let (penalised, least) = (fitted.loss + asked.price, fitted.loss.min(self.loss()) + asked.price);
        Some(Taken {
            hypothesis: Hypothesis { candidate, fitted, penalised },
            least,
            gain: asked.gain,
            without,
            tie,
        })
    }

    /// Puts an effect back, as the last one.
    fn give_back(&mut self, taken: Taken) {
        let Taken { hypothesis, gain, tie, .. } = taken;
        self.ties.extend(tie);
        self.take(hypothesis, gain);
    }

    /// Asks for an effect again.
    fn ask(&mut self, question: &Question<'_>, taken: Taken, gained: f64) -> Again {
        let Taken { hypothesis: old, without, .. } = &taken;
        // A delay is a nuisance of the base.
        if old.candidate.regressors == [Regressor::Delay] {
            self.give_back(taken);
            return Again::Stays;
        }
        let by_others = (gained - (without.loss - old.fitted.loss)).max(0.0);
        let left = question.of(&without.state, &self.named, by_others);
        if left.is_explained() {
            self.take_name_back(&old.candidate.id);
            self.rounds.push(left.into_round(format!("{} is not needed any more", old.candidate.id)));
            self.state = without.state.clone();
            self.fitted = Some(taken.without);
            self.doubt_what_is_tied();
            return Again::IsNotNeeded;
        }
        let Naming { choice, record } = question.name(left, &without.state, &self.named);
        match choice {
            Some(choice) if choice.hypothesis.candidate.id == old.candidate.id => {
                // Its tie is judged anew; of its ways the better one stays.
                let is_better = choice.hypothesis.penalised < old.penalised;
                let hypothesis = if is_better { choice.hypothesis } else { taken.hypothesis };
                self.add(Choice { hypothesis, ..choice });
            }
            Some(choice) if choice.hypothesis.penalised + CHANCE < taken.least => {
                self.take_name_back(&old.candidate.id);
                let outcome = format!("{} asked again: {}", old.candidate.id, record.outcome);
                self.rounds.push(Round { outcome, ..record });
                self.add(choice);
                self.doubt_what_is_tied();
                return Again::IsAnother;
            }
            _ => self.give_back(taken),
        }
        self.doubt_what_is_tied();
        Again::Stays
    }

    /// Loss of the fit, χ².
    fn loss(&self) -> f64 {
        self.fitted.as_ref().map_or(f64::INFINITY, |fitted| fitted.loss)
    }

    /// It won a round, and is named no longer.
    fn take_name_back(&mut self, id: &str) {
        let scored = self.rounds.iter_mut().flat_map(|round| &mut round.candidates);
        for scored in scored.filter(|scored| scored.id == id && scored.status == Status::Winner) {
            scored.status = Status::Worse;
        }
    }

    /// What is in doubt is in a tie that is left.
    fn doubt_what_is_tied(&mut self) {
        let rivals = self.ties.iter().flat_map(|tie| &tie[1..]);
        self.ambiguous = rivals.map(|rival| rival.candidate.id.clone()).collect();
        self.verdict = if self.ambiguous.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
    }

    /// Adds to the tie what the names may stand for as well.
    pub(crate) fn doubt(&mut self, others: Vec<String>) {
        if self.verdict.stands() && !others.is_empty() {
            self.ambiguous.extend(others);
            self.verdict = Verdict::Ambiguous;
            self.settle();
        }
    }

    /// A rival that a later round named is in doubt no longer.
    fn settle(&mut self) {
        self.ambiguous.retain(|id| self.named.iter().all(|candidate| candidate.id != *id));
        self.ambiguous.sort();
        self.ambiguous.dedup();
        if self.verdict == Verdict::Ambiguous && self.ambiguous.is_empty() {
            self.verdict = Verdict::Named;
        }
    }
}

#[cfg(test)]
mod tests {
    use logs::robot::Robot;

    use crate::bench::{Case, one, sets::noises, typical};

    /// More viscous friction explains more than either of air drag and rolling resistance; with it
    /// named, the other two are not found.
    #[test]
    fn two_effects_are_named_where_a_third_explains_more_than_either() {
        let both = ["windage", "rolling-resistance-change"];
        let mut effects = typical().unwrap();
        effects.retain(|effect| both.contains(&effect.id()));
        let case = Case { effects, size: 1.0, seed: 927, noise: noises()[0], removed: Vec::new() };
        let mut named = one(&Robot::named("burger").unwrap(), &case).unwrap().named;
        named.sort();
        assert_eq!(named, ["rolling-resistance-change", "windage"]);
    }
}
