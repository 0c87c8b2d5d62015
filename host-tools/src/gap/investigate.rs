//! The workflow: split, detect, localise, name, tie or abstain, add, repeat, confirm.

use std::panic::resume_unwind;
use std::thread;

use model_core::torque::{Drive, TorqueModel};
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};
use serde_json::{Value, json};

use super::confirm::{self, Confirmed, Seen};
use super::dictionary::{Candidate, NotTestable, candidates};
use super::excess::Excess;
use super::inquiry::{Fitted, Inquiry, Rival};
use super::joint::{Prior, solve};
use super::lag;
use super::localise::{self, Cell};
use super::noise::Noise;
use super::panel::{Fixed, residual};
use super::runs::Runs;
use super::scan;
use super::shape;
use super::smooth;
use super::split::{self, Split};
use super::twin::{Cause, State, Twin};
use super::user::UserCandidates;
use super::whiten::{Signal, Whitener};
use crate::error::Result;

/// Where the base comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Base {
    /// The torque model.
    pub torque: TorqueModel<f64>,
    /// Covariance of its parameters; `None` where the base was fitted to these very runs.
    pub covariance: Option<DMatrix<f64>>,
    /// Whether the drives clamp.
    pub drive: Drive,
}

/// The columns of base and effects that clean runs tell, too, would be wrong: a share of the least eigenvalue that counts.
const RIDGE: f64 = 1e-9;

/// What may be set.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// |z| of a smooth function, or of an effect, beyond which there is structure.
    pub threshold: f64,
    /// The same where no clean runs say what the model gets wrong without any effect.
    pub threshold_alone: f64,
    /// Share of an effect's own gain in χ² that may be left as structure.
    pub tolerance: f64,
    /// Most effects that are added.
    pub most_effects: usize,
    /// Ids that are not in the dictionary (for benchmarks).
    pub removed: Vec<String>,
    /// The whitener of clean runs, if there are any.
    pub whitener: Option<Whitener>,
    /// Relative uncertainty of every base parameter beyond its covariance.
    pub slack: f64,
    /// Effects of the user's own.
    pub user: UserCandidates,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            threshold: 5.3,
            threshold_alone: 20.0,
            tolerance: 0.015,
            most_effects: 3,
            removed: Vec::new(),
            whitener: None,
            slack: 0.01,
            user: UserCandidates::default(),
        }
    }
}

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// No structure beyond the noise.
    None,
    /// Effects are named, and the locked runs confirm them.
    Named,
    /// Several effects explain what is seen.
    Ambiguous,
    /// There is structure, and no effect explains it.
    Unexplained,
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Which.
    pub candidate: Candidate,
    /// Coefficients of its columns.
    pub coefficients: Vec<f64>,
    /// Their standard errors.
    pub std_errs: Vec<f64>,
}

/// The score of a candidate in a round.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// Its id.
    pub id: String,
    /// What is special about it.
    pub detail: Value,
    /// χ² that it gains over base and effects before, its search paid for.
    pub gain: f64,
    /// Coefficients of its columns.
    pub coefficients: Vec<f64>,
    /// Why it is none, or what it is: `winner`, `tie`, `worse`, `implausible`, `unidentifiable here`.
    pub status: &'static str,
}

/// One round.
#[derive(Debug, Clone, PartialEq)]
pub struct Round {
    /// Greatest |z| of smooth functions and effects.
    pub structure: f64,
    /// What was allowed.
    pub allowed: f64,
    /// Candidates, best first.
    pub candidates: Vec<Scored>,
    /// What the round ended with.
    pub outcome: String,
}

