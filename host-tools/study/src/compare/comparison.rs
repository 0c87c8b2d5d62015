//! The table of models.

use std::path::PathBuf;

use answers::estimate::{Payloads, Policy, PolicyKind, bucket_length, replay};
use fit::Fit;
use fit::dataset::Row;
use logs::robot::Robot;
use model::coefficients::ModelKind;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::{Metrics, Quality};

use super::adapting;
use super::entry::{Entry, Horizon, LeftOut, MassSource, Pair, WeightSeeds};
use super::evaluate::{Beside, Evaluation, MassSearch, evaluate_all};
use super::mass;
use super::ours::{OURS, OurModel};
use super::persistence::persistence_r2;
use super::settings::Settings;
use super::split::{Data, Split};
use crate::baselines::{self, Card, Parameter, Point};

/// A table, and for each entry the pairs to plot.
pub struct Comparison {
    /// One entry a model.
    pub entries: Vec<Entry>,
    /// For each entry measured and predicted power.
    pub pairs: Vec<Vec<Pair>>,
    /// Requested models that are not available.
    pub left_out: Vec<LeftOut>,
    /// Length of the payload window, s.
    pub window_s: f64,
    /// Cutoff of the filter, Hz.
    pub cutoff_hz: f64,
    /// Delay of the power after the speeds, s.
    pub delay_s: f64,
    /// Rows to fit and to evaluate.
    pub train_rows: usize,
    /// Rows to fit and to evaluate.
    pub test_rows: usize,
    /// Power below which relative errors mean nothing, W.
    floor_w: f64,
    /// R² of the power one sample and one second before.
    persistence_r2: [Option<f64>; 2],
}

/// One model's row before it is judged.
struct Judged<'a> {
    name: &'a str,
    source: &'a str,
    mass: MassSource,
    horizon: Horizon,
    fit_s: f64,
    parameters: Vec<Parameter>,
    pairs: Vec<Pair>,
    mass_error_percent: Option<f64>,
    weight_seeds: Option<WeightSeeds>,
}

impl<'a> Judged<'a> {
    /// Without parameters, mass errors and seeds of weights.
    fn of(
        name: &'a str,
        source: &'a str,
        mass: MassSource,
        horizon: Horizon,
        fit_s: f64,
        pairs: Vec<Pair>,
    ) -> Self {
        let (parameters, mass_error_percent, weight_seeds) = (Vec::new(), None, None);
        Self { name, source, mass, horizon, fit_s, parameters, pairs, mass_error_percent, weight_seeds }
    }
}

