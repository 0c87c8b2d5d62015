//! Every model and baseline on the same split.

mod evaluate;
mod mass;
pub mod points;
mod split;

use serde::Serialize;

pub use self::evaluate::{Evaluation, allowed, evaluate, evaluate_all};
use self::split::Data;
pub use self::split::{BLOCK_S, HOLD_OUT, Split};
use crate::baselines::{self, Card, Parameter, Point};
use crate::error::{Error, Result};
use crate::estimate::{Payloads, Policy, PolicyKind, bucket_length, replay};
use crate::fit::dataset::Row;
use crate::fit::{self, Method, ModelKind, pgd};
use crate::metrics::{Metrics, Quality};
use crate::robot::Robot;

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

impl MassSource {
    /// That of a baseline.
    pub fn of(card: &Card) -> Self {
        if card.takes_mass { Self::Given } else { Self::Unused }
    }

    /// For tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Estimated => "estimated",
            Self::Unused => "unused",
        }
    }
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
    OWN.iter().map(|own| own.name).chain(baselines::ALL.iter().map(|card| card.name))
}

/// A model of this project or the paper: it can find the mass itself.
#[derive(Debug, Clone, Copy)]
pub struct Own {
    /// Its name in tables and in `gmr compare --models`.
    pub name: &'static str,
    /// What it is, in one line.
    pub source: &'static str,
    /// What it assumes beyond that, in one line.
    pub assumes: &'static str,
    kind: ModelKind,
    method: Method,
}

/// The models of this project and the paper, in the order of the table.
pub const OWN: [Own; 3] = [
    Own {
        name: "signed",
        source: "signed torque model (default)",
        assumes: "motors of one kind, wheels that roll without slipping",
        kind: ModelKind::Signed,
        method: Method::Physical,
    },
    Own {
        name: "eq18",
        source: "Eq. 18, corrected",
        assumes: "as the signed model, and inertial torque only where it speeds a wheel up",
        kind: ModelKind::Eq18,
        method: Method::Nnls,
    },
    Own {
        name: "eq18-published",
        source: "Eq. 18 as printed, Algorithm 1",
        assumes: "as eq18, with the derivation's slips: the squared inertial torque counts in braking, too, and goes with m, not m²",
        kind: ModelKind::Eq18Published,
        method: Method::Pgd,
    },
];

/// Fits everything and evaluates it.
///
/// # Errors
/// A log that cannot be read, data that determine no model, or no model that can be had for this robot and these logs.
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
    for own in OWN.iter().filter(|own| settings.models.contains(&own.name)) {
        comparison.add_own(robot, own, &data, split, settings)?;
    }
    let test: Vec<Point> = data.test.iter().map(|(_, point)| *point).collect();
    mass::tell_extrapolation(settings, data.training.iter(), test.iter());
    let cards: Vec<&Card> =
        baselines::ALL.iter().filter(|card| settings.models.contains(&card.name)).copied().collect();
    let evaluations = evaluate_all(robot, &cards, &data.wanted, &data.training, &test);
    for (card, evaluation) in cards.into_iter().zip(evaluations) {
        match evaluation {
            Err(error) => comparison.leave_out(card.name, error.to_string()),
            Ok(Evaluation { fit_s, parameters, pairs }) => {
                let mass = MassSource::of(card);
                comparison.push(robot, (card.name, card.source), mass, fit_s, parameters, pairs);
            }
        }
    }
    if comparison.entries.is_empty() {
        let why = |out: &LeftOut| format!("{}: {}", out.name, out.reason);
        let why: Vec<String> = comparison.left_out.iter().map(why).collect();
        return Err(Error::failed(format!("no model is left to compare ({})", why.join("; "))));
    }
    Ok(comparison)
}

impl Comparison {
    /// Fits a model of ours; where it can find the mass, with and without it.
    fn add_own<const N: usize>(
        &mut self,
        robot: &Robot,
        own: &Own,
        data: &Data<N>,
        split: &Split,
        settings: &Settings,
    ) -> Result<()> {
        let Own { name, source, kind, method, .. } = *own;
        let fit =
            fit::fit(robot, &data.train.with_gate(kind.gate()), kind, method, &pgd::Settings::default())?;
        // Without at least two payloads to learn from and logs to replay, the mass cannot be estimated.
        let replayed = match split {
            Split::Files { test, .. } if data.train.masses.len() > 1 => Some(test),
            _ => None,
        };
        if let Some(test) = replayed {
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
            self.push(robot, (name, source), MassSource::Estimated, fit.solve_s, Vec::new(), pairs);
        }
        let model = &fit.coefficients.model;
        let predict = |row: &Row<N>| Some((row.power, model.power(&row.motion, row.mass)?));
        let pairs = data.test.iter().filter_map(|(row, _)| predict(row)).collect();
        let name = if replayed.is_some() { format!("{name}, mass given") } else { name.to_owned() };
        self.push(robot, (&name, source), MassSource::Given, fit.solve_s, Vec::new(), pairs);
        Ok(())
    }

    fn push(
        &mut self,
        robot: &Robot,
        (name, source): (&str, &str),
        mass: MassSource,
        fit_s: f64,
        parameters: Vec<Parameter>,
        mut pairs: Vec<Pair>,
    ) {
        // No prediction, no sample: the entry tells how many there are.
        pairs.retain(|(_, predicted)| !predicted.is_nan());
        let mut metrics = Metrics::new(robot.mape_floor_w());
        for (measured, predicted) in &pairs {
            metrics.add(*measured, *predicted);
        }
        let Some(Quality { r2, mape_percent, mape_share, rmse_w, samples, .. }) = metrics.quality() else {
            self.leave_out(name, "it predicts no test sample".to_owned());
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
