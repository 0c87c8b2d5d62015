//! The terms, and where each is looked for.

use logs::robot::chassis::Chassis;
use model_core::conditioning::Conditioning;
use model_core::delay::DelayLine;
use model_core::slip::SlipMemory;
use numerics::search::golden_section;
use rayon::prelude::*;
use serde::Serialize;

use super::super::physical::{self, FreeTerms, Parameters};
use super::LEAST_GAIN;
use super::candidate::{Errors, FOLDS, Problem, Trial, Unseen};
use super::nested::Form;

/// One further term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Term {
    /// The power is later than the speeds.
    Delay,
    /// The scrub of a turn builds up with the distance rolled and saturates.
    SlipMemory,
    /// The sides' Coulomb torques differ.
    UnequalSides,
    /// The gear takes a share of what passes it, in either direction: of the load, or of the load
    /// and the friction.
    GearLoss,
    /// The bridge takes a voltage from whatever current passes it.
    BridgeDrop,
    /// What the wheels truly slip, by a gyro, adds to the scrub.
    TrueSlip,
}

/// In the order in which they are asked: the drop last, since it makes up for what else is missing.
pub const TERMS: [Term; 5] =
    [Term::Delay, Term::SlipMemory, Term::UnequalSides, Term::GearLoss, Term::BridgeDrop];

/// The same where logs may have a gyro, and whoever uses the fit has one.
pub const TERMS_WITH_GYRO: [Term; 6] =
    [Term::Delay, Term::SlipMemory, Term::UnequalSides, Term::GearLoss, Term::TrueSlip, Term::BridgeDrop];

/// Delays that are tried lie this far apart, s,
const DELAY_STEP_S: f64 = 0.05;
/// from so many steps before
const EARLIEST: i32 = -4;
/// to so many after the speeds: half a second.
const LATEST: i32 = 10;

/// Slips at half of the scrub that are tried: rubber on hard ground to loose soil.
const HALF_SLIPS: [f64; 6] = [0.01, 0.03, 0.1, 0.2, 0.4, 1.0];
/// Relaxation lengths that are tried, rad of the wheel: from a tenth of a radius to three turns.
const RELAXATIONS: [f64; 5] = [0.1, 0.5, 1.5, 5.0, 20.0];

/// Shares of the scrub per rad/s of true slip that are tried, s/rad: wheels slip by some rad/s at
/// most, so from what is hardly seen to what leaves next to nothing of the scrub that speeds alone
/// tell.
const TRUE_SLIPS: [f64; 6] = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0];

/// Shares of the friction that pass a gear with a loss of its own: the motor's friction does not,
/// the wheel's does. A mixture would have to be told from the loss itself.
const FRICTION_SHARES: [f64; 2] = [0.0, 1.0];

/// Refinements end at this share of the interval between neighbours of the grid.
const REFINED: f64 = 0.05;
/// Within which factors the numbers of a slip memory are sought, round by round: neighbours of the
/// grid are up to four apart, and what is left of one round's steps makes up for another term.
const MEMORY_WITHIN: [f64; 3] = [4.0, 2.0, 1.3];

impl Term {
    /// What of it has to be found without the block that judges it.
    pub(super) fn unseen(self, core: &Chassis) -> Unseen {
        match self {
            Self::Delay => Unseen::Numbers,
            Self::SlipMemory if core.scrubs() => Unseen::Numbers,
            _ => Unseen::Parameters,
        }
    }

