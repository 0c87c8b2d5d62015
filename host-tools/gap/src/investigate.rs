//! The workflow: split, detect, localise, name, tie or abstain, add, repeat, confirm.

use logs::runs::Runs;
use model::effects::{Candidate, Regressor, World, physical};
use support::error::Result;

use super::confirm::{self, Confirmed, ConfirmedShare};
use super::report::localise;
use super::report::{Basis, Report, Rival};
use super::rounds::search;
use super::words;
use nalgebra::DMatrix;
use residuals::calibrate::shown_by_clean;
use residuals::detect::over_dispersion::OverDispersion;
use residuals::identifiable::{also_with_one_mass, has_one_mass};
use residuals::late;
use residuals::name::hypothesis::Hypothesis;
use residuals::predictor::{Predictor, State};
use residuals::problem::clean_delay;
use residuals::problem::open::{open_problem, precision};
use residuals::scope::Testable;
use residuals::split;
use residuals::thresholds::confirm::LEAST_CLOSED;
use residuals::thresholds::name::DELAY_SAMPLES;
use residuals::types::{Base, Named, Options, Verdict};

/// Runs the workflow.
///
/// # Errors
/// Too few runs.
pub fn investigate(runs: &Runs, clean: Option<&Runs>, base: &Base, options: &Options) -> Result<Report> {
    let threshold = if clean.is_some() { options.threshold } else { options.threshold_alone };
    let options = &Options { threshold, ..options.clone() };
    let split = split::by_run(runs)?;
    let field = runs.subset(&split.open);
    let open = field.with_clean(clean);
    let clean_delay = clean.map_or(0.0, |clean| clean_delay::estimate(clean, base));
    let parameters = base.torque.to_array().len() - usize::from(!runs.robot.scrubs());
    let Testable { list, removed, not_testable } = Testable::of(&field, runs, base, options);
    let predictor = Predictor { clean_delay, ..Predictor::new(&open, base.drive) };
    let mut problem = open_problem(predictor, &[], base, parameters, &list, options);
    // The noise is told once, by the clean runs.
    let whitener = Some(problem.noise.whitener.clone());
    let options = &Options { removed, whitener, ..options.clone() };
    let clean_structure =
        clean.and_then(|clean| shown_by_clean(clean, clean_delay, base, parameters, &list, options));
    let by_noise = options.threshold;
    let threshold = by_noise.max(clean_structure.unwrap_or(0.0));
    let misfit = (threshold / by_noise).powi(2);
    let options = &Options { threshold, misfit, ..options.clone() };
    problem.misfit = misfit;
    let findings = search(&problem, &list, by_noise, options);
    let delay = late::in_whole_rows(findings.delay().unwrap_or(0.0), field.period_s);
    let in_time;
    let (problem, mut findings) = if delay == 0.0 {
        (problem, findings)
    } else {
        in_time = late::in_time(&field, delay).with_clean(clean);
        let predictor = Predictor { runs: &in_time, removed_delay: delay, ..predictor };
        let shifted = open_problem(predictor, &late::known(delay), base, parameters, &list, options);
        let repeated = search(&shifted, &list, by_noise, options);
        if repeated.delay().is_some() { (shifted, repeated) } else { (problem, findings) }
    };
    if has_one_mass(&base.masses_kg, runs) {
        findings.doubt(also_with_one_mass(&findings.named, &findings.rounds));
    }
    // A simulator's runs have no scatter to compare with.
    let over_dispersion =
        if base.of_simulator { None } else { OverDispersion::of(&problem, &findings.state) };
    let mut confirmed = confirm::on_locked(runs, &split, clean, base, &findings.state, &problem, parameters);
    // A name that leaves most of the excess does not explain more scatter than in clean runs.
    let is_disturbed = over_dispersion.is_some_and(|over_dispersion| over_dispersion.is_beyond_chance());
    if is_disturbed
        && (findings.named.is_empty() || !findings.lives_in_single_runs() && leaves_most(&confirmed))
    {
        findings.verdict = Verdict::Unexplained;
    }
    if findings.verdict.stands() && confirmed.closed.is_some() {
        let locked = runs.subset(&split.locked);
        let in_time = late::in_time(&locked, delay).with_clean(clean);
        let predictor = Predictor { runs: &in_time, removed_delay: delay, ..predictor };
        let asked = open_problem(predictor, &late::known(delay), base, parameters, &list, options);
        let residuals = confirmed.residuals.each_ref().map(|signal| late::earlier(&locked, signal, delay));
        confirmed.share = ConfirmedShare::of(&asked, &residuals);
    }
    if findings.verdict.stands() && confirmed.refuted(findings.lives_in_single_runs()) {
        findings.verdict = Verdict::Unexplained;
    }
    if findings.verdict == Verdict::Unexplained && !is_disturbed {
        findings.verdict = findings.standing.without_a_name();
    }
    // What names that do not hold leave is no noise of the runs.
    if findings.verdict == Verdict::None && !findings.named.is_empty() {
        findings.forget(problem.start());
        confirmed = confirm::on_locked(runs, &split, clean, base, &findings.state, &problem, parameters);
    }
    let residuals = [(predictor.residual(&problem.start()), 0), (predictor.residual(&findings.state), 1)];
    let [before, after] = residuals.map(|(open, side)| split.in_order(&open, &confirmed.residuals[side]));
    let mut localisation = localise::cells(runs, &before);
    if findings.verdict.stands() {
        localise::fill_after(runs, &mut localisation, &after);
    }
    if !findings.verdict.stands() {
        findings.ambiguous.clear();
    }
    let covariance = findings.fitted.as_ref().map(|fitted| {
        let mut covariance = problem.covariance(fitted) * problem.misfit;
        let last = covariance.nrows() - 1;
        let delayed =
            findings.state.effects.iter().rev().position(|(regressor, _)| *regressor == Regressor::Delay);
        if let Some(back) = delayed {
            covariance[(last - back, last - back)] += (DELAY_SAMPLES * runs.step.period_s()).powi(2);
        }
        covariance
    });
    let joint = covariance.as_ref().and_then(|covariance| joint(covariance, problem.base > 0, base));
    let known = joint.as_ref().or(covariance.as_ref()).filter(|_| findings.verdict.stands());
    Ok(Report {
        verdict: findings.verdict,
        standing: findings.standing,
        effects: known.map_or(Vec::new(), |known| {
            named_effects(&findings.named, &findings.state, known, runs.robot.rows(), options.slack)
        }),
        ambiguous_with: findings.ambiguous,
        not_testable,
        rounds: findings.rounds,
        localisation,
        residuals: (before, findings.verdict.stands().then_some(after)),
        confirmed,
        base: [base.torque, findings.state.torque],
        state: findings.state,
        covariance: joint,
        split,
        over_dispersion,
        clean_structure,
        refit: Vec::new(),
        ties: findings.ties.into_iter().map(|tie| tie.into_iter().map(rival).collect()).collect(),
        rivals: Vec::new(),
        relabelled: None,
        notes: Vec::new(),
        basis: Some(Basis {
            drive: base.drive,
            clean_delay,
            whitener: problem.noise.whitener.clone(),
            std_w: problem.noise.usual_w(),
            precision: precision(base, parameters, options.slack),
        }),
    })
}

