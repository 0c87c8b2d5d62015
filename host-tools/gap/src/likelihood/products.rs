//! Columns and sums of products, run by run.

use logs::robot::chassis::Together;
use logs::runs::Runs;
use model::effects::{Candidate, Regressor, Switched};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::evidence::Shape;
use super::functions::{Group, functions};
use super::noise::{Noise, Told};
use super::precision::Precision;
use super::predicted::Predicted;
use super::priors::LOOSE;
use super::rows::{Kept, kept};
use super::ways::{Way, switched, times, ways};
use residuals::noise::whiten::Signal;
use residuals::predictor::{Predictor, State};
use residuals::types::Base;

/// Added to the diagonal of scaled products, so that [`weigh`]'s columns may be alike.
const RIDGE: f64 = 1e-4;

/// One run.
#[derive(Debug, Clone)]
pub struct RunProducts {
    /// Which rows count.
    pub kept: Kept,
    /// Measured, base, functions, ways; in the field also masses and steps.
    pub columns: DMatrix<f64>,
    /// The noise of its rows.
    pub precision: Precision,
    /// Precision times measured, base and functions.
    solved: DMatrix<f64>,
    /// Sums of products, in variances of the noise.
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
    /// The noise.
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
        let kept = kept(predictor.runs);
        let slips = !predictor.runs.robot.conditioning().slip.is_off();
        let regressors =
            if slips { &[Regressor::Delay, Regressor::HalfSlip][..] } else { &[Regressor::Delay] };
        let thin = |run: usize, values: &[f64]| kept[run].thin(values);
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
        let thin_power: Signal = (0..runs.len()).map(|run| thin(run, &power[run])).collect();
        let (signals, groups): (Vec<Signal>, Vec<Group>) =
            functions(predictor.runs, &free, start_of, &power, list).into_iter().unzip();
        let functions: Vec<Vec<Vec<f64>>> = (0..runs.len())
            .map(|run| signals.iter().map(|signal| thin(run, &signal[run])).collect())
            .collect();
        let places: Vec<usize> = (0..runs.len()).filter(|&run| runs[run].clean).collect();
        let rough = few_columns(&places, &residual, &bases, &functions, &thin_power)?;
        let noise = Noise::told(
            &places
                .iter()
                .zip(&rough)
                .map(|(&run, residual)| Told { kept: &kept[run], power: &thin_power[run], residual })
                .collect::<Vec<_>>(),
        )?;
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
                    all.extend(slopes.iter().map(|slope| kept[run].thin(slope)));
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
                    all.extend(slopes.iter().map(|slope| kept[run].thin(slope)));
                }
                let rows = kept[run].rows.len();
                (DMatrix::from_iterator(rows, all.len(), all.into_iter().flatten()), step_times)
            })
            .collect();
        let shape = Shape { base: bases.first()?.len(), functions: signals.len() };
        let (mut matrices, step_times): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
        let is_field = |run: &usize| !runs[*run].clean;
        let field: Vec<usize> = (0..runs.len()).filter(is_field).collect();
        let everywhere: Vec<usize> = (0..runs.len()).collect();
        let base_units = scale(&mut matrices, &everywhere, 1..shape.first(), noise.std_w);
        scale(&mut matrices, &everywhere, shape.first()..shape.further(), noise.std_w);
        let count = ways.iter().map(|way| way.units.len()).sum::<usize>();
        let first = shape.further();
        let units = scale(&mut matrices, &field, first..first + count, noise.std_w);
        for way in &mut ways {
            let range = way.columns();
            way.units.copy_from_slice(&units[range]);
        }
        let mass_place = first + count;
        let mut mass_units = vec![1.0; runs.len()];
        for &run in &field {
            mass_units[run] = scale(&mut matrices, &[run], mass_place..mass_place + 1, noise.std_w)[0];
        }
        let unit = |kind| scale_steps(&mut matrices, &field, &step_times, mass_place + 1, kind, noise.std_w);
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
        let mut runs: Vec<RunProducts> = matrices
            .into_par_iter()
            .zip(step_times)
            .enumerate()
            .map(|(run, (columns, step_times))| {
                let precision = noise.precision(&kept[run], &thin_power[run]);
                let (solved, products) = solved_products(&columns, &precision, shape);
                let (kept, mass_unit) = (kept[run].clone(), mass_units[run]);
                RunProducts { kept, columns, precision, solved, products, mass_unit, step_times }
            })
            .collect();
        if noise.information() < 1.0 {
            weigh(&mut runs, &noise, shape, count, &|run| !predictor.runs.runs[run].clean);
        }
        let power = usual / noise.std_w;
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

