//! Columns and sums of products, run by run.

use logs::robot::chassis::Together;
use logs::runs::Runs;
use model::effects::{Candidate, Regressor, Switched};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::evidence::Shape;
use super::functions::{Group, functions};
use super::predicted::Predicted;
use super::priors::LOOSE;
use super::rows::Kept;
use super::ways::{Way, switched, times, ways};
use residuals::noise::whiten::Signal;
use residuals::noise::{Memory, Noise};
use residuals::predictor::{Predictor, State};
use residuals::types::Base;

/// One run.
#[derive(Debug, Clone)]
pub struct RunProducts {
    /// Sum of its rows' weights.
    pub weight: f64,
    /// Measured, base and functions, whitened.
    white: DMatrix<f64>,
    /// Sums of products of these, then ways; in the field also masses and steps. In variances of the
    /// noise.
    pub products: DMatrix<f64>,
    /// Unit of its mass.
    pub mass_unit: f64,
    /// Times of steps that are tried in it alone, s.
    pub step_times: Vec<f64>,
}

/// All runs: those in question, then clean ones.
#[derive(Debug, Clone)]
pub struct Posed<'a> {
    /// Model and runs.
    pub predictor: Predictor<'a>,
    /// What it predicts.
    pub predicted: Predicted<'a>,
    /// The base, and effects that are known already.
    pub start: State,
    /// Size of these, standard deviations of the noise.
    pub known: f64,
    /// Columns.
    pub shape: Shape,
    /// The group of each function.
    pub groups: Vec<usize>,
    /// The ways.
    pub ways: Vec<Way>,
    /// What switches in a run, and its range.
    pub switches: Vec<(Switched, (f64, f64))>,
    /// Unit of each switch.
    pub switch_units: Vec<f64>,
    /// The rows that count.
    pub kept: Kept,
    /// Their noise.
    pub noise: Noise,
    /// Precision of the base's parameters, in units of their columns.
    pub base: DMatrix<f64>,
    /// Run by run.
    pub runs: Vec<RunProducts>,
    /// Usual power in motion, standard deviations of the noise.
    pub power: f64,
}

/// Runs that may all have effects, the clean ones too.
pub fn anywhere(runs: &Runs) -> Runs {
    let mut all = runs.clone();
    for run in &mut all.runs {
        run.clean = false;
    }
    all
}

