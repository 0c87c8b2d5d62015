//! What to do next: what distinguishes an effect from its rivals, and what to record where none
//! explains the residual.
use std::collections::HashSet;

use model::effects::{PITCH, PROCESSOR, find};

use crate::likelihood::Gate;
use crate::refit;
use crate::report::Report;
use crate::words;
use residuals::types::{Standing, Status, Verdict};

/// Drives or columns in which an effect shows as no other does; `None` for an effect of the user.
pub fn shows_in(id: &str) -> Option<&'static str> {
    find(id).map(|entry| entry.shows_in)
}

/// What would distinguish the named effects from those in a tie with them: an effect, and where it
/// alone shows.
pub fn distinguishing(report: &Report) -> Vec<(String, &'static str)> {
    let winners = report.effects.iter().map(|effect| effect.candidate.id.clone());
    let last = winners.rev().find(|id| !report.ambiguous_with.contains(id));
    let hypotheses = last.into_iter().chain(report.ambiguous_with.iter().cloned());
    hypotheses.filter_map(|id| shows_in(&id).map(|how| (id, how))).collect()
}

/// The cells whose mean residual is surely the greatest, by the end of its band nearer to 0; one an
/// axis, the greatest first.
pub fn worst_cells(report: &Report, most: usize) -> Vec<&super::localise::Cell> {
    let mut cells: Vec<_> = report.localisation.iter().filter(|cell| cell.stands_out()).collect();
    let surely = |cell: &super::localise::Cell| cell.mean_residual_w.abs() - cell.band_w;
    cells.sort_by(|a, b| surely(b).total_cmp(&surely(a)));
    let mut seen = HashSet::new();
    cells.retain(|cell| seen.insert(&cell.axis));
    cells.truncate(most);
    cells
}

/// Why nothing is named.
pub fn why_unexplained(report: &Report) -> String {
    if !report.refit.is_empty() {
        return "the base lacks terms that its own clean runs ask for".to_owned();
    }
    let winners: Vec<String> = report
        .rounds
        .iter()
        .flat_map(|round| &round.candidates)
        .filter(|scored| scored.status == Status::Winner)
        .map(|scored| scored.id.clone())
        .collect();
    let last = report.rounds.last().map_or("", |round| round.outcome.as_str());
    let closest = winners.join(" + ");
    let in_single_runs = report.state.effects.iter().all(|(regressor, _)| regressor.run().is_some());
    match (report.confirmed.closed, winners.is_empty()) {
        (_, false) if report.confirmed.refuted(in_single_runs) => {
            format!("{closest} fits the open runs, but the locked runs do not confirm it")
        }
        (_, true) => last.to_owned(),
        (_, false) if report.standing != Standing::Clear && report.relabelled.is_none() => {
            format!("{closest} comes closest, but does not stand out of the noise")
        }
        (_, false) if let Some((likelier, _)) = report.rivals.first() => {
            format!("{closest} would be named, but {likelier} is likelier")
        }
        (Some(closed), false) => format!(
            "{closest} comes closest and would close {}, but leaves structure that nothing explains",
            words::percent(closed)
        ),
        (None, false) => format!("{closest} comes closest, but leaves structure that nothing explains"),
    }
}

/// What to do next, one sentence an entry.
pub fn next_steps(report: &Report) -> Vec<String> {
    if !report.refit.is_empty() {
        return refit::words(&report.refit);
    }
    match report.verdict {
        Verdict::None if report.is_power_only() => {
            vec!["record the wheels' speeds: without them nothing is known of motion".to_owned()]
        }
        Verdict::None if report.hides() => vec![
            "the clean runs disagree with each other beyond the noise: the model's form hides effects that are smaller; refit with runs that \
             hold all that the robot does, or look for what the form lacks"
                .to_owned(),
        ],
        Verdict::None if report.is_off() || report.relabelled.is_some_and(Gate::is_shut) => vec![
            "the model is off by more than the noise in clean runs, too, or in no way that lasts: refit with more clean runs, or another model"
                .to_owned(),
        ],
        Verdict::None => vec!["nothing: model and measurement agree to the noise".to_owned()],
        Verdict::Named if report.confirmed.closed.is_none() => vec![
            "record the affected runs again: no locked run has the effect, so it is not confirmed".to_owned(),
        ],
        Verdict::Named => {
            vec!["see whether the cause is what the name says, then add it to the model".to_owned()]
        }
        Verdict::Ambiguous => distinguishing(report).into_iter().map(|(id, how)| format!("{id}: {how}")).collect(),
        Verdict::Unexplained => {
            let mut steps = Vec::new();
            if let Some(cell) = worst_cells(report, 1).first() {
                steps.push(format!("record more runs with {}: there the model is off most", cell.words));
            }
            let columns: Vec<&str> = missing_columns(report);
            if !columns.is_empty() {
                steps
                    .push(format!("log what the robot knows beside speed and power: {}", columns.join(", ")));
            }
            steps.push("an effect of your own that the dictionary lacks may be it".to_owned());
            steps
        }
    }
}

/// Columns that would make more effects testable, or effects easier to distinguish.
fn missing_columns(report: &Report) -> Vec<&'static str> {
    let has = |name: &str| report.localisation.iter().any(|cell| cell.axis.starts_with(name));
    [(PITCH, PITCH), ("motor1_temp_c", "motor1_temp_c …"), ("bus_v", "bus_v"), (PROCESSOR, PROCESSOR)]
        .into_iter()
        .filter(|(name, _)| !has(name))
        .map(|(_, said)| said)
        .collect()
}