/// All that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The answer.
    pub verdict: Verdict,
    /// Effects added.
    pub effects: Vec<Named>,
    /// Ids of rivals that explain as much.
    pub ambiguous_with: Vec<String>,
    /// Effects that these runs cannot show.
    pub not_testable: Vec<NotTestable>,
    /// Round by round.
    pub rounds: Vec<Round>,
    /// Where the residual lies before anything is added, and after: open and locked runs together.
    pub localisation: Vec<Cell>,
    /// Measured less predicted power, W, of every run before, and after where effects stand: of open runs as they were fitted, of
    /// locked runs as they were confirmed.
    pub residuals: (Signal, Option<Signal>),
    /// On the locked runs.
    pub confirmed: Confirmed,
    /// Base and effects at the end.
    pub state: State,
    /// The split.
    pub split: Split,
    /// The scatter of what is left against that of clean runs.
    pub excess: Option<Excess>,
    /// Base before, and after.
    pub base: [TorqueModel<f64>; 2],
    /// Rivals of each round that ended in a tie, the winner first, each in all ways in which it may show.
    pub ties: Vec<Vec<Rival>>,
    /// What predictions rest on.
    pub basis: Option<Basis>,
}

/// What predictions of other runs rest on, beside a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Whether the drives clamp.
    pub drive: Drive,
    /// By how much power is later than speed in clean runs already, s.
    pub lag: f64,
    /// Takes the memory of the noise away.
    pub whitener: Whitener,
    /// Standard deviation of the whitened noise, W.
    pub std_w: f64,
    /// What is known of the base.
    pub prior: Prior,
}

/// Losses closer than this are no difference: χ² of three standard errors.
const TIE_LOSS: f64 = 9.0;

/// Ways of a tied effect that are further behind than this in χ² are not to be parted by a manoeuvre: they are already.
const WAYS_LOSS: f64 = 25.0;

/// What comes on top, as a share of the winner's gain: no term of the model is exact.
const TIE_SHARE: f64 = 0.01;

/// One-sided 95 % of a normal variable.
const TIE_ERRORS: f64 = 1.64;

/// Least gain of a further effect, as a share of what those before it gained.
const LEAST_FURTHER: f64 = 0.1;

/// |z| of an effect's column times something else beyond which the effect has not the shape of what is there, and the share of
/// the gain in χ² that comes on top: no term of the model is exact.
const SHAPE: f64 = 5.5;
const SHAPE_TOLERANCE: f64 = 0.006;

/// Candidates that are fitted with their non-linearity.
const REFINED: usize = 40;

/// Share of what field runs have beyond clean ones that names have to close where the rest scatters more than in clean runs.
const LEAST_CLOSED: f64 = 0.5;

