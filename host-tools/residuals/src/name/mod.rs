//! One round: which hypothesis explains most of the residual, and is it the only one?

pub mod hypothesis;

use model::effects::Candidate;

use self::hypothesis::{
    Hypothesis, as_good, disagree, fit_hypothesis, implausible_and_better, sharpen, shows_no_shape, tie_width,
};
use super::detect::Structure;
use super::predictor::State;
use super::problem::Problem;
use super::thresholds::problem::MOST_FIT_STEPS;
use super::types::{Options, Round, Scored, Status};
use rayon::prelude::*;

pub struct Choice {
    pub hypothesis: Hypothesis,
    pub gain: f64,
    /// Whether it is beyond what noise, clean runs and the search for it show.
    pub stands_out: bool,
    pub ties: Vec<String>,
    /// The best other fit of each effect, and all fits that are not much worse, also of one effect.
    pub others: Vec<Hypothesis>,
}

pub struct Naming {
    pub choice: Option<Choice>,
    pub record: Round,
}

pub fn name(
    problem: &Problem<'_>,
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
    let chosen = structure.order.iter().filter(|(_, gain)| *gain > 0.0).map(|(place, _)| &list[*place]);
    let further = structure.further.iter().filter(|candidate| !options.removed.contains(&candidate.id));
    let all: Vec<&Candidate> = chosen.chain(further).collect();
    let mut hypotheses: Vec<Hypothesis> = all
        .par_iter()
        .map(|candidate| fit_hypothesis(problem, state, candidate))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();
    let reduced: Vec<Hypothesis> =
        hypotheses.iter().filter_map(|whole| whole.without_implausible_runs(problem, state)).collect();
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
    let agreed = (null.loss - winner.fitted.loss) / inflation - problem.price(&winner.candidate);
    if agreed <= 0.0 {
        return refuse(record, "what explains most gains less than the search for it costs");
    }
    // The true effect is then none of these, or the robot's file is wrong: so would be the next
    // name.
    if let Some(better) = better {
        let why = format!("{} explains most, with no plausible sign or size", better.candidate.id);
        return refuse(record, &why);
    }
    let rivals: Vec<&Hypothesis> = plausible[1..]
        .iter()
        .map(|&place| &hypotheses[place])
        .filter(|rival| named.iter().all(|named| named.id != rival.candidate.id))
        .collect();
    let width = tie_width(gain, disagree(problem, &winner), problem.misfit);
    let as_good = as_good(&null, &winner, &rivals, width);
    for (place, hypothesis) in hypotheses.iter().enumerate() {
        if as_good.iter().any(|tied| tied.candidate == hypothesis.candidate) {
            record.candidates[place].status = Status::Tie;
        }
    }
    if as_good.is_empty() && shows_no_shape(problem, state, &winner, width) {
        return refuse(record, "of what explains most the runs show the limit only, which is another effect");
    }
    let mut ties: Vec<String> = as_good.iter().map(|tied| tied.candidate.id.clone()).collect();
    ties.sort();
    ties.dedup();
    record.candidates[first].status = Status::Winner;
    record.outcome = if ties.is_empty() {
        format!("added {}", winner.candidate.id)
    } else {
        format!("added {}, in a tie with {}", winner.candidate.id, ties.join(", "))
    };
    let mut seen: Vec<String> = Vec::new();
    let worth_asking = |other: &&Hypothesis| {
        let is_best = !seen.contains(&other.candidate.id);
        seen.push(other.candidate.id.clone());
        is_best || other.penalised < winner.penalised + width
    };
    let others = plausible.iter().filter(|&&place| place != first).map(|&place| &hypotheses[place]);
    let others = others.filter(worth_asking).cloned().collect();
    Naming {
        choice: Some(Choice {
            hypothesis: winner,
            gain,
            stands_out: agreed >= options.threshold.powi(2),
            ties,
            others,
        }),
        record,
    }
}
