//! The workflow: split, detect, localise, name, tie or abstain, add, repeat, confirm.

use super::confirm::{self, ConfirmedShare};
use super::detect::over_dispersion::OverDispersion;
use super::detect::{shape_test, structure};
use super::name::hypothesis::Hypothesis;
use super::name::name;
use super::problem::fit::Fitted;
use super::problem::lag;
use super::problem::open::{open_problem, prior};
use super::report::localise;
use super::report::{Basis, Report};
use super::runs::Runs;
use super::scope::candidates;
use super::split;
use super::thresholds::confirm::LEAST_CLOSED;
use super::thresholds::detect::{SHAPE, SHAPE_TOLERANCE};
use super::thresholds::name::LEAST_FURTHER;
use super::twin::Twin;
use super::types::{Base, Named, Options, Round, Verdict};
use crate::effects::{Candidate, World, physical};
use crate::error::Result;
use crate::gap::problem::Problem;
use crate::gap::words;
use model_core::torque::Drive;

/// Runs the workflow.
///
/// # Errors
/// Too few runs.
pub fn investigate<const N: usize>(
    runs: &Runs<N>,
    clean: Option<&Runs<N>>,
    base: &Base,
    options: &Options,
) -> Result<Report> {
    let threshold = if clean.is_some() { options.threshold } else { options.threshold_alone };
    let options = &Options { threshold, ..options.clone() };
    let split = split::by_run(runs)?;
    let field = runs.subset(&split.open);
    let open = field.with_clean(clean);
    let mut twin = Twin { runs: &open, drive: base.drive, lag: 0.0 };
    if let Some(clean) = clean {
        twin.lag = lag::of_clean(clean, base);
    }
    let parameters = base.torque.to_array().len() - usize::from(!runs.robot.kinematics.scrubs());
    let (mut list, mut not_testable) = candidates(&field, &base.torque, base.drive == Drive::Regenerative);
    list.extend_from_slice(&options.user.candidates);
    not_testable.extend_from_slice(&options.user.not_testable);
    list.retain(|candidate| !options.removed.contains(&candidate.id));
    let problem = open_problem(twin, base, parameters, &list, options);
    let mut state = problem.start();
    let before = problem.twin.residual(&state);

    let mut rounds = Vec::new();
    let mut named: Vec<Candidate> = Vec::new();
    let mut fitted: Option<Fitted> = None;
    let mut ambiguous: Vec<String> = Vec::new();
    let mut ties = Vec::new();
    let mut gained = 0.0;
    let mut verdict = Verdict::None;
    while named.len() <= options.most_effects {
        let structure = structure(&problem, &state, &list, &named);
        let shape_test = shape_test(&problem, &state);
        let allowed = (options.threshold.powi(2) + options.tolerance * gained).sqrt();
        let in_shape = shape_test.powi(2) <= SHAPE.powi(2) + SHAPE_TOLERANCE * gained;
        if structure.greatest <= allowed && in_shape {
            rounds.push(Round {
                structure: structure.greatest,
                allowed,
                candidates: structure.scored,
                outcome: "no structure beyond the noise".to_owned(),
            });
            break;
        }
        let round = name(&problem, &state, &list, &named, structure, allowed, options);
        rounds.push(round.record);
        match round.choice {
            // What takes next to nothing of what there was mops up after a wrong name.
            Some(choice) if named.len() < options.most_effects && choice.gain >= LEAST_FURTHER * gained => {
                gained += choice.gain;
                state = choice.hypothesis.fitted.state.clone();
                named.push(choice.hypothesis.candidate.clone());
                if !choice.ties.is_empty() {
                    let own = choice.hypothesis.candidate.id.clone();
                    let tied = |hypothesis: &Hypothesis| {
                        hypothesis.candidate.id == own || choice.ties.contains(&hypothesis.candidate.id)
                    };
                    let others = choice.others.into_iter().filter(tied);
                    ties.push([choice.hypothesis.clone()].into_iter().chain(others).collect());
                }
                ambiguous.extend(choice.ties);
                fitted = Some(choice.hypothesis.fitted);
                verdict = if ambiguous.is_empty() { Verdict::Named } else { Verdict::Ambiguous };
            }
            _ => {
                verdict = Verdict::Unexplained;
                break;
            }
        }
    }
    // What a later round named besides is in doubt no longer.
    ambiguous.retain(|id| named.iter().all(|own| own.id != *id));
    ambiguous.sort();
    ambiguous.dedup();
    if verdict == Verdict::Ambiguous && ambiguous.is_empty() {
        verdict = Verdict::Named;
    }
    let over_dispersion = OverDispersion::of(&problem, &state);
    let mut confirmed = confirm::on_locked(runs, &split, clean, base, &state, &problem, parameters);
    // What scatters more than clean runs do is not explained by a name that leaves most of it.
    if over_dispersion.is_some_and(|over_dispersion| over_dispersion.is_beyond_chance())
        && (named.is_empty() || confirmed.closed_to_clean().is_none_or(|closed| closed < LEAST_CLOSED))
    {
        verdict = Verdict::Unexplained;
    }
    if matches!(verdict, Verdict::Named | Verdict::Ambiguous) && confirmed.closed.is_some() {
        let locked = runs.subset(&split.locked).with_clean(clean);
        let twin = Twin { runs: &locked, ..problem.twin };
        let asked = open_problem(twin, base, parameters, &list, options);
        confirmed.share = ConfirmedShare::of(&asked, &confirmed.residuals);
    }
    if matches!(verdict, Verdict::Named | Verdict::Ambiguous) && confirmed.refuted() {
        verdict = Verdict::Unexplained;
    }
    let after = problem.twin.residual(&state);
    let [before, after] =
        [(&before, 0), (&after, 1)].map(|(open, side)| split.in_order(open, &confirmed.residuals[side]));
    let stands = matches!(verdict, Verdict::Named | Verdict::Ambiguous);
    let mut localisation = localise::cells(runs, &before);
    if stands {
        localise::fill_after(runs, &mut localisation, &after);
    }
    let effects = match (&fitted, verdict) {
        (Some(fitted), Verdict::Named | Verdict::Ambiguous) => list_effects(&named, fitted, &problem, base),
        _ => Vec::new(),
    };
    if verdict == Verdict::Unexplained {
        ambiguous.clear();
    }
    Ok(Report {
        verdict,
        effects,
        ambiguous_with: ambiguous,
        not_testable,
        rounds,
        localisation,
        residuals: (before, stands.then_some(after)),
        confirmed,
        base: [base.torque, state.torque],
        state,
        split,
        over_dispersion,
        ties,
        basis: Some(Basis {
            drive: base.drive,
            lag: problem.twin.lag,
            whitener: problem.noise.whitener.clone(),
            std_w: problem.noise.usual_w(),
            prior: prior(base, parameters, options.slack),
        }),
    })
}

