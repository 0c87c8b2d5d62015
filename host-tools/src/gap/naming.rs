//! One round: who explains most of what is left, and is it the only one?

use super::detect::Structure;
use super::inquiry::{Inquiry, Rival};
use super::investigate::{Options, Round, Scored};
use super::rivals::{TIE_LOSS, charge, charge_without, fit_rival, is_tie, sharpen, shows_no_shape};
use super::twin::State;
use crate::effects::Candidate;
use serde_json::Value;
use std::panic::resume_unwind;
use std::thread;

/// Candidates that are fitted with their non-linearity.
const REFINED: usize = 40;

/// Ways of a tied effect that are further behind than this in χ² are not to be parted by a manoeuvre: they are already.
const WAYS_LOSS: f64 = 25.0;

pub(super) struct Choice {
    pub(super) rival: Rival,
    pub(super) gain: f64,
    pub(super) ties: Vec<String>,
    /// All other fits that are not much worse, in several ways of one effect also.
    pub(super) others: Vec<Rival>,
}

pub(super) struct Naming {
    pub(super) choice: Option<Choice>,
    pub(super) record: Round,
}

pub(super) fn name<const N: usize>(
    inquiry: &Inquiry<'_, N>,
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
    let Some(null) = inquiry.fit(state, &[], 3) else {
        record.outcome = "the base cannot be solved for".to_owned();
        return Naming { choice: None, record };
    };
    let most = structure.order.first().map_or(0.0, |(_, gain)| *gain);
    let close =
        |(rank, (_, gain)): &(usize, &(usize, f64))| *gain > 0.0 && (*rank < REFINED || *gain > 0.6 * most);
    let chosen = structure.order.iter().enumerate().filter(close).map(|(_, (place, _))| &list[*place]);
    let further = structure.further.iter().filter(|candidate| !options.removed.contains(&candidate.id));
    let all: Vec<&Candidate> = chosen.chain(further).collect();
    let rival = |candidate: &Candidate| fit_rival(inquiry, state, candidate);
    let (left, right) = all.split_at(all.len() / 2);
    let mut rivals: Vec<Rival> = thread::scope(|scope| {
        let other = scope.spawn(|| left.iter().filter_map(|candidate| rival(candidate)).collect::<Vec<_>>());
        let own: Vec<Rival> = right.iter().filter_map(|candidate| rival(candidate)).collect();
        other.join().unwrap_or_else(|panic| resume_unwind(panic)).into_iter().chain(own).collect()
    });
    rivals.sort_by(|a, b| a.charged.total_cmp(&b.charged));
    sharpen(inquiry, state, &mut rivals);
    record.candidates = rivals
        .iter()
        .map(|rival| Scored {
            id: rival.candidate.id.clone(),
            detail: Value::Object(rival.candidate.detail.clone()),
            gain: null.loss - rival.charged,
            coefficients: rival.coefficients(),
            status: if rival.is_plausible() { "worse" } else { "implausible" },
        })
        .chain(record.candidates.into_iter().filter(|scored| scored.status == "unidentifiable here"))
        .collect();
    let plausible: Vec<usize> = (0..rivals.len()).filter(|&place| rivals[place].is_plausible()).collect();
    let refuse = |mut record: Round, why: &str| {
        record.outcome = why.to_owned();
        Naming { choice: None, record }
    };
    let Some(&first) = plausible.first() else {
        return refuse(record, "no candidate has a plausible sign and size");
    };
    let winner = rivals[first].clone();
    let gain = null.loss - winner.charged;
    let caution = inquiry.caution(state, &winner.candidate.regressors);
    if caution * (null.loss - winner.fitted.loss) - charge(&winner.candidate) < options.threshold.powi(2) {
        return refuse(record, "what explains most does not stand out of the noise");
    }
    // An implausible rival that explains much more says that the cause is none of these.
    if rivals[0].charged < winner.charged - 0.1 * gain - TIE_LOSS
        && rivals[0].candidate.id != winner.candidate.id
    {
        return refuse(record, "what explains most has no plausible sign or size");
    }
    let mut ties = Vec::new();
    for &place in &plausible[1..] {
        let rival = &rivals[place];
        if rival.candidate.id == winner.candidate.id || named.iter().any(|own| own.id == rival.candidate.id) {
            continue;
        }
        if is_tie(&winner, rival, gain) && null.loss - rival.charged > 0.0 {
            ties.push(rival.candidate.id.clone());
            record.candidates[place].status = "tie";
        }
    }
    if shows_no_shape(inquiry, state, &winner, gain) && ties.is_empty() {
        return refuse(record, "of what explains most the runs show the limit only, which is another effect");
    }
    // The winner, or one of its ties, has to win again with each run left out.
    let runs = inquiry.twin.runs.runs.iter().filter(|run| !run.clean).count();
    let mut lost = 0;
    for run in 0..runs {
        let best = plausible
            .iter()
            .map(|&place| &rivals[place])
            .map(|rival| {
                (rival, inquiry.loss_without(&rival.fitted, run) + charge_without(&rival.candidate, run))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((rival, _)) = best
            && rival.candidate.id != winner.candidate.id
            && !ties.contains(&rival.candidate.id)
        {
            lost += 1;
            ties.push(rival.candidate.id.clone());
        }
    }
    ties.sort();
    ties.dedup();
    record.candidates[first].status = "winner";
    record.outcome = match (ties.is_empty(), lost) {
        (true, _) => format!("added {}", winner.candidate.id),
        (false, 0) => format!("added {}, in a tie with {}", winner.candidate.id, ties.join(", ")),
        (false, _) => {
            format!("added {}, which some runs alone decide against {}", winner.candidate.id, ties.join(", "))
        }
    };
    let close = |rival: &&Rival| rival.charged < winner.charged + WAYS_LOSS;
    let others = plausible.iter().filter(|&&place| place != first).map(|&place| &rivals[place]);
    let others = others.filter(close).cloned().collect();
    Naming { choice: Some(Choice { rival: winner, gain, ties, others }), record }
}
