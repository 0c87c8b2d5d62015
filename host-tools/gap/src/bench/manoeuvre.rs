//! Whether the suggested manoeuvre resolves a tie: the plant drives it with the same hidden effect,
//! and the workflow is run again.

use indicatif::ProgressBar;
use logs::robot::Robot;
use logs::runs::{RawRun, Runs};
use plant::effects::Effect;
use plant::{PayloadSchedule, Profile, Scenario};
use support::error::Result;

use super::super::manoeuvre::{Suggestion, Wish, suggest};
use super::sets::{self, Clean};
use super::{Case, columns};
use crate::likelihood::LEVEL;
use crate::report::Report;
use crate::weighed;
use residuals::thresholds::manoeuvre::RUNS;
use residuals::types::{Options, Verdict};

/// What became of a tie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The truth alone is named.
    Resolved,
    /// Still a tie with the truth in it.
    Tied,
    /// Another effect alone is named, or a tie without the truth.
    Wrong,
    /// Nothing is named any more.
    Lost,
    /// No drive was suggested.
    NoProfile,
}

/// A set that ended in a tie, and what the manoeuvre made of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Parted {
    /// The case, its effect scaled.
    pub case: Case,
    /// Names in the tie, the winner first.
    pub tie: Vec<String>,
    /// What was suggested.
    pub suggestion: Suggestion,
    /// Names after driving it, the winner before its ties.
    pub names: Vec<String>,
    /// How it ended.
    pub ending: Ending,
}

/// Runs the cases on all cores; those that end in a tie are driven. One entry a tie.
///
/// # Errors
/// What plant, fit and workflow refuse.
pub fn run(robot: &Robot, cases: &[Case], bar: &ProgressBar) -> Result<Vec<Parted>> {
    Ok(super::all(cases, bar, |case| one(robot, case))?.into_iter().flatten().collect())
}

/// One case; `None` where there is no tie.
///
/// # Errors
/// As [`run`].
pub fn one(robot: &Robot, case: &Case) -> Result<Option<Parted>> {
    let columns = columns(case);
    let mut clean = sets::clean(robot, case.seed, case.noise.noise, columns)?;
    let effects = case.scaled()?;
    let case = Case { effects, ..case.clone() };
    let scenarios = sets::field(&case.effects, case.noise.noise).field(case.seed);
    let mut raw = sets::record(&scenarios, columns)?;
    let (runs, report) = look(&clean, &raw, &case)?;
    let Some(suggestion) = suggest(robot, &runs, Some(&clean.runs), &report, &Wish::default())? else {
        return Ok(None);
    };
    let tie = names(&report);
    let mut names_after = tie.clone();
    let mut ending = Ending::NoProfile;
    // Payloads are put on scales.
    let mut hidden = case.effects.clone();
    hidden.retain(|effect| effect.id() != "payload-mislabel");
    if let Some(driven) = driven(&suggestion, &scenarios[0], &hidden) {
        let reference = driven.iter().take(suggestion.reference_runs).zip(0..).map(|(run, place)| Scenario {
            effects: Vec::new(),
            seed: run.seed + 50 + place,
            ..run.clone()
        });
        let reference: Vec<Scenario> = reference.collect();
        if !reference.is_empty() {
            let more = clean.runs.condition_alike(&clean.runs.robot, sets::record(&reference, columns)?)?;
            clean.runs.runs.extend(more.runs);
        }
        let further = sets::record(&driven, columns)?;
        raw.extend(further.into_iter().map(|run| RawRun { name: format!("manoeuvre, {}", run.name), ..run }));
        let (_, again) = look(&clean, &raw, &case)?;
        names_after = names(&again);
        ending = judge(&again, &case);
    }
    Ok(Some(Parted { case, tie, suggestion, names: names_after, ending }))
}

fn look(clean: &Clean, raw: &[RawRun], case: &Case) -> Result<(Runs, Report)> {
    let runs = clean.runs.condition_alike(&clean.runs.robot, raw.to_vec())?;
    let options = Options { removed: case.removed.clone(), ..Options::default() };
    let report = weighed::investigate(&runs, Some(&clean.runs), &clean.base, &options, LEVEL)?;
    Ok((runs, report))
}

fn names(report: &Report) -> Vec<String> {
    let named = report.effects.iter().map(|effect| effect.candidate.id.clone());
    named.chain(report.ambiguous_with.iter().cloned()).collect()
}

/// Runs of the suggested profile, everything else as in the field.
fn driven(suggestion: &Suggestion, like: &Scenario, effects: &[Effect]) -> Option<Vec<Scenario>> {
    let knots = suggestion.knots.as_ref()?;
    let duration_s = suggestion.duration_s()?;
    let runs = (0..RUNS).map(|place| {
        let mass = suggestion.masses_kg[place % suggestion.masses_kg.len()];
        Scenario {
            profile: Profile::from_twists(knots.iter().map(|(time, [v, turn])| (*time, [*v, 0.0, *turn]))),
            payload: PayloadSchedule::constant(mass),
            duration_s,
            // No run of the field is the hundredth.
            seed: like.seed + 100 + place as u64,
            effects: effects.to_vec(),
            ..like.clone()
        }
    });
    Some(runs.collect())
}

fn judge(report: &Report, case: &Case) -> Ending {
    let truth: Vec<&str> = case.effects.iter().map(|effect| effect.id()).collect();
    let names = names(report);
    let covered = truth.iter().all(|id| names.iter().any(|name| name == id));
    match report.verdict {
        Verdict::Named if covered && names.len() == truth.len() => Ending::Resolved,
        Verdict::Ambiguous if covered => Ending::Tied,
        Verdict::Named | Verdict::Ambiguous => Ending::Wrong,
        Verdict::None | Verdict::Unexplained => Ending::Lost,
    }
}

#[cfg(test)]
mod tests {
    use super::super::sets::noises;
    use super::super::typical;
    use super::*;

    /// An offset of the sensor half as large as the noise, in drives that hardly rest: it might be
    /// a power drawn during motion only.
    #[test]
    fn a_tie_is_parted_by_driving_what_is_suggested() {
        let robot = Robot::named("burger").unwrap();
        let effects =
            vec![typical().unwrap().into_iter().find(|effect| effect.id() == "sensor-offset").unwrap()];
        let case = Case { effects, size: 0.5, seed: 3, noise: noises()[0], removed: Vec::new() };
        let parted = one(&robot, &case).unwrap().expect("a set that ties");
        assert!(
            parted.tie.len() > 1 && parted.tie.iter().any(|id| id == "sensor-offset"),
            "{:?}",
            parted.tie
        );
        let worst = parted.suggestion.pairs.iter().map(|pair| pair.z).fold(f64::INFINITY, f64::min);
        assert!(worst > 3.0, "{:?}", parted.suggestion.pairs);
        assert_eq!((parted.ending, &parted.names[..]), (Ending::Resolved, &["sensor-offset".to_owned()][..]));
    }
}
