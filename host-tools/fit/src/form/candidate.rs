//! One form of the model, fitted to two thirds of the blocks at a time and judged by the others.

use std::collections::{BTreeMap, BTreeSet};

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model_core::torque::TorqueModel;
use rayon::prelude::*;

use super::super::dataset::{Row, Rows, Stretch};
use super::super::physical::{self, Bounds, Descent, FreeTerms, Loss, Parameters};
use super::super::pilot::Pilots;
use super::nested::Form;

/// So many runs are blocks of their own: ground and payload differ from run to run, and what is
/// learned has to hold on the next.
const ENOUGH_RUNS: usize = 6;

/// Blocks that fewer runs are cut into, if that makes them no longer
const USUAL_BLOCKS: f64 = 24.0;
/// than this, s,
const MOST_BLOCK_S: f64 = 5.0;
/// nor shorter than this, s: the memory of a filter of 1 Hz.
const LEAST_BLOCK_S: f64 = 2.0;

/// One block in so many is held out at a time; every block once.
pub(super) const FOLDS: usize = 3;

/// Rows that take part in a trial.
const MOST_ROWS: usize = 6_000;

/// What forms are tried on.
pub(super) struct Problem<'a> {
    pub(super) robot: &'a Robot,
    /// With the filter's cutoff, without any further term.
    pub(super) core: &'a Chassis,
    pub(super) pilots: &'a Pilots,
    /// Times that are kept from all of this.
    held_out: &'a (dyn Fn(f64) -> bool + Sync),
    /// One for all forms of a term. It counts the rows less that are far off without the term.
    loss: Loss,
    /// Where searches begin; at all starts where nothing is known.
    known: Option<Parameters>,
    /// Steps to the plain form, over all starts.
    pub(super) steps: u32,
    /// Length of a block, s; infinite where a block is a whole run.
    block_s: f64,
    /// The fold that holds each block out; blocks of which nothing may be seen are in none.
    pub(super) folds: BTreeMap<Block, usize>,
}

/// A block of time of a run, or a whole run.
pub(super) type Block = (u32, i64);

/// Of every block: root mean square of the error, times its rows, W.
pub(super) type Errors = BTreeMap<Block, f64>;

/// What of a term is found without the block that judges it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unseen {
    /// Its own numbers; the parameters that the model has with and without it are those of all
    /// blocks on both sides.
    Numbers,
    /// Every parameter: the term brings one of its own.
    Parameters,
}

/// How a form did.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Of each fold the errors of the blocks that are not held out, W.
    pub(super) fitted: [f64; FOLDS],
    /// Of every block, while it was held out from what [`Unseen`] says.
    pub(super) errors: Errors,
    /// The parameters of each fold.
    pub(super) parameters: [Parameters; FOLDS],
}

impl<'a> Problem<'a> {
    /// Every block is in a fold, in turn. Of `held_out` times (s) nothing is seen: they are to
    /// judge the whole fit. The search begins at `known`, or at all starts where there is none.
    pub(super) fn new(
        robot: &'a Robot,
        core: &'a Chassis,
        pilots: &'a Pilots,
        held_out: &'a (dyn Fn(f64) -> bool + Sync),
        known: Option<&TorqueModel<f64>>,
    ) -> Self {
        let mut rows = pilots.condition(core, MOST_ROWS).unwrap_or_default();
        rows.retain(|row| !held_out(row.time));
        let open = rows.all().others();
        let runs = open.iter().map(|row| row.run).collect::<BTreeSet<_>>().len();
        let stretches = open.chunk_by(|a, b| a.run == b.run && b.time - a.time < LEAST_BLOCK_S);
        let open_s: f64 = stretches.map(|rows| rows[rows.len() - 1].time - rows[0].time).sum();
        let block_s = if runs >= ENOUGH_RUNS {
            f64::INFINITY
        } else {
            (open_s / USUAL_BLOCKS).clamp(LEAST_BLOCK_S, MOST_BLOCK_S)
        };
        let bounds = Bounds::of(core, rows.all(), robot.motor(), free_terms(known));
        let known = known.map(physical::parameters);
        let plain = physical::search(rows.all(), robot.drive(), Loss::Squares, &bounds, known.as_ref());
        let loss = physical::usual_loss(rows.all(), robot.drive(), &plain.parameters);
        let folds = dealt(open, block_s);
        Self { robot, core, pilots, held_out, loss, known, steps: plain.steps, block_s, folds }
    }

    /// Weighs rows by how far off they are by a form that was taken; the search starts at `near`.
    /// A late power leaves such large residuals that no row stands out.
    pub(super) fn weigh_by(&mut self, form: &Form, near: &Trial) {
        let Some((rows, _)) = self.rows(form) else { return };
        let (rows, drive) = (rows.all(), self.robot.drive());
        let bounds = Bounds::of(self.core, rows, self.robot.motor(), form.free_terms);
        let end = physical::search(rows, drive, Loss::Squares, &bounds, Some(&near.parameters[0]));
        self.loss = physical::usual_loss(rows, drive, &end.parameters);
    }

    /// The rows of a form, and the fold that holds each out.
    fn rows(&self, form: &Form) -> Option<(Rows, Vec<usize>)> {
        let core = self.core.with_conditioning(form.conditioning);
        let mut rows = self.pilots.condition(&core, MOST_ROWS)?;
        let fold = |row: &Row<()>| self.folds.get(&block(row, self.block_s)).copied();
        rows.retain(|row| !(self.held_out)(row.time) && fold(row).is_some());
        let folds = rows.all().others().iter().filter_map(fold).collect();
        Some((rows, folds))
    }

