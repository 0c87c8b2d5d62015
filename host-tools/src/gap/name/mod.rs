//! One round: who explains most of what is left, and is it the only one?

pub mod hypothesis;

use self::hypothesis::{
    Hypothesis, disagree, fit_hypothesis, implausible_and_better, is_tie, sharpen, shows_no_shape, tie_width,
};
use super::detect::Structure;
use super::problem::Problem;
use super::thresholds::name::{REFINED, REFINED_SHARE, WAYS};
use super::thresholds::problem::MOST_FIT_STEPS;
use super::twin::State;
use super::types::{Options, Round, Scored, Status};
use crate::effects::Candidate;
use rayon::prelude::*;

pub(super) struct Choice {
    pub(super) hypothesis: Hypothesis,
    pub(super) gain: f64,
    pub(super) ties: Vec<String>,
    /// All other fits that are not much worse, in several ways of one effect also.
    pub(super) others: Vec<Hypothesis>,
}

pub(super) struct Naming {
    pub(super) choice: Option<Choice>,
    pub(super) record: Round,
}

pub(super) fn name<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    list: &[Candidate],
    named: &[Candidate],
    structure: Structure,
    allowed: f64,
    options: &Options,
) -> Naming {
    let mut record = Round {
        structure: structure.greatest,
        allowed,
        candidates: structure.scored,
        outcome: String::new(),
    };
    let Some(null) = problem.fit(state, &[], MOST_FIT_STEPS) else {
        record.outcome = "the base cannot be solved for".to_owned();
        return Naming { choice: None, record };
    };
    let most = structure.order.first().map_or(0.0, |(_, gain)| *gain);
    let close = |(rank, (_, gain)): &(usize, &(usize, f64))| {
        *gain > 0.0 && (*rank < REFINED || *gain > REFINED_SHARE * most)
    };
    let chosen = structure.order.iter().enumerate().filter(close).map(|(_, (place, _))| &list[*place]);
    let further = structure.further.iter().filter(|candidate| !options.removed.contains(&candidate.id));
    let all: Vec<&Candidate> = chosen.chain(further).collect();
    let mut hypotheses: Vec<Hypothesis> = all
        .par_iter()
        .map(|candidate| fit_hypothesis(problem, state, candidate))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();
    let reduced = hypotheses.iter().filter_map(|own| own.without_implausible_runs(problem, state));
    let reduced: Vec<Hypothesis> = reduced.collect();
    hypotheses.extend(reduced);
    hypotheses.sort_by(|a, b| a.penalised.total_cmp(&b.penalised));
    sharpen(problem, state, &mut hypotheses);
    record.candidates = hypotheses
        .iter()
        .map(|hypothesis| Scored {
            id: hypothesis.candidate.id.clone(),
            detail: hypothesis.candidate.detail.clone(),
            gain: null.loss - hypothesis.penalised,
            coefficients: hypothesis.coefficients(),
            status: if hypothesis.is_plausible() { Status::Worse } else { Status::Implausible },
        })
        .chain(record.candidates.into_iter().filter(|scored| scored.status == Status::Unidentifiable))
        .collect();
    let plausible: Vec<usize> =
        (0..hypotheses.len()).filter(|&place| hypotheses[place].is_plausible()).collect();
    let refuse = |mut record: Round, why: &str| {
        record.outcome = why.to_owned();
        Naming { choice: None, record }
    };
    let better = implausible_and_better(&hypotheses, null.loss);
    let Some(&first) = plausible.first() else {
        return refuse(record, "no candidate has a plausible sign and size");
    };
    let winner = hypotheses[first].clone();
    let gain = null.loss - winner.penalised;
    let inflation = problem.variance_inflation(state, &winner.candidate.regressors, &winner.fitted.state);
    if (null.loss - winner.fitted.loss) / inflation - problem.price(&winner.candidate)
        < options.threshold.powi(2)
    {
        return refuse(record, "what explains most does not stand out of the noise");
    }
    // The truth is then none of these, or the robot is none that its file describes: the next best name would be a wrong one.
    if let Some(better) = better {
        let why = format!("{} explains most, with no plausible sign or size", better.candidate.id);
        return refuse(record, &why);
    }
    let width = tie_width(gain, disagree(problem, &winner), problem.misfit);
    let mut ties = Vec::new();
    for &place in &plausible[1..] {
        let hypothesis = &hypotheses[place];
        if hypothesis.candidate.id == winner.candidate.id
            || named.iter().any(|own| own.id == hypothesis.candidate.id)
        {
            continue;
        }
        if is_tie(&winner, hypothesis, width) && null.loss - hypothesis.penalised > 0.0 {
            ties.push(hypothesis.candidate.id.clone());
            record.candidates[place].status = Status::Tie;
        }
    }
    if shows_no_shape(problem, state, &winner, width) && ties.is_empty() {
        return refuse(record, "of what explains most the runs show the limit only, which is another effect");
    }
    // The winner, or one of its ties, has to win again with each run left out. Where the winner lives in single runs there may then be
    // nothing left to be won: who beats it there has to stand out of the noise.
    let in_single_runs = winner.candidate.regressors.iter().all(|regressor| regressor.run().is_some());
    let runs = problem.twin.runs.runs.iter().filter(|run| !run.clean).count();
    let mut lost = 0;
    for run in 0..runs {
        let best = plausible
            .iter()
            .map(|&place| &hypotheses[place])
            .map(|hypothesis| {
                (
                    hypothesis,
                    problem.loss_without(&hypothesis.fitted, run)
                        + problem.price_without(&hypothesis.candidate, run),
                )
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((hypothesis, loss)) = best
            && hypothesis.candidate.id != winner.candidate.id
            && !ties.contains(&hypothesis.candidate.id)
            && (!in_single_runs || problem.loss_without(&null, run) - loss >= options.threshold.powi(2))
        {
            lost += 1;
            ties.push(hypothesis.candidate.id.clone());
        }
    }
    ties.sort();
    ties.dedup();
    record.candidates[first].status = Status::Winner;
    record.outcome = match (ties.is_empty(), lost) {
        (true, _) => format!("added {}", winner.candidate.id),
        (false, 0) => format!("added {}, in a tie with {}", winner.candidate.id, ties.join(", ")),
        (false, _) => {
            format!("added {}, which some runs alone decide against {}", winner.candidate.id, ties.join(", "))
        }
    };
    let close = |hypothesis: &&Hypothesis| hypothesis.penalised < winner.penalised + WAYS;
    let others = plausible.iter().filter(|&&place| place != first).map(|&place| &hypotheses[place]);
    let others = others.filter(close).cloned().collect();
    Naming { choice: Some(Choice { hypothesis: winner, gain, ties, others }), record }
}
