//! A tie of the open runs, judged again with the locked ones.
//!
//! The open runs choose the winner. With the locked runs a rival may turn out worse: it is struck
//! from the tie. Nothing else is taken from the locked runs. If a rival is best with them, the tie
//! stays as it is.

use model::effects::Regressor;

use super::hypothesis::{Hypothesis, as_good, better_without_a_run, disagree, fit_hypothesis, tie_width};
use crate::predictor::State;
use crate::problem::Problem;
use crate::thresholds::problem::MOST_FIT_STEPS;

/// Ids of the rivals struck from a tie, which begins with the winner. `others`: the base and the
/// other effects named. `problem`: open runs, then locked ones, then clean ones.
pub fn struck(problem: &Problem<'_>, others: &State, tie: &[Hypothesis], threshold: f64) -> Vec<String> {
    let effects = others.effects.iter().map(|(regressor, _)| regressor);
    let Some((winner, rivals)) = tie.split_first().filter(|_| effects.clone().all(is_of_all_runs)) else {
        return Vec::new();
    };
    let is_askable = |hypothesis: &Hypothesis| hypothesis.candidate.regressors.iter().all(is_of_all_runs);
    if !is_askable(winner) {
        return Vec::new();
    }
    let winner_id = &winner.candidate.id;
    let ask = |hypothesis: &Hypothesis| fit_hypothesis(problem, others, &hypothesis.candidate);
    let (Some(null), Some(mut winner)) = (problem.fit(others, &[], MOST_FIT_STEPS), ask(winner)) else {
        return Vec::new();
    };
    let mut asked: Vec<Hypothesis> = Vec::new();
    let mut unasked: Vec<&str> = Vec::new();
    for rival in rivals {
        match is_askable(rival).then(|| ask(rival)).flatten() {
            // Another way of the winner's own effect.
            Some(refitted) if refitted.candidate.id == *winner_id => {
                if refitted.is_plausible() && refitted.penalised < winner.penalised {
                    winner = refitted;
                }
            }
            Some(refitted) => asked.push(refitted),
            None => unasked.push(&rival.candidate.id),
        }
    }
    let plausible: Vec<&Hypothesis> = asked.iter().filter(|rival| rival.is_plausible()).collect();
    if !winner.is_plausible() || plausible.iter().any(|rival| rival.penalised < winner.penalised) {
        return Vec::new();
    }
    let width = tie_width(null.loss - winner.penalised, disagree(problem, &winner), problem.misfit);
    let mut kept: Vec<String> =
        as_good(&null, &winner, &plausible, width).iter().map(|rival| rival.candidate.id.clone()).collect();
    let all: Vec<&Hypothesis> = std::iter::once(&winner).chain(plausible).collect();
    kept.extend(better_without_a_run(problem, &null, &winner, &all, &kept, threshold));
    let mut struck: Vec<String> = asked.into_iter().map(|rival| rival.candidate.id).collect();
    struck.retain(|id| !kept.contains(id) && !unasked.contains(&id.as_str()));
    struck.sort();
    struck.dedup();
    struck
}

/// Whether locked runs show it as open ones do: it is of no single run, and at no time of its own.
fn is_of_all_runs(regressor: &Regressor) -> bool {
    regressor.run().is_none() && !matches!(regressor, Regressor::Switch(..))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use model::effects::Switched;
    use model_core::effects::Term;
    use model_core::torque::{Drive, TorqueModel};

    use super::*;
    use crate::predictor::Predictor;
    use crate::problem::example;

    /// Base parameters that move along.
    const BASE: usize = 4;

    /// Power with 0.3 W more: friction at low speeds and at lower ones is struck from a tie with an
    /// offset, the same offset by another name and a step at times of its own stay. Where friction
    /// is said to have won nothing is struck.
    #[test]
    fn a_rival_is_struck_that_all_runs_together_say_is_worse() {
        let start = State {
            torque: TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]),
            effects: Vec::new(),
        };
        let offset = Regressor::Term(Term::Offset);
        let truth = State { effects: vec![(offset.clone(), 0.3)], ..start.clone() };
        let runs = example::runs([0.8, 0.3]);
        let runs = example::simulated(&runs, Drive::Regenerative, |_| truth.clone());
        let problem = example::bare(Predictor::new(&runs, Drive::Regenerative), start.torque, BASE);
        let candidate = |id: &str, regressor| example::candidate(id, vec![regressor], (-10.0, 10.0));
        let times: Arc<[f64]> = [10.0, 10.0].into();
        let fitted = [
            candidate("offset", offset.clone()),
            candidate("same", offset),
            candidate("friction", Regressor::Term(Term::Stribeck(1.0))),
            candidate("narrow", Regressor::Term(Term::Stribeck(0.05))),
            candidate("step", Regressor::Switch(Switched::Static, times)),
        ]
        .map(|candidate| fit_hypothesis(&problem, &start, &candidate).unwrap());
        assert_eq!(struck(&problem, &start, &fitted, 5.0), ["friction", "narrow"]);
        let [offset, same, friction, narrow, step] = fitted;
        assert!(struck(&problem, &start, &[friction, offset, same, narrow, step], 5.0).is_empty());
    }
}