/// A named effect has to show on the locked runs with at least this share of what it adds.
pub const LEAST_SEEN: f64 = 0.5;

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
    let inquiry = open_inquiry(twin, base, parameters, &list, options);
    let mut state = inquiry.start();
    let before = residual(&inquiry.twin, &state);

    let mut rounds = Vec::new();
    let mut named: Vec<Candidate> = Vec::new();
    let mut fitted: Option<Fitted> = None;
    let mut ambiguous: Vec<String> = Vec::new();
    let mut ties = Vec::new();
    let mut gained = 0.0;
    let mut verdict = Verdict::None;
    while named.len() <= options.most_effects {
        let structure = structure(&inquiry, &state, &list, &named);
        let misshape = misshape(&inquiry, &state);
        let allowed = (options.threshold.powi(2) + options.tolerance * gained).sqrt();
        let in_shape = misshape.powi(2) <= SHAPE.powi(2) + SHAPE_TOLERANCE * gained;
        if structure.greatest <= allowed && in_shape {
            rounds.push(Round {
                structure: structure.greatest,
                allowed,
                candidates: structure.scored,
                outcome: "no structure beyond the noise".to_owned(),
            });
            break;
        }
        let round = name(&inquiry, &state, &list, &named, structure, allowed, options);
        rounds.push(round.record);
        match round.choice {
            // What takes next to nothing of what there was mops up after a wrong name.
            Some(choice) if named.len() < options.most_effects && choice.gain >= LEAST_FURTHER * gained => {
                gained += choice.gain;
                state = choice.rival.fitted.state.clone();
                named.push(choice.rival.candidate.clone());
                if !choice.ties.is_empty() {
                    let own = choice.rival.candidate.id.clone();
                    let tied = |rival: &Rival| {
                        rival.candidate.id == own || choice.ties.contains(&rival.candidate.id)
                    };
                    let others = choice.others.into_iter().filter(tied);
                    ties.push([choice.rival.clone()].into_iter().chain(others).collect());
                }
                ambiguous.extend(choice.ties);
                fitted = Some(choice.rival.fitted);
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
    let excess = Excess::of(&inquiry, &state);
    let mut confirmed = confirm::on_locked(runs, &split, clean, base, &state, &inquiry.noise, parameters);
    // What scatters more than clean runs do is not explained by a name that leaves most of it.
    if excess.is_some_and(|excess| excess.is_beyond_chance())
        && (named.is_empty() || confirmed.closed_to_clean().is_none_or(|closed| closed < LEAST_CLOSED))
    {
        verdict = Verdict::Unexplained;
    }
    if matches!(verdict, Verdict::Named | Verdict::Ambiguous) && confirmed.closed.is_some() {
        let locked = runs.subset(&split.locked).with_clean(clean);
        let twin = Twin { runs: &locked, ..inquiry.twin };
        let asked = open_inquiry(twin, base, parameters, &list, options);
        confirmed.seen = Seen::of(&asked, &confirmed.residuals);
    }
    if matches!(verdict, Verdict::Named | Verdict::Ambiguous) && confirmed.refuted() {
        verdict = Verdict::Unexplained;
    }
    let after = residual(&inquiry.twin, &state);
    let [before, after] =
        [(&before, 0), (&after, 1)].map(|(open, side)| split.in_order(open, &confirmed.residuals[side]));
    let stands = matches!(verdict, Verdict::Named | Verdict::Ambiguous);
    let mut localisation = localise::cells(runs, &before);
    if stands {
        localise::fill_after(runs, &mut localisation, &after);
    }
    let effects = match (&fitted, verdict) {
        (Some(fitted), Verdict::Named | Verdict::Ambiguous) => {
            list_effects(&named, fitted, inquiry.base + inquiry.discrepancy.len())
        }
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
        excess,
        ties,
        basis: Some(Basis {
            drive: base.drive,
            lag: inquiry.twin.lag,
            whitener: inquiry.noise.whitener.clone(),
            std_w: inquiry.noise.usual_w(),
            prior: prior(base, parameters, options.slack),
        }),
    })
}

fn list_effects(named: &[Candidate], fitted: &Fitted, base: usize) -> Vec<Named> {
    let mut from = 0;
    named
        .iter()
        .map(|candidate| {
            let range = from..from + candidate.causes.len();
            from = range.end;
            Named {
                candidate: candidate.clone(),
                coefficients: fitted.state.effects[range.clone()].iter().map(|(_, c)| *c).collect(),
                std_errs: range
                    .map(|place| fitted.covariance[(base + place, base + place)].max(0.0).sqrt())
                    .collect(),
            }
        })
        .collect()
}

fn open_inquiry<'a, const N: usize>(
    twin: Twin<'a, N>,
    base: &Base,
    parameters: usize,
    list: &[Candidate],
    options: &Options,
) -> Inquiry<'a, N> {
    let smooth = smooth::functions(twin.runs);
    let start = State { torque: base.torque, effects: Vec::new() };
    let causes: Vec<_> = list.iter().flat_map(|candidate| candidate.causes.iter().cloned()).collect();
    let has_clean = twin.runs.runs.iter().any(|run| run.clean);
    let field: Vec<Signal> = smooth.iter().map(|signal| only_field(twin.runs, signal)).collect();
    let shared = if has_clean { shared(&twin, &start, parameters, &causes, &smooth) } else { Vec::new() };
    let signals: Vec<Signal> = shared.iter().chain(&field).cloned().collect();
    let noise = Noise::estimate(&twin, &start, parameters, &causes, &signals, options.whitener.as_ref());
    let whiten = |signals: &[Signal]| -> Vec<Signal> {
        let run = |(place, values): (usize, &Vec<f64>)| noise.whiten(twin.runs, place, values);
        signals.iter().map(|signal| signal.iter().enumerate().map(run).collect()).collect()
    };
    let lengths: Vec<usize> = twin.runs.runs.iter().map(|run| run.rows.len()).collect();
    let discrepancy = Fixed::new(&unit(whiten(&shared)), &lengths);
    let factor = factor(&discrepancy);
    let smooth = whiten(&field);
    // With clean runs the discrepancy holds the base's columns: it moves instead, and the base stays where it was.
    let parameters = if has_clean { 0 } else { parameters };
    let prior = prior(base, parameters, options.slack);
    Inquiry { twin, centre: base.torque, base: parameters, prior, noise, discrepancy, factor, smooth }
}

