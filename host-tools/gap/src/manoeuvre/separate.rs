//! How well a drive would distinguish two hypotheses: the loss of the wrong one, fitted as well as
//! it can be.
//!
//! As in the workflow, the model may be wrong along smooth functions of the drive and along the
//! effects, in clean and field runs alike. Only clean runs distinguish that error from an effect:
//! where they have not been, no field drive distinguishes anything.

use std::mem::discriminant;

use logs::motions::Motions;
use logs::robot::chassis::PerWheel;
use logs::runs::{RawRun, Row, Run, Runs};
use logs::{RawSample, Shared};
use model::effects::Regressor;
use model_core::conditioning::Conditioning;
use model_core::effects::Term;
use nalgebra::{DMatrix, DVector};
use numerics::least_squares::{NormalEquations, Prior};
use support::error::Result;

use super::family::{Knots, at};
use super::limits::Limits;
use crate::report::{Basis, Rival};
use residuals::noise::whiten::Signal;
use residuals::predictor::{Predictor, State};
use residuals::smooth;
use residuals::thresholds::manoeuvre::{SAMPLES_PER_CUTOFF, SHAPE_STEP, SHAPE_UNCERTAINTY};
use residuals::thresholds::problem::RIDGE;

/// A drive as the filter would show it: rows without power.
///
/// # Errors
/// As [`Runs::condition`].
pub fn planned(field: &Runs, knots: &Knots, limits: &Limits, masses: &[f64]) -> Result<Runs> {
    let end = knots.last().map_or(0.0, |(time, _)| *time);
    // Rows as far apart as the whitener's.
    let divisor = (1..=8)
        .map(f64::from)
        .find(|divisor| field.period_s / divisor * SAMPLES_PER_CUTOFF * field.cutoffs.speed <= 1.0)
        .unwrap_or(8.0);
    let period_s = field.period_s / divisor;
    let wheels = field.robot.wheels();
    let run = |mass: &f64| {
        let rows = (0..=(end / period_s) as usize).map(|k| {
            let time = k as f64 * period_s;
            let mut speeds = limits.wheel_speeds(at(knots, time));
            let wheel_speed = PerWheel::new(wheels, |_| speeds.next().unwrap_or(0.0));
            (time, RawSample { wheel_speed, ..RawSample::default() }, *mass, Vec::new())
        });
        RawRun { name: "planned".to_owned(), rows: rows.collect(), columns: Vec::new(), period_s }
    };
    // The slip of a planned drive is unknown: it has none.
    let conditioning = Conditioning { true_slip: 0.0, ..*field.robot.conditioning() };
    field.condition_alike(&field.robot.with_conditioning(conditioning), masses.iter().map(run).collect())
}

/// Whether a drive can show this hypothesis: the values of other columns cannot be foreseen.
pub fn foreseen(hypothesis: &Rival) -> bool {
    hypothesis.candidate.regressors.iter().all(|regressor| match regressor {
        Regressor::Column(_) | Regressor::Temperature(..) => false,
        Regressor::Term(term) => !matches!(term, Term::GradeByPitch),
        _ => true,
    })
}

/// A hypothesis's state in future runs. Steps come in their middle; a step of single runs has its
/// mean size there. Payloads are put on scales.
fn to_come(state: &State, runs: &Runs) -> State {
    let longest = runs.runs.iter().filter_map(|run| run.rows.last()).map(|row| row.time).fold(0.0, f64::max);
    let mut coming = state.clone();
    let single = |of: &Term<f64>| {
        let same = |regressor: &Regressor| matches!(regressor, Regressor::InRun(_, term) if discriminant(term) == discriminant(of));
        let sizes: Vec<f64> =
            state.effects.iter().filter(|(regressor, _)| same(regressor)).map(|(_, c)| *c).collect();
        sizes.iter().sum::<f64>() / sizes.len().max(1) as f64
    };
    let mut seen = Vec::new();
    for (regressor, coefficient) in &mut coming.effects {
        match regressor {
            Regressor::Switch(_, times) => *times = vec![0.5 * longest; runs.runs.len()].into(),
            Regressor::InRun(_, term) if !seen.contains(&discriminant(term)) => {
                seen.push(discriminant(term));
                *coefficient = single(term);
                *regressor = Regressor::Term(*term).with_shape(0.5 * longest);
            }
            Regressor::InRun(run, _) | Regressor::Mass(run) => *run = usize::MAX,
            _ => {}
        }
    }
    coming
}