    /// Fits a form, from the parameters of `near`'s, or of the known model's where there is none.
    /// `None` where the logs cannot have the form, or hold nothing.
    pub(super) fn trial(&self, form: &Form, unseen: Unseen, near: Option<&Trial>) -> Option<Trial> {
        let (rows, folds) = self.rows(form)?;
        match unseen {
            Unseen::Numbers => self.shared(form, rows.all(), near),
            Unseen::Parameters => self.crossed(form, rows.all(), &folds, near),
        }
    }

    /// One fit for all folds.
    fn shared(&self, form: &Form, rows: Stretch<'_>, near: Option<&Trial>) -> Option<Trial> {
        let end = self.search(form, rows, near.map(|near| &near.parameters[0]));
        let errors = self.errors(rows, &end.parameters);
        let total: f64 = errors.values().sum();
        let of_fold = |fold: usize| {
            let in_fold = errors.iter().filter(|(block, _)| self.folds.get(block) == Some(&fold));
            in_fold.map(|(_, error)| error).sum::<f64>()
        };
        let fitted = std::array::from_fn(|fold| total - of_fold(fold));
        total.is_finite().then_some(Trial { fitted, errors, parameters: [end.parameters; FOLDS] })
    }

    /// A fit for each fold, to the others.
    fn crossed(
        &self,
        form: &Form,
        rows: Stretch<'_>,
        folds: &[usize],
        near: Option<&Trial>,
    ) -> Option<Trial> {
        let (mut fitted, mut parameters) = ([0.0; FOLDS], [Parameters::zeros(); FOLDS]);
        let mut errors = Errors::new();
        let without = |fold: usize| {
            let of = |held_out: bool| {
                let kept = rows.iter().zip(folds).filter(move |(_, of_row)| (**of_row == fold) == held_out);
                kept.map(|(row, _)| row).collect::<Rows>()
            };
            let (test, train) = (of(true), of(false));
            if test.is_empty() || train.is_empty() {
                return None;
            }
            let end = self.search(form, train.all(), near.map(|near| &near.parameters[fold]));
            let of_train: f64 = self.errors(train.all(), &end.parameters).values().sum();
            Some((of_train, end.parameters, self.errors(test.all(), &end.parameters)))
        };
        let ends = (0..FOLDS).into_par_iter().map(without).collect::<Option<Vec<_>>>()?;
        for (fold, (of_train, of_fold, of_test)) in ends.into_iter().enumerate() {
            fitted[fold] = of_train;
            parameters[fold] = of_fold;
            errors.extend(of_test);
        }
        fitted.iter().all(|error| error.is_finite()).then_some(Trial { fitted, errors, parameters })
    }

    fn search(&self, form: &Form, rows: Stretch<'_>, near: Option<&Parameters>) -> Descent {
        let bounds = Bounds::of(self.core, rows, self.robot.motor(), form.free_terms);
        physical::search(rows, self.robot.drive(), self.loss, &bounds, near.or(self.known.as_ref()))
    }

    fn errors(&self, rows: Stretch<'_>, parameters: &Parameters) -> Errors {
        let torque = physical::torque(parameters);
        let mut squares: BTreeMap<Block, (f64, f64)> = BTreeMap::new();
        for row in rows.iter() {
            let residual = row.power - physical::power(&torque, &row, self.robot.drive());
            let (square, count) = squares.entry(block(&row, self.block_s)).or_default();
            *square += residual * residual;
            *count += 1.0;
        }
        squares.into_iter().map(|(block, (square, count))| (block, (square * count).sqrt())).collect()
    }

    /// Cost of a form on all rows, W².
    pub(super) fn cost(&self, form: &Form, near: &Parameters) -> f64 {
        let Some((rows, _)) = self.rows(form) else { return f64::INFINITY };
        self.search(form, rows.all(), Some(near)).cost / rows.len().max(1) as f64
    }
}

/// The further terms that a known model has.
pub(super) fn free_terms(known: Option<&TorqueModel<f64>>) -> FreeTerms {
    known.map_or_else(FreeTerms::default, FreeTerms::of)
}

/// The blocks dealt out by how much their power varies, so that each fold has its share of every
/// kind of driving: in their order in time a manoeuvre that repeats would fall into one fold.
fn dealt(rows: &[Row<()>], block_s: f64) -> BTreeMap<Block, usize> {
    let mean = rows.iter().map(|row| row.power).sum::<f64>() / rows.len().max(1) as f64;
    let mut variation: BTreeMap<Block, f64> = BTreeMap::new();
    for row in rows {
        *variation.entry(block(row, block_s)).or_default() += (row.power - mean).powi(2);
    }
    let mut blocks: Vec<(Block, f64)> = variation.into_iter().collect();
    blocks.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    // There and back: 0 1 2 2 1 0 0 1 2 …
    let fold = |index: usize| (index % (2 * FOLDS)).min(2 * FOLDS - 1 - index % (2 * FOLDS));
    blocks.into_iter().enumerate().map(|(index, (block, _))| (block, fold(index))).collect()
}

fn block<W>(row: &Row<W>, block_s: f64) -> Block {
    (row.run, (row.time / block_s).floor() as i64)
}