impl<'a> Posed<'a> {
    /// Of a predictor with effects that are known already; `None` where the runs have no steady rows.
    pub fn new(
        predictor: Predictor<'a>,
        all: &'a Runs,
        (base, parameters): (&Base, usize),
        list: &[Candidate],
        removed: &[String],
        known: &[(Regressor, f64)],
    ) -> Option<Self> {
        let predicted = Predicted::new(predictor);
        let free = Predicted::new(Predictor { runs: all, ..predictor });
        let start = State { torque: base.torque, effects: known.to_vec() };
        let starts = [start.clone(), State { effects: Vec::new(), ..start.clone() }];
        let runs = &predictor.runs.runs;
        // Clean runs have none of what is known.
        let start_of = |run: usize| &starts[usize::from(runs[run].clean)];
        let power: Signal = (0..runs.len()).map(|run| predicted.power(run, &start)).collect();
        let kept = Kept::of(predictor.runs);
        let slips = !predictor.runs.robot.conditioning().slip.is_off();
        let regressors =
            if slips { &[Regressor::Delay, Regressor::HalfSlip][..] } else { &[Regressor::Delay] };
        let thin = |run: usize, values: &[f64]| kept.thin(run, values);
        let residual: Signal = (0..runs.len())
            .map(|run| {
                let rows = runs[run].rows.iter().zip(&power[run]);
                thin(run, &rows.map(|(row, predicted)| row.power - predicted).collect::<Vec<_>>())
            })
            .collect();
        let bases: Vec<Vec<Vec<f64>>> = (0..runs.len())
            .map(|run| {
                let slopes = free.base_slopes(run, start_of(run), parameters);
                let more = free.slopes(run, start_of(run), regressors);
                // How large what is known is stays open.
                let effects: Vec<Regressor> = known.iter().map(|(regressor, _)| regressor.clone()).collect();
                let of_known = predicted.slopes(run, &start, &effects);
                let all = slopes.into_iter().chain(more).chain(of_known);
                all.map(|values| thin(run, &values)).collect()
            })
            .collect();
        let (signals, groups): (Vec<Signal>, Vec<Group>) =
            functions(predictor.runs, &free, start_of, &power, list).into_iter().unzip();
        let functions: Vec<Vec<Vec<f64>>> = (0..runs.len())
            .map(|run| signals.iter().map(|signal| thin(run, &signal[run])).collect())
            .collect();
        let lengths: Vec<f64> = runs
            .iter()
            .filter(|run| !run.clean)
            .filter_map(|run| run.rows.last().map(|row| row.time))
            .collect();
        let mut ways = ways(list, removed, &lengths, base.torque.supplied_rolling());
        let switches = switched(slips, base.torque.supplied_rolling());
        let columns: Vec<(DMatrix<f64>, Vec<f64>)> = (0..runs.len())
            .into_par_iter()
            .map(|run| {
                let mut all: Vec<Vec<f64>> = vec![residual[run].clone()];
                all.extend(bases[run].iter().cloned());
                all.extend(functions[run].iter().cloned());
                for way in &ways {
                    let slopes = free.slopes(run, start_of(run), &way.candidate.regressors);
                    all.extend(slopes.iter().map(|slope| kept.thin(run, slope)));
                }
                let length = runs[run].rows.last().map_or(0.0, |row| row.time);
                let mut step_times = Vec::new();
                if !runs[run].clean {
                    step_times = times(length);
                    let alone = |what: Switched, time: f64| {
                        let mut times = vec![f64::INFINITY; runs.len()];
                        times[run] = time;
                        Regressor::Switch(what, times.into())
                    };
                    let steps = switches.iter().flat_map(|(what, _)| {
                        step_times.iter().map(|time| alone(*what, *time)).collect::<Vec<_>>()
                    });
                    let regressors: Vec<Regressor> =
                        [Regressor::Mass(run)].into_iter().chain(steps).collect();
                    let slopes = free.slopes(run, start_of(run), &regressors);
                    all.extend(slopes.iter().map(|slope| kept.thin(run, slope)));
                }
                let rows = residual[run].len();
                (DMatrix::from_iterator(rows, all.len(), all.into_iter().flatten()), step_times)
            })
            .collect();
        let shape = Shape { base: bases.first()?.len(), functions: signals.len() };
        let (mut matrices, step_times): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
        let count = ways.iter().map(|way| way.units.len()).sum::<usize>();
        let noise = noise_of(&kept, &matrices, shape, count);
        let std_w = noise.floor_w2.sqrt();
        if std_w.is_nan() || std_w <= 0.0 {
            return None;
        }
        let is_field = |run: &usize| !runs[*run].clean;
        let field: Vec<usize> = (0..runs.len()).filter(is_field).collect();
        let everywhere: Vec<usize> = (0..runs.len()).collect();
        let base_units = scale(&mut matrices, &everywhere, 1..shape.first(), std_w);
        scale(&mut matrices, &everywhere, shape.first()..shape.further(), std_w);
        let first = shape.further();
        let units = scale(&mut matrices, &field, first..first + count, std_w);
        for way in &mut ways {
            let range = way.columns();
            way.units.copy_from_slice(&units[range]);
        }
        let mass_place = first + count;
        let mut mass_units = vec![1.0; runs.len()];
        for &run in &field {
            mass_units[run] = scale(&mut matrices, &[run], mass_place..mass_place + 1, std_w)[0];
        }
        let unit = |kind| scale_steps(&mut matrices, &field, &step_times, mass_place + 1, kind, std_w);
        let switch_units = (0..switches.len()).map(unit).collect();
        let mut order = groups.clone();
        order.sort_unstable();
        order.dedup();
        let groups = groups.iter().map(|group| order.iter().position(|other| other == group).unwrap_or(0));
        let moving: Vec<f64> = runs
            .iter()
            .zip(&power)
            .flat_map(|(run, power)| {
                run.rows.iter().zip(power).filter(|(row, _)| row.wheels.is_moving()).map(|(_, p)| p.abs())
            })
            .collect();
        let usual = moving.iter().sum::<f64>() / moving.len().max(1) as f64;
        let runs: Vec<RunProducts> = matrices
            .into_par_iter()
            .zip(step_times)
            .enumerate()
            .map(|(run, (columns, step_times))| {
                let white = whitened(&noise, &kept, run, &columns);
                let products = white.tr_mul(&white);
                let weight = noise.weights[run].iter().map(|root| root * root).sum();
                let white = white.columns(0, shape.further()).into_owned();
                RunProducts { weight, white, products, mass_unit: mass_units[run], step_times }
            })
            .collect();
        let power = usual / std_w;
        let first = shape.base - known.len();
        let sizes = known.iter().zip(&base_units[first..]).map(|((_, c), unit)| (c * unit).powi(2));
        Some(Self {
            known: sizes.sum::<f64>().sqrt(),
            predictor,
            predicted,
            start,
            shape,
            groups: groups.collect(),
            ways,
            switches,
            switch_units,
            kept,
            noise,
            base: DMatrix::from_diagonal_element(shape.base, shape.base, LOOSE),
            runs,
            power,
        })
    }

    /// Whether a run is in question.
    pub fn is_field(&self, run: usize) -> bool {
        !self.predictor.runs.runs[run].clean
    }

