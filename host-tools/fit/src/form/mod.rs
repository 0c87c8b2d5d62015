//! Which further terms the data carry: a delay between speeds and power, the slip memory of a
//! turn's scrub, unequal sides, a gear's loss by what passes it, a bridge's drop, true slip by a
//! gyro.
//!
//! Each is nested: without it the model is as it was. Each has numbers that no least squares can
//! give, so they are searched for on a grid, then refined. And each is taken only for what it gains
//! on data that its numbers have not seen: one run in three, or one block of time where there are
//! few runs, is held out at a time while grid and parameters are fitted to the others, and the
//! squared error of every block is compared with that of the model without the term. It is taken
//! where the mean gain is significantly above zero (by chance once in twenty) and at least
//! `LEAST_GAIN`.

mod candidate;
mod nested;
mod term;
#[cfg(test)]
mod tests;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model_core::torque::TorqueModel;
use numerics::intervals::mean_interval;
use numerics::robust::ONE_SIDED_95;
use serde::Serialize;

use self::candidate::{Errors, Problem, Trial, Unseen, free_terms};
pub use self::nested::Form;
pub use self::term::{TERMS, TERMS_WITH_GYRO, Term};
use super::physical::{MOST_STEPS, Solution};
use super::pilot::Pilots;

/// Fewer blocks tell nothing.
const LEAST_BLOCKS: usize = 6;

/// A term that takes away less of the held-out error is not worth its instructions on a board,
/// however surely it does.
const LEAST_GAIN: f64 = 0.01;

/// What one term changes is seen by the next: all are asked again where one was taken.
const ROUNDS: usize = 2;

/// What held-out blocks said of a term.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Judged {
    /// Which.
    pub term: Term,
    /// Share of the held-out error (root mean square) that it takes away.
    pub gain: f64,
    /// Its standard error, from block to block.
    pub std_err: Option<f64>,
    /// Whether the fit has it.
    pub taken: bool,
}

/// The terms, and what was said of each.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Choice {
    /// What was taken.
    pub form: Form,
    /// One entry a term that was asked; empty where the logs are too short to hold out blocks.
    pub judged: Vec<Judged>,
    /// Steps of a search so long that no term was asked; `None` as a rule.
    pub long_search: Option<u32>,
}

/// Chooses among `terms` by the first rows of the logs, those of `held_out` times (s) left out:
/// they are to judge the whole fit. It begins with what `core` and a `known` model of the same rows
/// have already.
pub(super) fn choose(
    robot: &Robot,
    core: &Chassis,
    terms: &[Term],
    pilots: &Pilots,
    held_out: &(dyn Fn(f64) -> bool + Sync),
    known: Option<&TorqueModel<f64>>,
) -> Choice {
    let mut plain = Problem::new(robot, core, pilots, held_out, known);
    let form = Form { conditioning: *core.conditioning(), free_terms: free_terms(known) };
    let mut choice = Choice { form, judged: Vec::new(), long_search: None };
    if plain.folds.len() < LEAST_BLOCKS {
        return choice;
    }
    // A term is judged by what two searches leave, and these would have no end.
    if plain.steps > MOST_STEPS {
        return Choice { long_search: Some(plain.steps), ..choice };
    }
    let turning = if terms.contains(&Term::TrueSlip) { pilots.with_gyro() } else { None };
    let turning = turning.as_ref().map(|pilots| Problem::new(robot, core, pilots, held_out, known));
    let mut turning = turning.filter(|problem| problem.folds.len() >= LEAST_BLOCKS);
    // The form without the next term, which takes a search from all starts where no model is known:
    // once for all terms that are judged on the same rows (with a gyro or not) and folds (by their
    // numbers or parameters).
    let mut currents: Vec<([bool; 2], Trial)> = Vec::new();
    for _ in 0..ROUNDS {
        let mut took = false;
        for &term in terms {
            let asked = if term == Term::TrueSlip { turning.as_ref() } else { Some(&plain) };
            let Some(problem) = asked else { continue };
            let unseen = term.unseen(core);
            let alike = [term == Term::TrueSlip, unseen == Unseen::Numbers];
            let known = currents.iter().position(|(of, _)| *of == alike);
            let place = if let Some(place) = known {
                place
            } else {
                let Some(trial) = problem.trial(&choice.form, unseen, None) else { continue };
                currents.push((alike, trial));
                currents.len() - 1
            };
            let current = &currents[place].1;
            let Some((form, with)) = term.best(problem, &choice.form, current) else { continue };
            let judged = judge(term, &current.errors, &with);
            took |= judged.taken;
            match choice.judged.iter_mut().find(|earlier| earlier.term == term) {
                Some(earlier) if earlier.taken && !judged.taken => {}
                Some(earlier) => *earlier = judged,
                None => choice.judged.push(judged),
            }
            if judged.taken {
                choice.form = form;
                plain.weigh_by(&form, current);
                if let Some(turning) = &mut turning {
                    turning.weigh_by(&form, current);
                }
                currents.clear();
            }
        }
        if !took {
            break;
        }
    }
    choice
}

/// Drops what a fit to all rows leaves out again.
pub(super) fn keep_what_stays(judged: &mut Vec<Judged>, solution: &Solution) {
    if solution.unusable_gear_loss().is_some() {
        judged.retain(|judged| judged.term != Term::GearLoss);
    }
}

/// Block by block.
fn judge(term: Term, without: &Errors, with: &Errors) -> Judged {
    let pairs = without.iter().filter_map(|(block, error)| Some((error - with.get(block)?, *error)));
    let (gains, errors): (Vec<f64>, Vec<f64>) = pairs.unzip();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let gain = gains.iter().sum::<f64>() / errors.iter().sum::<f64>();
    // A ratio of sums over blocks of unlike size (Cochran 1977, Section 2.11).
    let about = gains.iter().zip(&errors).map(|(of_block, error)| (of_block - gain * error) / mean);
    let std_err = mean_interval(&about.collect::<Vec<f64>>()).std_err();
    let taken = gain >= LEAST_GAIN && std_err.is_some_and(|error| gain > ONE_SIDED_95 * error);
    Judged { term, gain, std_err, taken }
}
