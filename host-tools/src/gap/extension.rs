//! The coefficients with the effects that were named, written for estimator and board, and what they are worth: the covariance of base
//! and effects, and the noise that mass estimates have to expect.

use std::path::Path;

use model_core::payload::Noise;
use nalgebra::{DMatrix, DVector};

use super::report::Report;
use super::twin::{State, Twin};
use crate::coefficients::{CoefficientsFile, InvalidCoefficients};
use crate::effects::Regressor;
use crate::effects::written::Written;
use crate::error::{Error, Result};
use crate::log::runs::Runs;
use crate::numerics::robust::{NORMAL_95, median, quantile, scale_of_sizes};

/// Windows over which an error that lasts is judged, s: as a fit's are.
const WINDOW_S: f64 = 10.0;

/// Blocks in which the scatter of mass scores is measured, s: as a fit's are.
const BLOCK_S: f64 = 2.0;

/// Blocks with less than this share of the most informative one's information are left out.
const LEAST_SHARE: f64 = 0.01;

/// Writes the coefficients with the effects that were named, and the base as it moved. What is not written is said in a line each on
/// standard error; where nothing is left, so is the file.
///
/// # Errors
/// The file cannot be written; the effects are more than a board holds.
pub fn write<const N: usize>(
    runs: &Runs<N>,
    report: &Report,
    base: &CoefficientsFile<N>,
    out: &Path,
) -> Result<()> {
    let written: Vec<_> = report
        .effects
        .iter()
        .map(|named| Written::of(&named.candidate, &named.coefficients, &named.std_errs))
        .collect();
    let kept: Vec<bool> = written.iter().map(std::result::Result::is_ok).collect();
    for why in written.iter().filter_map(|effect| effect.as_ref().err()) {
        eprintln!("gmr: {why}");
    }
    if !kept.contains(&true) {
        eprintln!("gmr: {}: not written: no effect is to be added", out.display());
        return Ok(());
    }
    if !report.ambiguous_with.is_empty() {
        eprintln!(
            "gmr: {}: its effects cannot be told from {}: power is predicted as well with either, the cause is open",
            out.display(),
            report.ambiguous_with.join(", ")
        );
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

/// What is known of an extended model.
#[derive(Debug, Clone, PartialEq)]
pub struct Extension {
    /// Of the base's parameters, then of the coefficients that are kept.
    pub covariance: DMatrix<f64>,
    /// What mass estimates have to expect.
    pub noise: Noise<f64>,
}

/// Of the open runs of a report. `kept` says of each named effect whether it is added to the model: findings about runs are not. `base`
/// is the noise of the model without effects, of which the extended one never has less.
pub fn of<const N: usize>(
    runs: &Runs<N>,
    report: &Report,
    kept: &[bool],
    base: &Noise<f64>,
) -> Option<Extension> {
    let (joint, drive) = (report.covariance.as_ref()?, report.basis.as_ref()?.drive);
    let open = runs.subset(&report.split.open);
    // Estimators know of no lag.
    let twin = Twin { runs: &open, drive, lag: 0.0 };
    let parameters = joint.nrows() - report.state.effects.len();
    let columns = report
        .effects
        .iter()
        .zip(kept)
        .flat_map(|(named, kept)| std::iter::repeat_n(*kept, named.candidate.regressors.len()));
    let kept: Vec<usize> = columns.enumerate().filter(|(_, kept)| *kept).map(|(column, _)| column).collect();
    let places: Vec<usize> = (0..parameters).chain(kept.iter().map(|column| parameters + column)).collect();
    let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| joint[(places[i], places[j])]);
    let mut windows = Windows { covariance: &covariance, base, errors: Vec::new(), blocks: Vec::new() };
    for place in 0..open.runs.len() {
        windows.see(&twin, place, &report.state, parameters, &kept);
    }
    let noise = windows.noise(open.period_s);
    Some(Extension { covariance, noise })
}

/// Sums over windows and blocks of all runs.
struct Windows<'a> {
    covariance: &'a DMatrix<f64>,
    base: &'a Noise<f64>,
    /// The lasting error of each window, W.
    errors: Vec<f64>,
    /// Score and information of each block.
    blocks: Vec<(f64, f64)>,
}