    /// The column of a run's mass, the first of those that live in it alone; its steps follow.
    pub fn mass_column(&self) -> usize {
        self.shape.further() + self.ways.iter().map(|way| way.units.len()).sum::<usize>()
    }

    /// Columns of a run's own steps of one kind.
    pub fn steps(&self, run: usize, kind: usize) -> std::ops::Range<usize> {
        let count = self.runs[run].step_times.len();
        let first = self.mass_column() + 1 + kind * count;
        first..first + count
    }
}

impl Posed<'_> {
    /// Sums of products of what was measured in a run and further columns anew, base and functions
    /// as they were.
    pub fn products_with(&self, run: usize, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let old = &self.runs[run];
        let new = whitened(&self.noise, &self.kept, run, columns);
        let (base, further) = (self.shape.further() - 1, columns.ncols() - 1);
        let (inner, cross) = (new.tr_mul(&new), new.tr_mul(&old.white.columns(1, base)));
        // Measured and further columns on either side of base and functions.
        let mut all = DMatrix::zeros(1 + base + further, 1 + base + further);
        all.view_mut((1, 1), (base, base)).copy_from(&old.products.view((1, 1), (base, base)));
        let place = |k: usize| if k == 0 { 0 } else { base + k };
        for i in 0..=further {
            for j in 0..=further {
                all[(place(i), place(j))] = inner[(i, j)];
            }
            all.view_mut((place(i), 1), (1, base)).copy_from(&cross.row(i));
            all.view_mut((1, place(i)), (base, 1)).copy_from(&cross.row(i).transpose());
        }
        all
    }
}

/// Columns of a run, whitened.
fn whitened(noise: &Noise, kept: &Kept, run: usize, columns: &DMatrix<f64>) -> DMatrix<f64> {
    let rows = columns.nrows();
    let white =
        columns.as_slice().chunks(rows.max(1)).flat_map(|column| noise.whiten(&kept.runs, run, column));
    DMatrix::from_iterator(rows, columns.ncols(), white)
}

/// The noise that base, functions and ways leave: what differs in the field is not in clean runs.
fn noise_of(kept: &Kept, columns: &[DMatrix<f64>], shape: Shape, ways: usize) -> Noise {
    let of = |(run, columns): (usize, &DMatrix<f64>)| -> Vec<Vec<f64>> {
        let clean = kept.runs.runs[run].clean;
        let column = |place: usize| columns.column(place).as_slice().to_vec();
        let only = |shown: bool, place: usize| if shown { column(place) } else { vec![0.0; columns.nrows()] };
        let first = shape.first();
        let base = (1..first).map(column);
        let of_clean = (first..shape.further()).map(|place| only(clean, place));
        let of_field = (first..shape.further() + ways).map(|place| only(!clean, place));
        base.chain(of_clean).chain(of_field).chain([column(0)]).collect()
    };
    let columns: Vec<_> = columns.iter().enumerate().map(of).collect();
    let mut noise = Noise::estimate(&kept.runs, &columns, Memory::OfClean);
    noise.std_w *= noise.modelled().sqrt();
    noise
}

/// Scales columns so that their RMS over some runs is `std_w`; the units.
fn scale(
    matrices: &mut [DMatrix<f64>],
    runs: &[usize],
    columns: std::ops::Range<usize>,
    std_w: f64,
) -> Vec<f64> {
    let rows: f64 = runs.iter().map(|&run| matrices[run].nrows() as f64).sum();
    let mut units = Vec::new();
    for column in columns {
        let square: f64 = runs.iter().map(|&run| matrices[run].column(column).norm_squared()).sum();
        let unit = (square / rows.max(1.0)).sqrt() / std_w;
        let unit = if unit > 0.0 && unit.is_finite() { unit } else { 1.0 };
        for matrix in matrices.iter_mut().filter(|matrix| matrix.ncols() > column) {
            matrix.column_mut(column).unscale_mut(unit);
        }
        units.push(unit);
    }
    units
}

/// The same of the steps of one kind, by each run's first one, which lasts longest; their unit.
fn scale_steps(
    matrices: &mut [DMatrix<f64>],
    field: &[usize],
    step_times: &[Vec<f64>],
    first: usize,
    kind: usize,
    std_w: f64,
) -> f64 {
    let (mut square, mut rows) = (0.0, 0.0);
    for &run in field.iter().filter(|&&run| !step_times[run].is_empty()) {
        let column = matrices[run].column(first + kind * step_times[run].len());
        square += column.norm_squared();
        rows += column.len() as f64;
    }
    let unit = (square / f64::max(rows, 1.0)).sqrt() / std_w;
    let unit = if unit > 0.0 && unit.is_finite() { unit } else { 1.0 };
    for &run in field {
        let count = step_times[run].len();
        let mut steps = matrices[run].columns_mut(first + kind * count, count);
        steps.unscale_mut(unit);
    }
    unit
}