fn list_effects<const N: usize>(
    named: &[Candidate],
    fitted: &Fitted,
    problem: &Problem<'_, N>,
    base: &Base,
) -> Vec<Named> {
    let first = problem.base + problem.discrepancy.len();
    let covariance = &fitted.covariance;
    // With clean runs the base stays as it was fitted to them, and as uncertain.
    let known = match &base.covariance {
        Some(own) if problem.base == 0 => own.clone(),
        _ => covariance.view((0, 0), (problem.base, problem.base)).into_owned(),
    };
    let world = World::new(&problem.twin.runs.robot.kinematics, fitted.state.torque, known);
    let mut from = 0;
    named
        .iter()
        .map(|candidate| {
            let range = from..from + candidate.regressors.len();
            from = range.end;
            let places = range.clone().map(|place| first + place);
            let mut named = Named {
                candidate: candidate.clone(),
                coefficients: fitted.state.effects[range].iter().map(|(_, c)| *c).collect(),
                std_errs: places.clone().map(|own| covariance[(own, own)].max(0.0).sqrt()).collect(),
                physical: None,
            };
            let weights = words::headline_weights(&named);
            let with = |parameter: usize| -> f64 {
                places.clone().zip(&weights).map(|(own, weight)| weight * covariance[(parameter, own)]).sum()
            };
            let with_base: Vec<f64> = (0..problem.base).map(with).collect();
            named.physical = physical(candidate, words::headline(&named), &with_base, &world);
            named
        })
        .collect()
}