/// A shape that a hypothesis may adapt. Times of steps are not: each run has its own.
fn width(regressor: &Regressor) -> Option<f64> {
    match regressor {
        Regressor::Term(Term::StepAt(_) | Term::RollingFrom(_)) => None,
        other => other.shape(),
    }
}

/// What is known already: the open field runs, the clean runs, and the hypotheses that explain
/// them.
pub struct Ground<'a> {
    /// Open runs, then clean ones.
    pub runs: Runs,
    /// What predictions rest on.
    pub basis: &'a Basis,
    /// The hypotheses to be distinguished.
    pub hypotheses: &'a [Rival],
    /// Whether there are clean runs: without, the base moves instead of the discrepancy.
    pub has_clean: bool,
}

/// Sums of products of all columns: discrepancy, each hypothesis's effects and shapes, each
/// hypothesis's power.
#[derive(Debug, Clone)]
pub struct Products {
    sums: DMatrix<f64>,
    discrepancy: usize,
    /// First column of each hypothesis, number of its effects, and of its shapes, which follow.
    blocks: Vec<(usize, usize, usize)>,
}

impl Ground<'_> {
    /// Of the recorded runs, beside `planned` ones: smooth functions are scaled by the largest of
    /// all.
    pub fn known(&self, planned: &Runs) -> Products {
        // A planned drive has none of the logs' further columns.
        let all = self.runs.followed_by(planned);
        let count = self.runs.runs.len();
        let smooth = smooth::functions(&all);
        self.products(&all, &smooth, 0..count, false)
    }

    /// Of planned runs.
    pub fn of(&self, planned: &Runs) -> Products {
        let mut all = planned.clone();
        all.runs.push(self.anchor());
        let smooth = smooth::functions(&all);
        self.products(&all, &smooth, 0..planned.runs.len(), true)
    }

    /// A run of those rows by which smooth functions are scaled.
    fn anchor(&self) -> Run {
        let rows = || self.runs.runs.iter().flat_map(|run| &run.rows);
        let speed = |row: &Row| row.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>();
        let gain = |row: &Row| row.wheels.iter().map(|w| w.speed * w.acceleration).sum::<f64>().abs();
        let most = |value: &dyn Fn(&Row) -> f64| rows().max_by(|a, b| value(a).total_cmp(&value(b))).copied();
        let kept = [
            most(&speed),
            most(&gain),
            most(&|row| row.turn_rate.abs()),
            most(&|row| row.mass),
            most(&|row| -row.mass),
            most(&|row| row.time),
        ];
        let extras = vec![Shared::default(); self.runs.columns.len()];
        let rows = kept.into_iter().flatten().collect();
        Run { name: "anchor".to_owned(), rows, extras, motions: Motions::default().into(), clean: false }
    }

    fn products(
        &self,
        runs: &Runs,
        smooth: &[Signal],
        places: std::ops::Range<usize>,
        planned: bool,
    ) -> Products {
        // The model's error is in clean runs, too: effects show there as they would in the field.
        let mut bare = runs.clone();
        bare.runs.iter_mut().for_each(|run| run.clean = false);
        let predictor =
            Predictor { clean_delay: self.basis.clean_delay, ..Predictor::new(runs, self.basis.drive) };
        let field = Predictor { runs: &bare, ..predictor };
        let state = |rival: &Rival| if planned { to_come(&rival.state, runs) } else { rival.state.clone() };
        let states: Vec<State> = self.hypotheses.iter().map(state).collect();
        let base = self.basis.precision.nrows();
        let mut sums: Option<DMatrix<f64>> = None;
        let (mut discrepancy, mut blocks) = (0, Vec::new());
        for place in places {
            let mut columns: Vec<Vec<f64>> = Vec::new();
            let Some(first) = states.first() else { break };
            let start = State { torque: first.torque, effects: Vec::new() };
            let at = field.predict(place, &start);
            columns.extend(field.base_slopes(place, &start, &at, base));
            if self.has_clean {
                columns.extend(smooth.iter().map(|signal| signal[place].clone()));
                for (regressor, _) in states.iter().flat_map(|state| &state.effects) {
                    columns.push(field.effect_slope(place, &start, regressor, &at));
                }
            }
            discrepancy = columns.len();
            blocks.clear();
            let mut power = Vec::new();
            for state in &states {
                let at = predictor.predict(place, state);
                let from = columns.len();
                columns.extend(
                    state
                        .effects
                        .iter()
                        .map(|(regressor, _)| predictor.effect_slope(place, state, regressor, &at)),
                );
                let effects = columns.len() - from;
                for (effect, (regressor, _)) in state.effects.iter().enumerate() {
                    let Some(shape) = width(regressor) else { continue };
                    let mut moved = state.clone();
                    moved.effects[effect].0 = regressor.with_shape(shape * (1.0 + SHAPE_STEP));
                    let there = predictor.predict(place, &moved);
                    columns
                        .push(there.iter().zip(&at).map(|(there, at)| (there - at) / SHAPE_STEP).collect());
                }
                blocks.push((from, effects, columns.len() - from - effects));
                power.push(at);
            }
            columns.extend(power);
            let rows = runs.runs[place].rows.len();
            let white = columns.iter().flat_map(|column| {
                self.basis.whitener.apply_run(runs, place, column).into_iter().map(|x| x / self.basis.std_w)
            });
            let matrix = DMatrix::from_iterator(rows, columns.len(), white);
            let products = matrix.tr_mul(&matrix);
            sums = Some(sums.map_or_else(|| products.clone(), |sums| sums + &products));
        }
        Products { sums: sums.unwrap_or_else(|| DMatrix::zeros(0, 0)), discrepancy, blocks }
    }

    /// Standard errors by which each pair of hypotheses would differ: places of the two, and z.
    /// `weight`: runs for each planned one; `clean`: those without the effect. All that is known
    /// counts.
    pub fn separations(
        &self,
        known: &Products,
        planned: &Products,
        weight: f64,
        clean: f64,
    ) -> Vec<(usize, usize, f64)> {
        let mut total = &known.sums + weight * &planned.sums;
        // Without an effect only the model's error shows.
        let shape = (planned.discrepancy, planned.discrepancy);
        let mut wrong = total.view_mut((0, 0), shape);
        wrong += clean * planned.sums.view((0, 0), shape);
        let mut pairs = Vec::new();
        for i in 0..self.hypotheses.len() {
            for j in i + 1..self.hypotheses.len() {
                let z = self.least_loss(&total, known, i, j).min(self.least_loss(&total, known, j, i));
                pairs.push((i, j, z.max(0.0).sqrt()));
            }
        }
        pairs
    }

    /// The least χ² of a hypothesis where another is true.
    fn least_loss(&self, total: &DMatrix<f64>, of: &Products, truth: usize, hypothesis: usize) -> f64 {
        let powers = total.ncols() - self.hypotheses.len();
        let (first, effects, shapes) = of.blocks[hypothesis];
        let places: Vec<usize> = (0..of.discrepancy).chain(first..first + effects + shapes).collect();
        let size = places.len();
        let (a, b) = (powers + truth, powers + hypothesis);
        let whole = total[(a, a)] - 2.0 * total[(a, b)] + total[(b, b)];
        let right = DVector::from_fn(size, |i, _| total[(places[i], a)] - total[(places[i], b)]);
        let matrix = DMatrix::from_fn(size, size, |i, j| total[(places[i], places[j])]);
        let mut equations = NormalEquations::from_sums(matrix, right, whole);
        if !self.has_clean {
            let offset = DVector::zeros(self.basis.precision.nrows());
            equations.add_prior(&Prior { precision: self.basis.precision.clone(), offset });
        }
        for place in of.discrepancy + effects..size {
            equations.hold(place, SHAPE_UNCERTAINTY);
        }
        equations.factor(RIDGE).map_or(0.0, |factored| factored.loss())
    }
}