/// What a drive has to distinguish.
fn rival(hypothesis: Hypothesis) -> Rival {
    Rival { candidate: hypothesis.candidate, state: hypothesis.fitted.state }
}

/// Whether most of the locked runs' excess over clean ones remains.
fn leaves_most(confirmed: &Confirmed) -> bool {
    confirmed.closed_to_clean().is_none_or(|closed| closed < LEAST_CLOSED)
}

/// The effects with their physical sizes and standard errors. The last rows of `covariance` are
/// theirs, the first, if there are more, the base's. The base is uncertain by a share `slack`
/// besides.
pub(crate) fn named_effects(
    named: &[Candidate],
    state: &State,
    covariance: &DMatrix<f64>,
    rows: [&[f64]; 3],
    slack: f64,
) -> Vec<Named> {
    let coefficients: Vec<f64> = state.effects.iter().map(|(_, coefficient)| *coefficient).collect();
    let first = covariance.nrows() - coefficients.len();
    let mut base = covariance.view((0, 0), (first, first)).into_owned();
    for (place, value) in state.torque.to_array().iter().enumerate().take(first) {
        base[(place, place)] += (slack * value).powi(2);
    }
    let world = World::new(rows, state.torque, base);
    let mut from = 0;
    let named = named.iter().map(|candidate| {
        let range = from..from + candidate.regressors.len();
        from = range.end;
        let places = range.clone().map(|place| first + place);
        let mut named = Named {
            candidate: candidate.clone(),
            coefficients: coefficients[range].to_vec(),
            std_errs: places.clone().map(|place| covariance[(place, place)].sqrt()).collect(),
            physical: None,
        };
        let weights = words::headline_weights(&named);
        let with = |parameter: usize| -> f64 {
            places.clone().zip(&weights).map(|(place, weight)| weight * covariance[(parameter, place)]).sum()
        };
        let with_base: Vec<f64> = (0..first).map(with).collect();
        named.physical = physical(candidate, words::headline(&named), &with_base, &world);
        named
    });
    named.collect()
}

/// Covariance of the base's parameters and the effects' coefficients; `None` where nothing is known
/// of the base. Where clean runs show the base's error, effects were fitted whatever that error is:
/// the two are independent.
pub(crate) fn joint(fitted: &DMatrix<f64>, has_base: bool, base: &Base) -> Option<DMatrix<f64>> {
    if has_base {
        return Some(fitted.clone());
    }
    let known = base.covariance.as_ref()?;
    let size = known.nrows() + fitted.nrows();
    let mut joint = DMatrix::zeros(size, size);
    joint.view_mut((0, 0), known.shape()).copy_from(known);
    joint.view_mut((known.nrows(), known.nrows()), fitted.shape()).copy_from(fitted);
    Some(joint)
}
