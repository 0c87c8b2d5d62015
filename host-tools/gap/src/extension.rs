//! The coefficients with the named effects, for estimator and board, and their quality: the
//! covariance of base and effects, and the noise of mass estimates.

use std::path::Path;

use fit::assess::{BLOCK_S, WINDOW_S, scatter_of};
use logs::runs::Runs;
use model::coefficients::{CoefficientsFile, InvalidCoefficients};
use model::effects::Regressor;
use model::effects::written::Written;
use model_core::payload::{Noise, huber};
use nalgebra::{DMatrix, DVector};
use numerics::robust::median;
use support::context::Context;
use support::error::{Error, Result};

use super::report::Report;
use residuals::predictor::{Predictor, State};
use residuals::types::Named;

/// Writes the coefficients with the named effects, and the base as it moved. Each effect that is
/// not written gets a line on standard error; without any, no file is written.
///
/// # Errors
/// The file cannot be written; the effects are more than a board holds.
pub fn write(
    context: &Context,
    runs: &Runs,
    report: &Report,
    base: &CoefficientsFile,
    out: &Path,
) -> Result<()> {
    let (written, kept) = written(report);
    for why in written.iter().filter_map(|effect| effect.as_ref().err()) {
        context.notice(why);
    }
    if !kept.contains(&true) {
        context.notice(format_args!("{}: not written: no effect is to be added", out.display()));
        return Ok(());
    }
    if !report.ambiguous_with.is_empty() {
        context.notice(format_args!(
            "{}: its effects cannot be told from {}: power is predicted as well with either, the cause is open",
            out.display(),
            report.ambiguous_with.join(", ")
        ));
    }
    let extended =
        base.clone().with_torque(&report.state.torque).with_effects(written.into_iter().flatten().collect());
    let extended = extended.map_err(|wrong| Error::of(InvalidCoefficients::Effect(wrong)).in_file(out))?;
    let extended = match of(runs, report, &kept, &base.coefficients.noise) {
        Some(worth) => extended.with_joint_covariance(worth.covariance, worth.noise),
        None => extended,
    };
    extended.write(out)
}

/// The named effects as they are written, or why not; and whether each is.
pub fn written(report: &Report) -> (Vec<std::result::Result<Written, String>>, Vec<bool>) {
    let write = |named: &Named| Written::of(&named.candidate, &named.coefficients, &named.std_errs);
    let written: Vec<_> = report.effects.iter().map(write).collect();
    let kept = written.iter().map(std::result::Result::is_ok).collect();
    (written, kept)
}

/// What is known of an extended model.
#[derive(Debug, Clone, PartialEq)]
pub struct Extension {
    /// Of the base's parameters, then of the coefficients that are kept.
    pub covariance: DMatrix<f64>,
    /// Noise of mass estimates.
    pub noise: Noise<f64>,
}

/// Of the open runs of a report, conditioned as a board does it. `kept`: whether each named effect
/// is added to the model, which findings about runs are not. `base`: the noise without effects, the least that is returned.
pub fn of(runs: &Runs, report: &Report, kept: &[bool], base: &Noise<f64>) -> Option<Extension> {
    let (joint, drive) = (report.covariance.as_ref()?, report.basis.as_ref()?.drive);
    let open = runs.subset(&report.split.open);
    // Estimators correct no delay.
    let predictor = Predictor::new(&open, drive);
    let parameters = joint.nrows() - report.state.effects.len();
    let columns = report
        .effects
        .iter()
        .zip(kept)
        .flat_map(|(named, kept)| std::iter::repeat_n(*kept, named.candidate.regressors.len()));
    let kept: Vec<usize> = columns.enumerate().filter(|(_, kept)| *kept).map(|(column, _)| column).collect();
    let places: Vec<usize> = (0..parameters).chain(kept.iter().map(|column| parameters + column)).collect();
    let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| joint[(places[i], places[j])]);
    let linear_beyond = base.linear_beyond(open.robot.cutoff_hz());
    let mut windows =
        Windows { covariance: &covariance, base, linear_beyond, errors: Vec::new(), blocks: Vec::new() };
    for place in 0..open.runs.len() {
        windows.see(&predictor, place, &report.state, parameters, &kept);
    }
    let noise = windows.noise(open.period_s);
    Some(Extension { covariance, noise })
}

/// Sums over windows and blocks of all runs.
struct Windows<'a> {
    covariance: &'a DMatrix<f64>,
    base: &'a Noise<f64>,
    /// Residuals beyond this count linearly, W.
    linear_beyond: f64,
    /// The lasting error of each window, W.
    errors: Vec<f64>,
    /// Score and information of each block.
    blocks: Vec<(f64, f64)>,
}

impl Windows<'_> {
    fn see(
        &mut self,
        predictor: &Predictor<'_>,
        place: usize,
        state: &State,
        parameters: usize,
        kept: &[usize],
    ) {
        let predicted = predictor.predict(place, state);
        let by_mass = predictor.effect_slope(place, state, &Regressor::Masses, &predicted);
        let mut slopes = predictor.base_slopes(place, state, &predicted, parameters);
        slopes.extend(
            kept.iter()
                .map(|&column| predictor.effect_slope(place, state, &state.effects[column].0, &predicted)),
        );
        let rows = &predictor.runs.runs[place].rows;
        let mut windows: Vec<(DVector<f64>, f64)> = Vec::new();
        let mut blocks: Vec<(f64, f64)> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let error = row.power - predicted[index];
            let slope = huber(error, self.linear_beyond) * by_mass[index];
            let window = (row.time / WINDOW_S) as usize;
            windows.resize(windows.len().max(window + 1), (DVector::zeros(slopes.len()), 0.0));
            windows[window].0 += DVector::from_fn(slopes.len(), |i, _| slope * slopes[i][index]);
            windows[window].1 += slope;
            let block = (row.time / BLOCK_S) as usize;
            blocks.resize(blocks.len().max(block + 1), (0.0, 0.0));
            blocks[block].0 += slope * error;
            blocks[block].1 += slope * by_mass[index];
        }
        let informative = windows.iter().filter(|(_, slope)| *slope != 0.0);
        let error = |(score, slope): &(DVector<f64>, f64)| {
            (self.covariance * score).dot(score).max(0.0).sqrt() / slope.abs()
        };
        self.errors.extend(informative.map(error));
        self.blocks.extend(blocks);
    }

    /// At least the base's: the field is only a few runs.
    fn noise(mut self, period_s: f64) -> Noise<f64> {
        let mut noise = *self.base;
        if let Some(error) = median(&mut self.errors) {
            noise.model_std = noise.model_std.max(error);
        }
        if let Some((usual, tail)) = scatter_of(&self.blocks) {
            noise.density = noise.density.max(period_s * usual * usual);
            noise.tail = noise.tail.max(tail);
        }
        noise
    }
}