/// A signal in the runs under inquiry only.
fn only_field<const N: usize>(runs: &Runs<N>, signal: &Signal) -> Signal {
    let runs = runs.runs.iter().zip(signal);
    runs.map(|(run, values)| if run.clean { vec![0.0; values.len()] } else { values.clone() }).collect()
}

/// What the base may get wrong on any run: along the smooth functions, and along the effects as they would show in it.
fn shared<const N: usize>(
    twin: &Twin<'_, N>,
    start: &State,
    parameters: usize,
    causes: &[Cause],
    smooth: &[Signal],
) -> Vec<Signal> {
    let mut shared: Vec<Signal> = smooth::shown_by_clean(twin.runs, smooth);
    let mut field = twin.runs.clone();
    for run in &mut field.runs {
        run.clean = false;
    }
    let twin = Twin { runs: &field, ..*twin };
    let usable = |cause: &&Cause| !matches!(cause, Cause::Column(_) | Cause::Temperature(..));
    let runs: Vec<Vec<f64>> = (0..field.runs.len()).map(|place| twin.predict(place, start)).collect();
    let slopes: Vec<Vec<Vec<f64>>> =
        runs.iter().enumerate().map(|(place, at)| twin.base_slopes(place, start, at, parameters)).collect();
    for parameter in 0..parameters {
        shared.push(slopes.iter().map(|slopes| slopes[parameter].clone()).collect());
    }
    for cause in causes.iter().filter(usable) {
        let signal = runs.iter().enumerate().map(|(place, at)| twin.effect_slope(place, start, cause, at));
        shared.push(signal.collect());
    }
    shared
}

/// Signals scaled to unit length.
fn unit(signals: Vec<Signal>) -> Vec<Signal> {
    let scaled = |mut signal: Signal| {
        let length = signal.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            signal.iter_mut().flatten().for_each(|x| *x /= length);
        }
        signal
    };
    signals.into_iter().map(scaled).collect()
}

fn factor(discrepancy: &Fixed) -> Option<Cholesky<f64, Dyn>> {
    if discrepancy.is_empty() {
        return None;
    }
    let mut total = DMatrix::zeros(discrepancy.len(), discrepancy.len());
    for run in &discrepancy.products {
        total += run;
    }
    for i in 0..total.nrows() {
        total[(i, i)] += RIDGE;
    }
    total.cholesky()
}