    /// The form with the term at its best, and its errors on blocks that it had not seen. `None`
    /// where the robot cannot have it or the grid holds nothing.
    pub(super) fn best(self, problem: &Problem<'_>, form: &Form, current: &Trial) -> Option<(Form, Errors)> {
        let unseen = self.unseen(problem.core);
        let grid = self.grid(problem, form);
        let tried: Vec<(Form, Trial)> = grid
            .into_par_iter()
            .map(|form| Some((form, problem.trial(&form, unseen, Some(current))?)))
            .collect::<Vec<_>>()
            .into_iter()
            .flatten()
            .filter(|(form, trial)| is_taken_by_boards(form, trial, problem))
            .collect();
        // For each fold the one that fits its training blocks best: the held-out ones have no say.
        let of_fold = |fold: usize| {
            tried
                .iter()
                .min_by(|(_, a), (_, b)| a.fitted[fold].total_cmp(&b.fitted[fold]))
                .map(|(_, trial)| trial)
        };
        let sum = |trial: &Trial| trial.fitted.iter().sum::<f64>();
        let (best, together) = tried.iter().min_by(|(_, a), (_, b)| sum(a).total_cmp(&sum(b)))?;
        let mut errors = Errors::new();
        for fold in 0..FOLDS {
            let by_block = of_fold(fold)?.errors.iter();
            errors.extend(
                by_block
                    .filter(|(block, _)| problem.folds.get(block) == Some(&fold))
                    .map(|(block, error)| (*block, *error)),
            );
        }
        let refined = self.refine(problem, *best, &together.parameters[0]);
        Some((refined, errors))
    }

