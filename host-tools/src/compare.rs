//! Every model and baseline on the same split.

use std::path::PathBuf;
use std::time::Instant as Clock;

use model_core::estimator::Conditioner;
use serde::Serialize;

use crate::baselines::{Baseline, Point};
use crate::error::{Error, Result};
use crate::estimate::{Payloads, Policy, PolicyKind, bucket_length, replay};
use crate::fit::dataset::{Dataset, Reading, Row, condition};
use crate::fit::{self, Method, ModelKind, pgd};
use crate::log::SampleReader;
use crate::metrics::{Metrics, Quality};
use crate::robot::Robot;

/// Where training ends and testing begins.
#[derive(Debug, Clone)]
pub enum Split {
    /// Logs of their own for both.
    Files {
        /// Logs to fit.
        train: Vec<PathBuf>,
        /// Logs to evaluate.
        test: Vec<PathBuf>,
    },
    /// Blocks of time of the same logs, every so many a test block.
    Blocks {
        /// The logs.
        files: Vec<PathBuf>,
        /// Length of a block, s; at most [`BLOCK_S`], and a sixth of the longest run, unless given.
        block_s: Option<f64>,
    },
}

/// Length of held-out blocks, s: longer than any correlation of filtered power, short enough for several kinds of driving.
pub const BLOCK_S: f64 = 5.0;

/// One in this many blocks is held out.
pub const HOLD_OUT: i64 = 3;

/// How a model got the mass of the test rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MassSource {
    /// From the log: the truth.
    Given,
    /// It found it itself, from speed and power.
    Estimated,
}

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Entry {
    /// The model.
    pub name: String,
    /// What it is.
    pub source: String,
    /// Where the mass came from.
    pub mass: MassSource,
    /// R², null where the power never changes.
    pub r2: Option<f64>,
    /// %, above the robot's floor.
    pub mape_percent: Option<f64>,
    /// W
    pub rmse_w: f64,
    /// Share of test samples above the floor.
    pub mape_share: f64,
    /// Samples compared.
    pub samples: u64,
    /// Time to fit, reading not included, s.
    pub fit_s: f64,
}

/// Measured and predicted power of one test row, W.
pub type Pair = (f64, f64);

/// A table, and for each entry the pairs to plot.
pub struct Comparison {
    /// One entry a model.
    pub entries: Vec<Entry>,
    /// For each entry measured and predicted power.
    pub pairs: Vec<Vec<Pair>>,
    /// Length of the payload window, s.
    pub window_s: f64,
    /// Rows to fit and to evaluate.
    pub train_rows: usize,
    /// Rows to fit and to evaluate.
    pub test_rows: usize,
}

/// Settings of a comparison.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Mass of logs that do not tell it, kg.
    pub mass_kg: f64,
    /// Payload window, s.
    pub window_s: f64,
    /// Also train the perceptron.
    pub perceptron: bool,
}

/// The models of this project and the paper, in the order of the table.
const MODELS: [(&str, &str, ModelKind, Method); 3] = [
    ("signed", "signed torque model (default)", ModelKind::Signed, Method::Physical),
    ("eq18", "Eq. 18, corrected", ModelKind::Eq18, Method::Nnls),
    ("eq18-published", "Eq. 18 as printed, Algorithm 1", ModelKind::Eq18Published, Method::Pgd),
];

/// Fits everything and evaluates it.
///
/// # Errors
/// A log that cannot be read, or data that determine no model.
pub fn compare<const N: usize>(robot: &Robot, split: &Split, settings: &Settings) -> Result<Comparison> {
    // Wrong usage even where this split has no use for a window.
    bucket_length(settings.window_s)?;
    let data = Data::<N>::read(robot, split, settings)?;
    let mut comparison = Comparison {
        entries: Vec::new(),
        pairs: Vec::new(),
        window_s: settings.window_s,
        train_rows: data.train.store.len(),
        test_rows: data.test.len(),
    };
    // Without at least two payloads to learn from and logs to replay, the mass cannot be estimated.
    let estimates = data.train.masses.len() > 1 && matches!(split, Split::Files { .. });
    for (name, source, kind, method) in MODELS {
        let training = data.train.with_gate(kind.gate());
        let fit = fit::fit(robot, &training, kind, method, &pgd::Settings::default())?;
        if let (true, Split::Files { test, .. }) = (estimates, split) {
            let mut pairs = Vec::new();
            let policy = Policy {
                window_s: settings.window_s,
                kind: PolicyKind::Moving,
                changes_s: Vec::new(),
                detect: kind == ModelKind::Signed,
            };
            let payloads = Payloads::default_for(&fit.coefficients.model);
            for file in test {
                replay(robot, &fit.coefficients, file, payloads, &policy, |instant| {
                    if let Some(predicted) = instant.predicted_w {
                        pairs.push((instant.measured_w, predicted));
                    }
                })?;
            }
            comparison.push(robot, name, source, MassSource::Estimated, fit.solve_s, pairs);
        }
        let model = &fit.coefficients.model;
        let predict = |row: &Row<N>| Some((row.power, model.power(&row.motion, row.mass)?));
        let pairs = data.test.iter().filter_map(predict).collect();
        let name = if estimates { format!("{name}, mass given") } else { name.to_owned() };
        comparison.push(robot, &name, source, MassSource::Given, fit.solve_s, pairs);
    }
    let point = |row: &Row<N>| Point::new(&data.train.robot, row);
    let training: Vec<Point> = data.train.store.iter().map(point).collect();
    let test: Vec<Point> = data.test.iter().map(point).collect();
    for mut baseline in baselines(settings) {
        let started = Clock::now();
        baseline.fit(&training)?;
        let fit_s = started.elapsed().as_secs_f64();
        let predicted = baseline.predict(&test)?;
        let pairs = test.iter().map(|point| point.power).zip(predicted).collect();
        comparison.push(robot, baseline.name(), baseline.source(), MassSource::Given, fit_s, pairs);
    }
    Ok(comparison)
}