/// Fits everything and evaluates it.
///
/// # Errors
/// A log that cannot be read, data that determine no model, or no model that can be had for this
/// robot and these logs.
pub fn compare(context: &Context, robot: &Robot, split: &Split, settings: &Settings) -> Result<Comparison> {
    // A wrong window is refused even where this split needs none.
    bucket_length(settings.window_s)?;
    let data = Data::read(context, robot, split, settings)?;
    let test: Vec<Point> = data.test.iter().map(|(_, point)| *point).collect();
    let period_s = data.train.period_s;
    let mut comparison = Comparison {
        entries: Vec::new(),
        pairs: Vec::new(),
        left_out: Vec::new(),
        window_s: settings.window_s,
        cutoff_hz: data.train.robot.cutoff_hz(),
        delay_s: data.train.robot.conditioning().delay,
        train_rows: data.train.store.len(),
        test_rows: data.test.len(),
        floor_w: robot.mape_floor_w(),
        persistence_r2: [period_s, 1.0].map(|horizon_s| persistence_r2(&test, horizon_s)),
    };
    // Without at least two payloads to learn from and logs to replay, the mass cannot be found.
    let replayed = match split {
        Split::Files { test, .. } if data.train.masses.len() > 1 => Some(&test[..]),
        _ => None,
    };
    for ours in OURS.iter().filter(|ours| settings.models.contains(&ours.name)) {
        let fit = comparison.add_ours(context, robot, ours, &data, replayed, settings.window_s)?;
        if let (true, ModelKind::Signed, Split::Files { train, test }) = (settings.adapt, ours.kind, split) {
            // Ground that adapts has no gyro.
            let fit = if data.train.robot.conditioning().true_slip == 0.0 {
                Ok(fit)
            } else {
                let train = data.without_gyro(context, robot, train, settings.mass_kg);
                train.and_then(|train| ours.fit(robot, &train))
            };
            match fit {
                Ok(fit) => comparison.add_adapting(context, robot, ours, &fit, test, settings),
                Err(error) => comparison.leave_out(&adapts(ours.name), error.to_string()),
            }
        }
    }
    mass::tell_extrapolation(context, settings, data.training.iter(), test.iter());
    let cards: Vec<&Card> = baselines::every().filter(|card| settings.models.contains(&card.name)).collect();
    let masses = replayed.map(|_| MassSearch {
        range: (robot.mass_no_load_kg(), robot.mass_full_load_kg()),
        window_s: settings.window_s,
    });
    let beside = Beside { masses, adapts: settings.adapt };
    let evaluations = evaluate_all(context, robot, &cards, &data.wanted, &data.training, &test, beside);
    for (card, evaluation) in cards.into_iter().zip(evaluations) {
        match evaluation {
            Err(error) => comparison.leave_out(card.name, error.to_string()),
            Ok(evaluation) => comparison.add_baseline(card, evaluation, &test),
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
    /// Fits a model of ours; with the mass given, and estimated where logs allow.
    fn add_ours(
        &mut self,
        context: &Context,
        robot: &Robot,
        ours: &OurModel,
        data: &Data,
        replayed: Option<&[PathBuf]>,
        window_s: f64,
    ) -> Result<Fit> {
        let OurModel { name, source, kind, .. } = *ours;
        let fit = ours.fit(robot, &data.train)?;
        let row = |name, mass, horizon, pairs| Judged::of(name, source, mass, horizon, fit.solve_s, pairs);
        if let Some(test) = replayed {
            let (mut pairs, mut errors) = (Vec::new(), Vec::new());
            let policy = Policy {
                window_s,
                kind: PolicyKind::Moving,
                changes_s: Vec::new(),
                detect: kind == ModelKind::Signed,
            };
            let coefficients = fit.coefficients();
            let payloads = Payloads::default_for(&fit.model);
            for file in test {
                replay(context, robot, &coefficients, file, payloads, &policy, &mut |instant| {
                    if let Some(predicted) = instant.predicted_w {
                        pairs.push((instant.measured_w, predicted));
                    }
                    if let (Some(mass), Some(truth)) = (instant.mass_kg, instant.truth_kg) {
                        errors.push(100.0 * (mass / truth - 1.0).abs());
                    }
                })?;
            }
            let row = row(name, MassSource::Estimated, Horizon::Second, pairs);
            self.push(Judged { mass_error_percent: mean(errors.into_iter()), ..row });
        }
        let model = &fit.model;
        let predict = |row: &Row| Some((row.power, row.view().predicted(model)?));
        let pairs = data.test.iter().filter_map(|(row, _)| predict(row)).collect();
        let name = if replayed.is_some() { format!("{name}, mass given") } else { name.to_owned() };
        self.push(row(&name, MassSource::Given, Horizon::Plan, pairs));
        Ok(fit)
    }

    /// A model of ours with the mass given, on a floor that adapts.
    fn add_adapting(
        &mut self,
        context: &Context,
        robot: &Robot,
        ours: &OurModel,
        fit: &Fit,
        test: &[PathBuf],
        settings: &Settings,
    ) {
        let name = adapts(ours.name);
        let coefficients = fit.coefficients();
        let of = |file: &PathBuf| {
            adapting::ours(context, robot, &coefficients, file, settings.mass_kg, settings.window_s)
        };
        match test.iter().map(of).collect::<Result<Vec<_>>>() {
            Err(error) => self.leave_out(&name, error.to_string()),
            Ok(pairs) => {
                let (mass, horizon) = (MassSource::Given, Horizon::Second);
                self.push(Judged::of(&name, ours.source, mass, horizon, fit.solve_s, pairs.concat()));
            }
        }
    }

    /// A baseline; one that takes the mass also without it.
    fn add_baseline(&mut self, card: &Card, evaluation: Evaluation, test: &[Point]) {
        let Evaluation { fit_s, parameters, pairs, without_mass, adapted, masses, weight_seeds } = evaluation;
        let error = |masses: Vec<f64>| {
            let errors = masses.iter().zip(test).map(|(mass, point)| 100.0 * (mass / point.mass - 1.0).abs());
            mean(errors)
        };
        self.push(Judged {
            parameters,
            mass_error_percent: masses.and_then(error),
            weight_seeds,
            ..Judged::of(card.name, card.source, MassSource::of(card), Horizon::of(card), fit_s, pairs)
        });
        if let Some(pairs) = adapted {
            let (name, mass) = (adapts(card.name), MassSource::of(card));
            self.push(Judged::of(&name, card.source, mass, Horizon::Second, fit_s, pairs));
        }
        if let Some(without) = without_mass {
            let (name, mass) = (format!("{}, mass found", card.name), MassSource::Estimated);
            self.push(Judged {
                mass_error_percent: error(without.masses),
                ..Judged::of(&name, card.source, mass, Horizon::Second, fit_s, without.pairs)
            });
        }
    }

    fn push(&mut self, judged: Judged<'_>) {
        let Judged { name, source, mass, horizon, fit_s, parameters, mut pairs, .. } = judged;
        // A row without a prediction is no sample: the entry counts samples.
        pairs.retain(|(_, predicted)| !predicted.is_nan());
        let mut metrics = Metrics::new(self.floor_w);
        for (measured, predicted) in &pairs {
            metrics.add(*measured, *predicted);
        }
        let Some(Quality { r2, mape_percent, mape_share, rmse_w, samples, .. }) = metrics.quality() else {
            self.leave_out(name, "it predicts no test sample".to_owned());
            return;
        };
        let persistence_r2 = match horizon {
            Horizon::Plan => None,
            Horizon::Sample => self.persistence_r2[0],
            Horizon::Second => self.persistence_r2[1],
        };
        self.entries.push(Entry {
            name: name.to_owned(),
            source: source.to_owned(),
            mass,
            horizon,
            r2,
            persistence_r2,
            mape_percent,
            rmse_w,
            mass_error_percent: judged.mass_error_percent,
            mape_share,
            samples,
            fit_s,
            weight_seeds: judged.weight_seeds,
            parameters,
        });
        self.pairs.push(pairs);
    }

    fn leave_out(&mut self, name: &str, reason: String) {
        self.left_out.push(LeftOut { name: name.to_owned(), reason });
    }
}

/// The name of a model whose floor adapts.
fn adapts(name: &str) -> String {
    format!("{name}, floor adapts")
}

/// Of the finite ones; `None` without any.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let known: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}
