//! The workflow: split, detect, localise, name, tie or abstain, add, repeat, confirm.

use super::detect::{misshape, structure};
use super::naming::name;
use super::opening::{open_inquiry, prior};

use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use serde_json::{Value, json};

use super::confirm::{self, Confirmed, Seen};
use super::dictionary::candidates;
use super::excess::Excess;
use super::inquiry::{Fitted, Rival};
use super::joint::Prior;
use super::lag;
use super::localise::{self, Cell};
use super::panel::residual;
use super::runs::Runs;
use super::split::{self, Split};
use super::twin::{State, Twin};
use super::user::UserCandidates;
use super::whiten::{Signal, Whitener};
use crate::effects::{Candidate, NotTestable};
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

/// Least gain of a further effect, as a share of what those before it gained.
const LEAST_FURTHER: f64 = 0.1;

/// |z| of an effect's column times something else beyond which the effect has not the shape of what is there, and the share of
/// the gain in χ² that comes on top: no term of the model is exact.
const SHAPE: f64 = 5.5;

const SHAPE_TOLERANCE: f64 = 0.006;

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
    let mut confirmed = confirm::on_locked(runs, &split, clean, base, &state, &inquiry, parameters);
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
            let range = from..from + candidate.regressors.len();
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

impl Report {
    /// The gap that is closed on locked runs, if it could be tested.
    pub fn gap_closed(&self) -> Option<f64> {
        self.confirmed.closed
    }

    /// The base's parameters before and after.
    pub fn base_moves(&self) -> Value {
        let names = crate::coefficients::TORQUE;
        let [before, after] = self.base.map(TorqueModel::to_array);
        let moves = names.iter().zip(before.iter().zip(after));
        Value::Object(
            moves
                .map(|(d, (before, after))| (d.name.to_owned(), json!({"before": before, "after": after})))
                .collect(),
        )
    }
}
