//! Every model and baseline on the same split.

pub mod points;

use std::path::PathBuf;
use std::time::Instant as Clock;

use serde::Serialize;

use self::points::Wanted;
use crate::baselines::{self, Card, Layout, Parameter, Point};
use crate::error::{Error, Result};
use crate::estimate::{Payloads, Policy, PolicyKind, bucket_length, replay};
use crate::fit::dataset::{Dataset, Reading, Row};
use crate::fit::{self, Method, ModelKind, pgd};
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
    /// It has no use for it.
    Unused,
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
    /// What a baseline has learned, where that has names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<Parameter>,
}

/// A model that is not in the table.
#[derive(Debug, Clone, Serialize)]
pub struct LeftOut {
    /// The model.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Measured and predicted power of one test row, W.
pub type Pair = (f64, f64);

/// A table, and for each entry the pairs to plot.
pub struct Comparison {
    /// One entry a model.
    pub entries: Vec<Entry>,
    /// For each entry measured and predicted power.
    pub pairs: Vec<Vec<Pair>>,
    /// Models that were asked for and cannot be had.
    pub left_out: Vec<LeftOut>,
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
    /// Names of the models to compare.
    pub models: Vec<&'static str>,
}

/// Every model's name: those of this project and the paper, then the baselines.
pub fn names() -> impl Iterator<Item = &'static str> {
    MODELS.iter().map(|(name, ..)| *name).chain(baselines::ALL.iter().map(|card| card.name))
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
        left_out: Vec::new(),
        window_s: settings.window_s,
        train_rows: data.train.store.len(),
        test_rows: data.test.len(),
    };
    // Without at least two payloads to learn from and logs to replay, the mass cannot be estimated.
    let estimates = data.train.masses.len() > 1 && matches!(split, Split::Files { .. });
    for (name, source, kind, method) in MODELS {
        if !settings.models.contains(&name) {
            continue;
        }
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
            comparison.push(robot, (name, source), MassSource::Estimated, fit.solve_s, Vec::new(), pairs);
        }
        let model = &fit.coefficients.model;
        let predict = |row: &Row<N>| Some((row.power, model.power(&row.motion, row.mass)?));
        let pairs = data.test.iter().filter_map(|(row, _)| predict(row)).collect();
        let name = if estimates { format!("{name}, mass given") } else { name.to_owned() };
        comparison.push(robot, (&name, source), MassSource::Given, fit.solve_s, Vec::new(), pairs);
    }
    let test: Vec<Point> = data.test.iter().map(|(_, point)| *point).collect();
    for card in baselines::ALL.iter().filter(|card| settings.models.contains(&card.name)) {
        match evaluate(robot, card, &data.wanted, &data.training, &test) {
            Err(error) => comparison.leave_out(card.name, error.to_string()),
            Ok(Evaluation { fit_s, parameters, pairs }) => {
                let mass = if card.takes_mass { MassSource::Given } else { MassSource::Unused };
                comparison.push(robot, (card.name, card.source), mass, fit_s, parameters, pairs);
            }
        }
    }
    Ok(comparison)
}

/// What came of one baseline.
pub struct Evaluation {
    /// Time to fit, s.
    pub fit_s: f64,
    /// What it learned.
    pub parameters: Vec<Parameter>,
    /// Measured and predicted power of the test points.
    pub pairs: Vec<Pair>,
}