impl Windows<'_> {
    fn see<const N: usize>(
        &mut self,
        twin: &Twin<'_, N>,
        place: usize,
        state: &State,
        parameters: usize,
        kept: &[usize],
    ) {
        let predicted = twin.predict(place, state);
        let by_mass = twin.effect_slope(place, state, &Regressor::Masses, &predicted);
        let mut slopes = twin.base_slopes(place, state, &predicted, parameters);
        slopes.extend(
            kept.iter().map(|&column| twin.effect_slope(place, state, &state.effects[column].0, &predicted)),
        );
        let rows = &twin.runs.runs[place].rows;
        let mut windows: Vec<(DVector<f64>, f64)> = Vec::new();
        let mut blocks: Vec<(f64, f64)> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let slope = self.base.weight(predicted[index]) * by_mass[index];
            let window = (row.time / WINDOW_S) as usize;
            windows.resize(windows.len().max(window + 1), (DVector::zeros(slopes.len()), 0.0));
            windows[window].0 += DVector::from_fn(slopes.len(), |i, _| slope * slopes[i][index]);
            windows[window].1 += slope;
            let block = (row.time / BLOCK_S) as usize;
            blocks.resize(blocks.len().max(block + 1), (0.0, 0.0));
            blocks[block].0 += slope * (row.power - predicted[index]);
            blocks[block].1 += slope * by_mass[index];
        }
        let told = windows.iter().filter(|(_, slope)| *slope != 0.0);
        let error = |(score, slope): &(DVector<f64>, f64)| {
            (self.covariance * score).dot(score).max(0.0).sqrt() / slope.abs()
        };
        self.errors.extend(told.map(error));
        self.blocks.extend(blocks);
    }

    /// Never less than the base's own: what is left in the field is the scatter of a few runs.
    fn noise(mut self, period_s: f64) -> Noise<f64> {
        let mut noise = *self.base;
        if let Some(error) = median(&mut self.errors) {
            noise.model_std = noise.model_std.max(error);
        }
        let most = self.blocks.iter().map(|(_, information)| *information).fold(0.0, f64::max);
        let told = self.blocks.iter().filter(|(_, information)| *information > LEAST_SHARE * most);
        let mut sizes: Vec<f64> = told.map(|(score, information)| score.abs() / information.sqrt()).collect();
        if let (Some(rare), Some(usual)) = (quantile(&mut sizes, 0.95), scale_of_sizes(&mut sizes)) {
            noise.density = noise.density.max(period_s * usual * usual);
            noise.tail = noise.tail.max(rare / (NORMAL_95 * usual));
        }
        noise
    }
}

#[cfg(test)]
mod tests {
    use model_core::effects::{Cause, Term};
    use model_core::estimator::Sample;
    use model_core::torque::TorqueModel;

    use crate::effects::written::{Written, columns, id_of};
    use crate::effects::{ENTRIES, PITCH, PROCESSOR, Regressor};
    use crate::gap::dictionary::candidates;
    use crate::log::runs::{RawRun, Runs};
    use crate::robot::Robot;

    /// What the file's words mean is what the workflow fitted, for every candidate of the dictionary.
    #[test]
    fn every_candidate_is_written_as_what_it_was_fitted_as() {
        let runs = with_columns(&[PROCESSOR]);
        let warm = with_columns(&[PITCH, "motor1_temp_c", "motor2_temp_c"]);
        let base = TorqueModel::from_array([0.03, 0.01, 0.01, 0.003, 1.3, 3.0, 0.0]);
        let mut seen = Vec::new();
        for (runs, place) in [(&runs, 0), (&warm, 1)] {
            let (list, _) = candidates(runs, &base, false);
            for candidate in list {
                let coefficients = vec![0.001; candidate.regressors.len()];
                let expected: Vec<Option<Cause<f64>>> = candidate.regressors.iter().map(in_core).collect();
                let Ok(written) = Written::of(&candidate, &coefficients, &coefficients) else {
                    assert_eq!(candidate.id, "payload-mislabel", "{place}");
                    continue;
                };
                let text = toml::to_string(&written).unwrap();
                let read: Written = toml::from_str(&text).unwrap();
                assert_eq!(read, written, "{text}");
                let columns = columns(&[read], 2).unwrap();
                let found: Vec<Option<Cause<f64>>> =
                    columns.iter().map(|column| Some(column.cause)).collect();
                assert_eq!(found, expected, "{text}");
                for column in columns.iter() {
                    assert_eq!(id_of(&column.cause).0, written.id);
                }
                seen.push(written.id);
            }
        }
        // What only appears at times that were found: scan.rs.
        for entry in
            ENTRIES.iter().filter(|entry| !["payload-mislabel", "surface-switch"].contains(&entry.id))
        {
            assert!(seen.iter().any(|id| id == entry.id), "{}", entry.id);
        }
    }

    /// A run of 20 s with further columns.
    fn with_columns(columns: &[&str]) -> Runs<2> {
        let core = Robot::load("burger").unwrap().core::<2>(2.0).unwrap();
        let row = |i: usize| {
            let speed = 3.0 + (0.05 * i as f64).sin();
            let sample = Sample { wheel_speed: [speed, 2.0], wheel_acceleration: None, power: 1.0 };
            (0.05 * i as f64, sample, 2.0, vec![20.0; columns.len()])
        };
        let raw = RawRun {
            name: "run".to_owned(),
            rows: (0..400).map(row).collect(),
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            period_s: 0.05,
        };
        Runs::condition(&core, vec![raw]).unwrap()
    }

    /// By the regressors themselves, not by the words about them.
    fn in_core(regressor: &Regressor) -> Option<Cause<f64>> {
        Some(match regressor {
            // A board is not ahead of its time.
            Regressor::Term(Term::WithMotion(hold)) => Cause::Term(Term::WithMotion(hold.max(0.0))),
            Regressor::Term(term) => Cause::Term(*term),
            Regressor::Heat(time) => Cause::Heat(*time),
            Regressor::Hot => Cause::Hot,
            Regressor::Temperature(_, cold) => Cause::Temperature(*cold),
            Regressor::Delay => Cause::Delay,
            Regressor::Scale(side) => Cause::Scale(crate::gap::twin::side_of(*side)),
            Regressor::Column(_) => Cause::Term(Term::Driver),
            _ => return None,
        })
    }
}