/// Λ of the base's covariance, widened by a relative slack; next to nothing without a covariance.
fn prior(base: &Base, parameters: usize, slack: f64) -> Prior {
    let values = base.torque.to_array();
    // Sizes of parameters that were found to be nought.
    let typical = [1e-2, 1e-2, 1e-3, 1e-3, 1.0, 1.0, 1e-2];
    let size = |i: usize| values[i].abs().max(1e-2 * typical[i]);
    let Some(covariance) = &base.covariance else { return loose(base, parameters) };
    if parameters == 0 {
        return Prior { precision: DMatrix::zeros(0, 0) };
    }
    let mut wide = covariance.clone();
    for i in 0..parameters {
        wide[(i, i)] += (slack * size(i)).powi(2);
        // A parameter of which its fit knew nothing has no variance in the file.
        if covariance[(i, i)] <= 0.0 {
            wide[(i, i)] += (10.0 * size(i)).powi(2);
        }
    }
    let scale = DVector::from_fn(parameters, |i, _| 1.0 / wide[(i, i)].sqrt());
    let scaled = DMatrix::from_fn(parameters, parameters, |i, j| wide[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.pseudo_inverse(1e-9).unwrap_or_else(|_| DMatrix::identity(parameters, parameters));
    Prior {
        precision: DMatrix::from_fn(parameters, parameters, |i, j| inverse[(i, j)] * scale[i] * scale[j]),
    }
}

/// Next to nothing is known: the runs tell.
fn loose(base: &Base, parameters: usize) -> Prior {
    let values = base.torque.to_array();
    let precision = DVector::from_fn(parameters, |i, _| 1e-6 / values[i].abs().max(1e-4).powi(2));
    Prior { precision: DMatrix::from_diagonal(&precision) }
}

/// What the detector sees.
struct Structure {
    greatest: f64,
    /// Scores of all candidates, made linear at the state.
    scored: Vec<Scored>,
    /// Their places in the list with their gains, best first.
    order: Vec<(usize, f64)>,
    /// Of single runs and unknown times.
    further: Vec<Candidate>,
}

fn structure<const N: usize>(
    inquiry: &Inquiry<'_, N>,
    state: &State,
    list: &[Candidate],
    named: &[Candidate],
) -> Structure {
    let causes: Vec<_> = list
        .iter()
        .flat_map(|candidate| candidate.causes.iter().cloned())
        .filter(|cause| state.effects.iter().all(|(own, _)| own != cause))
        .collect();
    let panel = inquiry.panel(state, &causes, true);
    let total = panel.products().total(None);
    let base = inquiry.base;
    let active = inquiry.active(state);
    let first = inquiry.first_further(state);
    let offset = inquiry.offset(state);
    let alone = solve(&total, base, &inquiry.prior, &offset, &active);
    let null = alone.as_ref().map_or(f64::INFINITY, |solved| solved.loss);
    let mut greatest = 0.0_f64;
    let smooth_from = first + causes.len();
    for column in smooth_from..total.ncols() - 1 {
        if let Some(score) = inquiry.score(&panel, &total, state, &active, column) {
            greatest = greatest.max(score.z.abs());
        }
    }
    let mut scored = Vec::new();
    let mut order = Vec::new();
    for (place, candidate) in list.iter().enumerate() {
        if named.iter().any(|own| own.id == candidate.id) {
            continue;
        }
        let own: Vec<usize> = candidate
            .causes
            .iter()
            .filter_map(|cause| causes.iter().position(|other| other == cause))
            .map(|at| first + at)
            .collect();
        let scores: Vec<_> =
            own.iter().map(|&column| inquiry.score(&panel, &total, state, &active, column)).collect();
        let all: Vec<usize> = active.iter().chain(&own).copied().collect();
        let solved = solve(&total, base, &inquiry.prior, &offset, &all);
        let (gain, coefficients, status) = match solved {
            Some(solved) if scores.iter().any(Option::is_some) => {
                let values: Vec<f64> = solved.values.iter().skip(base + active.len()).copied().collect();
                (null - solved.loss - charge(candidate), values, "")
            }
            _ => (0.0, Vec::new(), "unidentifiable here"),
        };
        if let [Some(score)] = scores[..] {
            greatest = greatest.max(score.z.abs());
        }
        order.push((place, gain));
        let detail = Value::Object(candidate.detail.clone());
        scored.push(Scored { id: candidate.id.clone(), detail, gain, coefficients, status });
    }
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut further = Vec::new();
    for (candidate, z) in scan::candidates(inquiry, state) {
        if named.iter().all(|own| own.id != candidate.id) {
            // More times and runs were looked at than smooth functions: their scores count for less.
            greatest = greatest.max(z - scan::MORE_LOOKS);
            further.push(candidate);
        }
    }
    Structure { greatest, scored, order, further }
}

/// Greatest |z| of the effects' own columns times something else; 0 without effects.
fn misshape<const N: usize>(inquiry: &Inquiry<'_, N>, state: &State) -> f64 {
    let signals = shape::deformations(inquiry, state);
    let panel = inquiry.panel_with(state, &[], &signals);
    let total = panel.products().total(None);
    let (first, active) = (inquiry.first_further(state), inquiry.active(state));
    (first..first + signals.len())
        .filter_map(|column| inquiry.score(&panel, &total, state, &active, column))
        .fold(0.0, |most, score| most.max(score.z.abs()))
}

/// What a candidate's search and its further columns cost, in χ².
fn charge(candidate: &Candidate) -> f64 {
    let single = candidate.causes.iter().any(|cause| cause.run().is_some());
    let further = candidate.causes.len().saturating_sub(1) as f64;
    candidate.search + if single { 0.0 } else { 2.0 * further }
}

struct Choice {
    rival: Rival,
    gain: f64,
    ties: Vec<String>,
    /// All other fits that are not much worse, in several ways of one effect also.
    others: Vec<Rival>,
}

struct Naming {
    choice: Option<Choice>,
    record: Round,
}

fn name<const N: usize>(
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
    let caution = inquiry.caution(state, &winner.candidate.causes);
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

/// Whether a candidate is no better than its own limit, see [`Cause::limit`]: what makes it this effect does not show then. Where the
/// dictionary has the limit as an effect it is a rival, and in a tie.
fn shows_no_shape<const N: usize>(
    inquiry: &Inquiry<'_, N>,
    state: &State,
    winner: &Rival,
    gain: f64,
) -> bool {
    let [cause] = &winner.candidate.causes[..] else { return false };
    let Some(limit) = cause.limit() else { return false };
    let candidate = Candidate { causes: vec![limit], search: 0.0, shape: None, ..winner.candidate.clone() };
    fit_rival(inquiry, state, &candidate).is_some_and(|limit| is_tie(winner, &limit, gain))
}

/// Coefficients of single runs below this many standard errors are taken for none, when others of the candidate are not.
const LEAST_IN_RUN: f64 = 2.5;

/// Fits a candidate; runs of it that turn out to show nothing are left to themselves.
fn fit_rival<const N: usize>(
    inquiry: &Inquiry<'_, N>,
    state: &State,
    candidate: &Candidate,
) -> Option<Rival> {
    let fit = |candidate: &Candidate| {
        let zeros: Vec<_> = candidate.causes.iter().map(|cause| (cause.clone(), 0.0)).collect();
        inquiry.fit(state, &zeros, 3)
    };
    let mut candidate = candidate.clone();
    let mut fitted = fit(&candidate)?;
    if candidate.causes.iter().any(|cause| cause.run().is_some()) {
        let first = inquiry.first_further(state);
        let shows: Vec<bool> = (0..candidate.causes.len())
            .map(|place| {
                let (_, coefficient) = fitted.state.effects[state.effects.len() + place];
                let error = fitted.covariance[(first + place, first + place)].max(0.0).sqrt();
                coefficient.abs() > LEAST_IN_RUN * error
            })
            .collect();
        let all = shows.len();
        let kept = shows.iter().filter(|shows| **shows).count();
        if kept > 0 && kept < all {
            let mut shown = shows.iter();
            candidate.causes.retain(|_| shown.next().copied().unwrap_or(true));
            for value in candidate.detail.values_mut() {
                if let Value::Array(entries) = value
                    && entries.len() == all
                {
                    let mut shown = shows.iter();
                    entries.retain(|_| shown.next().copied().unwrap_or(true));
                }
            }
            candidate.search *= kept as f64 / all as f64;
            fitted = fit(&candidate)?;
        }
    }
    inquiry.sharpen_times(&mut fitted);
    let runs = inquiry.twin.runs.runs.iter().filter(|run| !run.clean).count();
    if let Some((cause, _)) = fitted.state.effects.last()
        && let [own] = &mut candidate.causes[..]
        && let (Cause::Switch(..), Cause::Switch(_, times)) = (&*own, cause)
    {
        let at: Vec<_> = times.iter().take(runs).map(|at| at.is_finite().then_some(at)).collect();
        candidate.detail.insert("at_s".to_owned(), json!(at));
        *own = cause.clone();
    }
    let charged = fitted.loss + charge(&candidate);
    Some(Rival { candidate, fitted, charged })
}

/// As [`charge`] when a run is left out: what it was searched for in that run costs nothing.
fn charge_without(candidate: &Candidate, run: usize) -> f64 {
    let there = candidate.causes.iter().filter(|cause| cause.run() == Some(run)).count() as f64;
    charge(candidate) * (1.0 - there / candidate.causes.len().max(1) as f64)
}

/// Rivals whose shape is searched for between those of the dictionary.
const SHARPENED: usize = 3;

/// Searches the shapes of the best rivals: widths, time constants and times between those of the dictionary.
fn sharpen<const N: usize>(inquiry: &Inquiry<'_, N>, state: &State, rivals: &mut [Rival]) {
    let mut seen: Vec<String> = Vec::new();
    for rival in rivals.iter_mut() {
        let ([cause], Some(key)) = (&rival.candidate.causes[..], rival.candidate.shape) else { continue };
        let Some(shape) = cause.shape() else { continue };
        if seen.len() >= SHARPENED || seen.contains(&rival.candidate.id) {
            continue;
        }
        seen.push(rival.candidate.id.clone());
        let coefficient = rival.coefficients()[0];
        let cause = cause.clone();
        // Times are known to their grid, the others to a factor of two.
        let (mut low, mut high) = match key {
            "at_s" => (shape - 1.5, shape + 1.5),
            "hold_s" => (0.5 * shape - 0.5, 2.0 * shape + 0.5),
            _ => (0.5 * shape, 2.0 * shape),
        };
        let mut best: Option<(f64, Fitted)> = None;
        for _ in 0..SEARCH_STEPS {
            let (left, right) = ((2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0);
            let at = |shape: f64| inquiry.fit(state, &[(cause.with_shape(shape), coefficient)], 2);
            let (Some(at_left), Some(at_right)) = (at(left), at(right)) else { break };
            if at_left.loss < at_right.loss {
                high = right
            } else {
                low = left
            }
            for (shape, fitted) in [(left, at_left), (right, at_right)] {
                if best.as_ref().is_none_or(|(_, best)| fitted.loss < best.loss) {
                    best = Some((shape, fitted));
                }
            }
        }
        if let Some((shape, fitted)) = best
            && fitted.loss < rival.fitted.loss
        {
            rival.candidate.causes = vec![cause.with_shape(shape)];
            rival.candidate.detail.insert(key.to_owned(), json!(shape));
            rival.charged = fitted.loss + charge(&rival.candidate);
            rival.fitted = fitted;
        }
    }
    rivals.sort_by(|a, b| a.charged.total_cmp(&b.charged));
}

/// Steps of the search: each leaves two thirds of the interval.
const SEARCH_STEPS: usize = 5;

/// Whether a rival is not significantly worse.
fn is_tie(winner: &Rival, rival: &Rival, gain: f64) -> bool {
    let differences: Vec<f64> =
        rival.fitted.run_losses.iter().zip(&winner.fitted.run_losses).map(|(r, w)| r - w).collect();
    let count = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / count;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    let error = (count * variance).sqrt();
    let worse = rival.charged - winner.charged;
    worse < TIE_LOSS + TIE_SHARE * gain && worse < TIE_ERRORS * error.max(1e-9)
}

impl Report {
    /// The gap that is closed on locked runs, if it could be tested.
    pub fn gap_closed(&self) -> Option<f64> {
        self.confirmed.closed
    }

    /// The base's parameters before and after.
    pub fn base_moves(&self) -> Value {
        let names = crate::fit::verdict::TORQUE;
        let [before, after] = self.base.map(TorqueModel::to_array);
        let moves = names.iter().zip(before.iter().zip(after));
        Value::Object(
            moves
                .map(|(d, (before, after))| (d.name.to_owned(), json!({"before": before, "after": after})))
                .collect(),
        )
    }
}