/// Fits a baseline and predicts the test points.
///
/// # Errors
/// Why it cannot be had for this robot and these logs.
pub fn evaluate(
    robot: &Robot,
    card: &Card,
    wanted: &Wanted,
    training: &[Point],
    test: &[Point],
) -> Result<Evaluation> {
    if !(card.layouts.is_empty() || card.layouts.contains(&Layout::of(robot))) {
        let layouts: Vec<&str> = card.layouts.iter().map(|layout| layout.name()).collect();
        return Err(Error::failed(format!("it is a model of {}", layouts.join(" or "))));
    }
    let lacking: Vec<&str> = card
        .needs
        .iter()
        .filter(|need| !wanted.has(**need))
        .flat_map(|need| need.columns(robot))
        .copied()
        .collect();
    if !lacking.is_empty() {
        return Err(Error::failed(format!("the logs have no {}", lacking.join(", "))));
    }
    let mut baseline = (card.make)(robot);
    let started = Clock::now();
    baseline.fit(training)?;
    let fit_s = started.elapsed().as_secs_f64();
    let predicted = baseline.predict(test)?;
    let pairs = test.iter().map(|point| point.power).zip(predicted).collect();
    Ok(Evaluation { fit_s, parameters: baseline.parameters(), pairs })
}

impl Comparison {
    fn push(
        &mut self,
        robot: &Robot,
        (name, source): (&str, &str),
        mass: MassSource,
        fit_s: f64,
        parameters: Vec<Parameter>,
        pairs: Vec<Pair>,
    ) {
        let mut metrics = Metrics::new(robot.mape_floor_w());
        for (measured, predicted) in &pairs {
            metrics.add(*measured, *predicted);
        }
        let Some(Quality { r2, mape_percent, mape_share, rmse_w, samples, .. }) = metrics.quality() else {
            self.leave_out(name, "it predicts no test sample (its mass was never known)".to_owned());
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
            parameters,
        });
        self.pairs.push(pairs);
    }

    fn leave_out(&mut self, name: &str, reason: String) {
        self.left_out.push(LeftOut { name: name.to_owned(), reason });
    }
}

/// Training rows as a dataset and as points, test rows behind the same filter.
struct Data<const N: usize> {
    wanted: Wanted,
    train: Dataset<N>,
    training: Vec<Point>,
    test: Vec<(Row<N>, Point)>,
}

impl<const N: usize> Data<N> {
    fn read(robot: &Robot, split: &Split, settings: &Settings) -> Result<Self> {
        let reading =
            Reading { gate: model_core::eq18::Gate::Signed, cutoff_hz: None, mass_kg: settings.mass_kg };
        let (files, others): (&[PathBuf], &[PathBuf]) = match split {
            Split::Files { train, test } => (train, test),
            Split::Blocks { files, .. } => (files, &[]),
        };
        let wanted = Wanted::of(robot, &[files, others].concat())?;
        let mut train = Dataset::<N>::read(robot, files, &reading)?;
        let points = |files: &[PathBuf], stride| {
            points::read(robot, &train.robot, files, settings.mass_kg, &wanted, stride)
        };
        let read = points(files, train.stride)?;
        let (training, test) = match split {
            Split::Files { test, .. } => {
                let test = points(test, 1)?;
                if test.is_empty() {
                    return Err(Error::failed("no usable row to evaluate on").in_file(&others[0]));
                }
                (read, test)
            }
            Split::Blocks { block_s, .. } => {
                let block_s = block_s.unwrap_or_else(|| BLOCK_S.min(longest_run(&train.store) / 6.0));
                let held_out = |time: f64| (time / block_s).floor() as i64 % HOLD_OUT == HOLD_OUT - 1;
                train.store.retain(|row| !held_out(row.time));
                let (test, training): (Vec<_>, Vec<_>) =
                    read.into_iter().partition(|(row, _)| held_out(row.time));
                if test.is_empty() || training.is_empty() {
                    return Err(Error::failed(format!(
                        "the log is too short to hold out blocks of {block_s} s; expected at least {} s",
                        HOLD_OUT as f64 * block_s
                    ))
                    .in_file(&files[0]));
                }
                (training, test)
            }
        };
        let training = training.into_iter().map(|(_, point)| point).collect();
        Ok(Self { wanted, train, training, test })
    }
}

/// Duration of the longest run, s.
fn longest_run<const N: usize>(rows: &[Row<N>]) -> f64 {
    let durations =
        rows.chunk_by(|a, b| a.run == b.run).filter_map(|run| Some(run.last()?.time - run.first()?.time));
    durations.fold(0.0, f64::max)
}