impl RunProducts {
    /// Sums of products of what was measured and further columns anew, base and functions as they
    /// were.
    pub fn with(&self, columns: &DMatrix<f64>, shape: Shape) -> DMatrix<f64> {
        let (old, new) = (shape.further() - 1, columns.ncols());
        let inner = columns.transpose() * self.precision.inverse_times(columns);
        let cross = self.solved.columns(1, old).transpose() * columns;
        let mut all = DMatrix::zeros(old + new, old + new);
        all.view_mut((1, 1), (old, old)).copy_from(&self.products.view((1, 1), (old, old)));
        all[(0, 0)] = inner[(0, 0)];
        all.view_mut((1, 0), (old, 1)).copy_from(&cross.columns(0, 1));
        all.view_mut((0, 1), (1, old)).copy_from(&cross.columns(0, 1).transpose());
        let (first, further) = (shape.further(), new - 1);
        all.view_mut((1, first), (old, further)).copy_from(&cross.columns(1, further));
        all.view_mut((first, 1), (further, old)).copy_from(&cross.columns(1, further).transpose());
        all.view_mut((0, first), (1, further)).copy_from(&inner.view((0, 1), (1, further)));
        all.view_mut((first, 0), (further, 1)).copy_from(&inner.view((1, 0), (further, 1)));
        all.view_mut((first, first), (further, further)).copy_from(&inner.view((1, 1), (further, further)));
        all
    }
}

/// Precision times measured, base and functions, and sums of products.
fn solved_products(
    columns: &DMatrix<f64>,
    precision: &Precision,
    shape: Shape,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let solved = precision.inverse_times(columns);
    let products = columns.transpose() * &solved;
    (solved.columns(0, shape.further()).into_owned(), products)
}

/// What base and a few functions leave of the runs that tell of the noise. More functions, fitted
/// to six runs, would take their memory along.
fn few_columns(
    places: &[usize],
    residual: &Signal,
    bases: &[Vec<Vec<f64>>],
    functions: &[Vec<Vec<f64>>],
    power: &Signal,
) -> Option<Signal> {
    // Level, motion, speed and its square, turning, gain, time, mass.
    const FEW: [usize; 8] = [0, 1, 3, 4, 9, 21, 30, 26];
    let all: Vec<DMatrix<f64>> = places
        .iter()
        .map(|&run| {
            let few = FEW.iter().filter_map(|place| functions[run].get(*place));
            let columns: Vec<_> = [&residual[run]].into_iter().chain(&bases[run]).chain(few).collect();
            DMatrix::from_fn(power[run].len(), columns.len(), |row, column| columns[column][row])
        })
        .collect();
    let mut sum = DMatrix::zeros(all.first()?.ncols(), all.first()?.ncols());
    for run in &all {
        sum += run.transpose() * run;
    }
    let values = least_squares(&sum, 1e-9)?;
    Some(all.iter().map(|run| residual_of(run, &values)).collect())
}

/// Coefficients of all columns but the first, whose squares they make least; by scaled products
/// with a ridge.
fn least_squares(products: &DMatrix<f64>, ridge: f64) -> Option<nalgebra::DVector<f64>> {
    let count = products.ncols() - 1;
    let scales: Vec<f64> = (1..=count).map(|k| products[(k, k)].max(1e-300).sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        products[(1 + i, 1 + j)] / scales[i] / scales[j] + if i == j { ridge } else { 0.0 }
    });
    let right = nalgebra::DVector::from_fn(count, |i, _| products[(1 + i, 0)] / scales[i]);
    let mut values = nalgebra::Cholesky::new(scaled)?.solve(&right);
    values.iter_mut().zip(&scales).for_each(|(value, scale)| *value /= scale);
    Some(values)
}

fn residual_of(columns: &DMatrix<f64>, values: &nalgebra::DVector<f64>) -> Vec<f64> {
    let fit = columns.columns(1, values.len()) * values;
    (columns.column(0) - fit).as_slice().to_vec()
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

/// Student's weights, by what a flexible fit of clean and of field runs leaves.
fn weigh(
    runs: &mut [RunProducts],
    noise: &Noise,
    shape: Shape,
    ways: usize,
    is_field: &dyn Fn(usize) -> bool,
) {
    for field in [false, true] {
        let size = shape.further() + if field { ways } else { 0 };
        let places: Vec<usize> = (0..runs.len()).filter(|&run| is_field(run) == field).collect();
        let mut sum = DMatrix::zeros(size, size);
        for &run in &places {
            sum += runs[run].products.view((0, 0), (size, size));
        }
        let Some(values) = least_squares(&sum, RIDGE) else { continue };
        for &run in &places {
            let run = &mut runs[run];
            let residual = residual_of(&run.columns, &values);
            run.precision.weigh_by(noise, &residual);
            (run.solved, run.products) = solved_products(&run.columns, &run.precision, shape);
        }
    }
}