    /// The forms to try.
    fn grid(self, problem: &Problem<'_>, form: &Form) -> Vec<Form> {
        let with = |conditioning: Conditioning<f64>| Form { conditioning, ..*form };
        let two_sided = problem.core.has_sides();
        match self {
            Self::Delay => {
                let fastest = problem.pilots.fastest_s();
                let now = form.conditioning.delay;
                let delays = delays(now, problem.pilots.slowest_s()).into_iter();
                let others = delays.filter(|delay| (delay - now).abs() > 0.1 * DELAY_STEP_S);
                let reachable = others.filter(|delay| DelayLine::<f64, 1>::reaches(*delay, fastest));
                reachable.map(|delay| with(Conditioning { delay, ..form.conditioning })).collect()
            }
            Self::SlipMemory if two_sided => {
                let pairs =
                    HALF_SLIPS.into_iter().flat_map(|c| RELAXATIONS.map(|relaxation| (c, relaxation)));
                pairs
                    .map(|(half_slip, relaxation)| {
                        let slip = SlipMemory { half_slip, relaxation, rest: form.conditioning.slip.rest };
                        with(Conditioning { slip, ..form.conditioning })
                    })
                    .collect()
            }
            Self::UnequalSides if two_sided && !form.free_terms.unequal_sides => {
                vec![Form { free_terms: FreeTerms { unequal_sides: true, ..form.free_terms }, ..*form }]
            }
            // Asked again, the other form has to be better than the one that was taken.
            Self::GearLoss => {
                let losses = FRICTION_SHARES.into_iter().map(Some);
                let others = losses.filter(|gear_loss| *gear_loss != form.free_terms.gear_loss);
                let with = |gear_loss| FreeTerms { gear_loss, ..form.free_terms };
                others.map(|gear_loss| Form { free_terms: with(gear_loss), ..*form }).collect()
            }
            Self::BridgeDrop if !form.free_terms.bridge_drop => {
                vec![Form { free_terms: FreeTerms { bridge_drop: true, ..form.free_terms }, ..*form }]
            }
            // It adds to the scrub: where there is none the fit cannot distinguish its coefficient
            // from the scrub's.
            Self::TrueSlip if two_sided && (problem.core.scrubs() || !form.conditioning.slip.is_off()) => {
                let slips = TRUE_SLIPS.into_iter();
                slips.map(|true_slip| with(Conditioning { true_slip, ..form.conditioning })).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Its numbers between those that were tried.
    fn refine(self, problem: &Problem<'_>, mut form: Form, near: &Parameters) -> Form {
        let gaining = |form: &mut Form, least: f64, [low, high]: [f64; 2], set: fn(&mut Form, f64)| {
            let at = |value: f64| {
                let mut moved = *form;
                set(&mut moved, value);
                problem.cost(&moved, near)
            };
            // Of the squared error.
            let most = (1.0 - least).powi(2) * problem.cost(form, near);
            let optimum = golden_section(low, high, REFINED, at).filter(|optimum| optimum.cost < most);
            if let Some(optimum) = optimum {
                set(form, optimum.at);
            }
        };
        let along = |form: &mut Form, low: f64, high: f64, set: fn(&mut Form, f64)| {
            gaining(form, 0.0, [low, high], set);
        };
        let later = |form: &mut Form, by: f64| {
            let at = form.conditioning.delay;
            along(form, at - by, at + by, |form, delay| form.conditioning.delay = delay);
        };
        match self {
            Self::Delay => later(&mut form, DELAY_STEP_S),
            // The memory was fitted without losses of gear and bridge and compensated for them.
            Self::SlipMemory | Self::GearLoss | Self::BridgeDrop if !form.conditioning.slip.is_off() => {
                let rounds = if self == Self::SlipMemory { &MEMORY_WITHIN[..] } else { &MEMORY_WITHIN[1..] };
                for factor in rounds {
                    // It made up for what the form lacked.
                    if form.conditioning.delay != 0.0 {
                        later(&mut form, 0.5 * DELAY_STEP_S);
                    }
                    let SlipMemory { half_slip, relaxation, rest } = form.conditioning.slip;
                    let around = |value: f64| ((value / factor).ln(), (value * factor).ln());
                    let (low, high) = around(half_slip);
                    along(&mut form, low, high, |form, log| form.conditioning.slip.half_slip = log.exp());
                    let (low, high) = around(relaxation);
                    along(&mut form, low, high, |form, log| form.conditioning.slip.relaxation = log.exp());
                    // The dead band will do where another speed is not worth an image that older
                    // boards refuse.
                    let (here, least) =
                        if rest > 0.0 { (rest, 0.0) } else { (problem.core.dead_band(), LEAST_GAIN) };
                    let (low, high) = around(here);
                    gaining(&mut form, least, [low, high], |form, log| {
                        form.conditioning.slip.rest = log.exp();
                    });
                }
            }
            Self::SlipMemory | Self::GearLoss | Self::BridgeDrop | Self::UnequalSides => {}
            Self::TrueSlip => {
                // Neighbours of the grid are a factor of three apart; then to some percent.
                for factor in [4.0, 1.5] {
                    let true_slip = form.conditioning.true_slip;
                    let (low, high) = ((true_slip / factor).ln(), (true_slip * factor).ln());
                    along(&mut form, low, high, |form, log| form.conditioning.true_slip = log.exp());
                }
            }
        }
        form
    }
}

/// Delays to try besides the present one, s, of samples this far apart.
pub(super) fn delays(now: f64, sample_s: f64) -> Vec<f64> {
    // Speeds that are means of 50 ms are later than the power by half of that: a whole step to
    // either side would gain nothing. Whole samples only: between two of them interpolation
    // smooths, which gains where nothing is late.
    let half = (0.5 * DELAY_STEP_S / sample_s).round() * sample_s;
    let near = [now - half, now + half].into_iter().filter(|_| half < 0.9 * DELAY_STEP_S);
    (EARLIEST..=LATEST).map(|step| f64::from(step) * DELAY_STEP_S).chain(near).collect()
}

/// Friction drives no wheel on either side, even of the empty robot, and the gear passes enough:
/// boards refuse what says otherwise.
fn is_taken_by_boards(form: &Form, trial: &Trial, problem: &Problem<'_>) -> bool {
    let FreeTerms { unequal_sides, gear_loss, .. } = form.free_terms;
    let empty = problem.core.range().no_load();
    trial.parameters.iter().all(|fit| {
        let drags = !unequal_sides || physical::torque(fit).drags_on_both_sides(empty);
        drags && (gear_loss.is_none() || fit[physical::GEAR_LOSS] < physical::MOST_GEAR_LOSS)
    })
}