fn baselines(settings: &Settings) -> Vec<Box<dyn Baseline>> {
    let linear: Box<dyn Baseline> = Box::new(crate::baselines::linear::Linear::default());
    std::iter::once(linear).chain(settings.perceptron.then(perceptron).flatten()).collect()
}

#[cfg(feature = "mlp")]
fn perceptron() -> Option<Box<dyn Baseline>> {
    Some(Box::new(crate::baselines::mlp::Mlp::default()))
}

#[cfg(not(feature = "mlp"))]
fn perceptron() -> Option<Box<dyn Baseline>> {
    eprintln!("gmr: built without the perceptron (feature mlp): it is left out of the table");
    None
}

impl Comparison {
    fn push(
        &mut self,
        robot: &Robot,
        name: &str,
        source: &str,
        mass: MassSource,
        fit_s: f64,
        pairs: Vec<Pair>,
    ) {
        let mut metrics = Metrics::new(robot.mape_floor_w());
        for (measured, predicted) in &pairs {
            metrics.add(*measured, *predicted);
        }
        let Some(Quality { r2, mape_percent, mape_share, rmse_w, samples, .. }) = metrics.quality() else {
            eprintln!("gmr: {name} is left out: it predicts no test sample (its mass was never known)");
            return;
        };
        self.entries.push(Entry {
            name: name.to_owned(),
            source: source.to_owned(),
            mass,
            r2,
            mape_percent,
            rmse_w,
            mape_share,
            samples,
            fit_s,
        });
        self.pairs.push(pairs);
    }
}

/// Training rows as a dataset, test rows behind the same filter.
struct Data<const N: usize> {
    train: Dataset<N>,
    test: Vec<Row<N>>,
}

impl<const N: usize> Data<N> {
    fn read(robot: &Robot, split: &Split, settings: &Settings) -> Result<Self> {
        let reading = |cutoff_hz| Reading {
            gate: model_core::eq18::Gate::Signed,
            cutoff_hz,
            mass_kg: settings.mass_kg,
        };
        match split {
            Split::Files { train, test } => {
                let train = Dataset::read(robot, train, &reading(None))?;
                let test = test_rows(robot, &train, test, settings.mass_kg)?;
                Ok(Self { train, test })
            }
            Split::Blocks { files, block_s } => {
                let mut train = Dataset::read(robot, files, &reading(None))?;
                let block_s = block_s.unwrap_or_else(|| BLOCK_S.min(longest_run(&train.store) / 6.0));
                let held_out = |row: &Row<N>| (row.time / block_s).floor() as i64 % HOLD_OUT == HOLD_OUT - 1;
                let (test, kept) = train.store.drain(..).partition(held_out);
                train.store = kept;
                let data = Self { train, test };
                if data.test.is_empty() || data.train.store.is_empty() {
                    return Err(Error::failed(format!(
                        "the log is too short to hold out blocks of {block_s} s; expected at least {} s",
                        HOLD_OUT as f64 * block_s
                    ))
                    .in_file(&files[0]));
                }
                Ok(data)
            }
        }
    }
}

/// Duration of the longest run, s.
fn longest_run<const N: usize>(rows: &[Row<N>]) -> f64 {
    let durations =
        rows.chunk_by(|a, b| a.run == b.run).filter_map(|run| Some(run.last()?.time - run.first()?.time));
    durations.fold(0.0, f64::max)
}

fn test_rows<const N: usize>(
    robot: &Robot,
    train: &Dataset<N>,
    files: &[PathBuf],
    mass_kg: f64,
) -> Result<Vec<Row<N>>> {
    let mut rows = Vec::new();
    for file in files {
        let mut reader = SampleReader::<N>::open(file, robot)?;
        let mut conditioner: Conditioner<f64, N> =
            fit::dataset::conditioner(&train.robot, file, reader.period_s())?;
        while let Some(raw) = reader.next_row()? {
            rows.extend(condition(&mut conditioner, &raw, mass_kg));
        }
        if reader.exclusions().total() > 0 {
            eprintln!("gmr: {}: {}", file.display(), reader.exclusions());
        }
    }
    if rows.is_empty() {
        return Err(Error::failed("no usable row to evaluate on").in_file(&files[0]));
    }
    Ok(rows)
}
