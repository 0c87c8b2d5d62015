//! Section 7: the experiment's regime, seed by seed.

use std::path::{Path, PathBuf};

use answers::estimate::{Instant, Policy, PolicyKind};
use fit::dataset::Dataset;
use logs::robot::Robot;
use plant::experiment::{Drive, REGIME, scenario};
use plant::log::{Column, Columns, write};
use support::context::Context;
use support::error::Result;
use support::metrics::Metrics;

use super::contender::{CONTENDERS, Fitted, Log, moving, training};
use super::course::{Course, Followed};
use super::settings::Settings;
use super::spread::Spread;
use super::windows::{PUBLISHED_WORST, Swept, at_window, lengths};
use crate::baselines;
use crate::compare::points::Wanted;
use crate::compare::{
    Beside, Horizon, LeftOut, MassSearch, MassSource, WeightSeeds, evaluate, persistence_r2,
};

/// The window of Fig. 13 to 15, s.
const WINDOW_S: f64 = 25.0;

/// A training drive and its fitted contenders, for all later drives.
pub(super) struct Learned<'a> {
    /// The robot.
    pub(super) robot: &'a Robot,
    /// Ours, the paper's, the paper's without its misprints.
    pub(super) fitted: Vec<Fitted<'a>>,
    context: &'a Context,
    folder: &'a Path,
    file: PathBuf,
    dataset: Dataset,
    seed: u64,
}

/// Drives the training of a seed into the folder, and fits the contenders.
pub(super) fn learn<'a>(
    context: &'a Context,
    folder: &'a Path,
    robot: &'a Robot,
    seed: u64,
) -> Result<Learned<'a>> {
    let file = drive(folder, Drive::Training, seed)?;
    let dataset = training(context, robot, &file)?;
    let fitted =
        CONTENDERS.iter().map(|contender| contender.fit(context, robot, &dataset)).collect::<Result<_>>()?;
    Ok(Learned { context, robot, fitted, folder, file, dataset, seed })
}

impl Learned<'_> {
    /// Another drive of the seed, and the columns that baselines may read of it and of the
    /// training.
    pub(super) fn drive(&self, which: Drive) -> Result<(Log, Wanted)> {
        let file = drive(self.folder, which, self.seed)?;
        let wanted = Wanted::of(self.context, self.robot, &[self.file.clone(), file.clone()])?;
        Ok((Log::read(self.context, self.robot, &self.dataset, &file, &wanted)?, wanted))
    }
}

/// One drive as a log with every column that a baseline may need.
fn drive(folder: &Path, which: Drive, seed: u64) -> Result<PathBuf> {
    let columns = Columns {
        further: vec![Column::Command, Column::Imu, Column::Friction, Column::Pitch, Column::Slope],
        ..Columns::default()
    };
    let file = folder.join(format!("experiment-{}-{seed}.csv", which as u8));
    write(&file, &scenario(which, seed)?, &columns)?;
    Ok(file)
}

/// The results of one seed.
pub(super) struct Seed {
    /// Ours, the paper's, then every baseline.
    pub(super) models: Vec<Judged>,
    pub(super) windows: Vec<Swept>,
    pub(super) left_out: Vec<LeftOut>,
    /// Share of the samples after the first window in which every model is judged.
    pub(super) known_share: f64,
    /// R² of the power one sample and one second before.
    pub(super) persistence_r2: [f64; 2],
    pub(super) courses: Option<Courses>,
}

/// A model on the test log.
pub(super) struct Judged {
    pub(super) name: String,
    pub(super) source: &'static str,
    pub(super) mass: MassSource,
    pub(super) horizon: Horizon,
    pub(super) quality: Quality<f64>,
    /// Of a network: what other seeds of its weights give.
    pub(super) weight_seeds: Option<WeightSeeds>,
}

/// MAPE (%), R² and RMSE (W) of the predicted power; mean error of the estimated mass (%).
type Quality<T> = [T; 4];

/// What is drawn of the first seed.
#[derive(Default)]
pub(super) struct Courses {
    /// Fig. 13 to 15: power of the test log with a moving window of 25 s; ours and the paper's,
    /// then the baselines.
    pub(super) test: Course,
    /// Fig. 10: the mass by all samples since a known change.
    pub(super) cumulative: Course,
    /// Fig. 11: the mass by moving windows of so many seconds.
    pub(super) moving: Vec<(f64, Course)>,
}

/// Drives and judges one seed. `draw` keeps what figures need.
pub(super) fn seed(learned: &Learned<'_>, settings: &Settings, draw: bool) -> Result<Seed> {
    let Learned { robot, fitted, .. } = learned;
    let (log, wanted) = learned.drive(Drive::Test)?;
    let known = Log::read(learned.context, robot, &learned.dataset, &learned.file, &wanted)?;
    let mut windows = Vec::new();
    for window_s in lengths(settings) {
        for fitted in fitted {
            let figures = at_window(fitted, &log, window_s, robot.mape_floor_w())?;
            windows.push((window_s, fitted.contender.name, figures));
        }
    }

    let follow =
        |fitted: &Fitted<'_>| Ok(fitted.follow(&log, &moving(WINDOW_S, fitted.contender.detects))?.1);
    let followed = fitted.iter().map(follow).collect::<Result<Vec<_>>>()?;
    let judge = Judge::new(robot, &log, &followed);
    let (mut models, mut left_out, mut curves) = (Vec::new(), Vec::new(), Vec::new());
    for (contender, instants) in CONTENDERS.iter().zip(&followed) {
        let masses: Vec<f64> = instants.iter().map(|now| now.mass_kg.unwrap_or(f64::NAN)).collect();
        let quality = judge.quality(instants.iter().map(|now| now.predicted_w.unwrap_or(f64::NAN)), &masses);
        let (name, source) = (contender.name.to_owned(), contender.source);
        let (mass, horizon) = (MassSource::Estimated, Horizon::Second);
        models.push(Judged { name, source, mass, horizon, quality, weight_seeds: None });
    }
    if let Some(ours) = fitted.first() {
        let Followed { method, predicted_w, .. } = ours.given_mass(&log);
        models.push(Judged {
            name: format!("{method}, mass given"),
            source: ours.contender.source,
            mass: MassSource::Given,
            horizon: Horizon::Plan,
            quality: judge.quality(predicted_w.into_iter(), &[]),
            weight_seeds: None,
        });
    }
    let masses =
        MassSearch { range: (robot.mass_no_load_kg(), robot.mass_full_load_kg()), window_s: WINDOW_S };
    let beside = Beside { masses: Some(masses), adapts: false };
    for card in baselines::every().filter(|card| settings.baselines.contains(&card.name)) {
        let evaluation = match evaluate(robot, card, &wanted, &known.points, &log.points, beside) {
            Ok(evaluation) => evaluation,
            Err(error) => {
                left_out.push(LeftOut { name: card.name.to_owned(), reason: error.to_string() });
                continue;
            }
        };
        let (source, weight_seeds) = (card.source, evaluation.weight_seeds);
        let predicted_w: Vec<f64> = evaluation.pairs.iter().map(|pair| pair.1).collect();
        let quality = judge.quality(predicted_w.iter().copied(), &evaluation.masses.unwrap_or_default());
        let (name, mass, horizon) = (card.name.to_owned(), MassSource::of(card), Horizon::of(card));
        models.push(Judged { name: name.clone(), source, mass, horizon, quality, weight_seeds });
        curves.push(Followed { method: name, predicted_w, ..Followed::default() });
        if let Some(without_mass) = evaluation.without_mass {
            let quality = judge.quality(without_mass.pairs.iter().map(|pair| pair.1), &without_mass.masses);
            let name = format!("{}, mass found", card.name);
            let (mass, horizon) = (MassSource::Estimated, Horizon::Second);
            models.push(Judged { name, source, mass, horizon, quality, weight_seeds: None });
        }
    }
    let courses = if draw { Some(courses(fitted, &followed, &log, curves)?) } else { None };
    let persistence_r2 = [1.0 / REGIME.rate_hz, 1.0]
        .map(|horizon_s| persistence_r2(&log.points, horizon_s).unwrap_or(f64::NAN));
    Ok(Seed { models, windows, left_out, known_share: judge.known_share(), persistence_r2, courses })
}

/// The samples that every model is judged by: from the first full window on, where each contender
/// knows the mass.
struct Judge<'a> {
    log: &'a Log,
    settled: Vec<bool>,
    counts: Vec<bool>,
    floor_w: f64,
}

impl<'a> Judge<'a> {
    fn new(robot: &Robot, log: &'a Log, followed: &[Vec<Instant>]) -> Self {
        let settled: Vec<bool> = log.rows.iter().map(|row| row.time >= WINDOW_S).collect();
        let known = |index: usize| followed.iter().all(|instants| instants[index].predicted_w.is_some());
        let counts = settled.iter().enumerate().map(|(index, settled)| *settled && known(index)).collect();
        Self { log, settled, counts, floor_w: robot.mape_floor_w() }
    }

    fn known_share(&self) -> f64 {
        let count = |which: &[bool]| which.iter().filter(|is| **is).count() as f64;
        count(&self.counts) / count(&self.settled)
    }

    /// Of predicted power, and of masses where there are any.
    fn quality(&self, predicted: impl Iterator<Item = f64>, masses: &[f64]) -> Quality<f64> {
        let mut metrics = Metrics::new(self.floor_w);
        for ((row, counts), predicted) in self.log.rows.iter().zip(&self.counts).zip(predicted) {
            if *counts {
                metrics.add(row.power, predicted);
            }
        }
        let rows = self.log.rows.iter().zip(masses).zip(&self.counts).filter(|(_, counts)| **counts);
        let errors = rows.map(|((row, mass), _)| 100.0 * (mass / row.mass - 1.0).abs());
        let errors: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
        let quality = metrics.quality();
        let figure = |value: fn(&support::metrics::Quality) -> Option<f64>| {
            quality.as_ref().and_then(value).unwrap_or(f64::NAN)
        };
        [
            figure(|quality| quality.mape_percent),
            figure(|quality| quality.r2),
            figure(|quality| Some(quality.rmse_w)),
            errors.iter().sum::<f64>() / errors.len() as f64,
        ]
    }
}

fn courses(
    fitted: &[Fitted<'_>],
    followed: &[Vec<Instant>],
    log: &Log,
    baselines: Vec<Followed>,
) -> Result<Courses> {
    let tested = fitted.iter().zip(followed).map(|(fitted, instants)| fitted.followed(instants));
    let test = Course { trace: log.trace(), methods: tested.chain(baselines).collect() };
    let changes_s: Vec<f64> = log.tasks().iter().skip(1).map(|task| log.rows[task.from].time).collect();
    let since_change = Policy { window_s: WINDOW_S, kind: PolicyKind::Cumulative, changes_s, detect: false };
    let moving = PUBLISHED_WORST.map(|published| {
        let window_s = published[0];
        Ok((window_s, log.course(fitted, |contender| moving(window_s, contender.detects))?))
    });
    Ok(Courses {
        test,
        cumulative: log.course(fitted, |_| since_change.clone())?,
        moving: moving.into_iter().collect::<Result<_>>()?,
    })
}

/// One model's power at a moving window of 25 s, over seeds.
#[derive(Debug, Clone)]
pub(super) struct ModelRow {
    /// The model.
    pub(super) name: String,
    /// What it is.
    pub(super) source: &'static str,
    /// Where the mass came from.
    pub(super) mass: MassSource,
    /// Whether it uses power of the test drive.
    pub(super) horizon: Horizon,
    /// Over seeds.
    pub(super) quality: Quality<Spread>,
    /// Seeds in which ours has the lower MAPE and the higher R² on the same log.
    pub(super) ours_ahead: u64,
    /// Seeds in which ours has the higher MAPE or the lower R².
    pub(super) ours_behind: u64,
    /// As published, where it is: MAPE in % and R².
    pub(super) published: Option<(f64, f64)>,
    /// Of a network, mean over drives: R² of the worst and of the best seed of its weights.
    pub(super) weights_r2: Option<(f64, f64)>,
}

/// MAPE (%) and R² at 25 s (Section 8): the paper's method, its regression, its perceptron.
pub(super) const PUBLISHED: [(&str, (f64, f64)); 3] =
    [("eq18-published", (9.12, 0.78)), ("linear", (12.7, 0.44)), ("mlp", (10.2, 0.69))];

/// Models in the order of the first seed.
pub(super) fn models(seeds: &[Seed]) -> Vec<ModelRow> {
    let Some(first) = seeds.first() else { return Vec::new() };
    let row = |Judged { name, source, mass, horizon, .. }: &Judged| {
        let of = |seed: &'_ Seed| seed.models.iter().position(|other| other.name == *name);
        let theirs = || seeds.iter().map(|seed| of(seed).map(|place| &seed.models[place]));
        let quality =
            Spread::of_each(theirs().map(|model| model.map_or([f64::NAN; 4], |model| model.quality)));
        let (mut ours_ahead, mut ours_behind) = (0, 0);
        for (seed, theirs) in seeds.iter().zip(theirs()) {
            let (Some(ours), Some(theirs)) = (seed.models.first(), theirs) else { continue };
            let ([mape, r2, ..], [their_mape, their_r2, ..]) = (ours.quality, theirs.quality);
            // An unknown figure counts for neither.
            let known = [mape, r2, their_mape, their_r2].iter().all(|figure| figure.is_finite());
            ours_ahead += u64::from(known && mape < their_mape && r2 > their_r2);
            ours_behind += u64::from(known && (mape > their_mape || r2 < their_r2));
        }
        let weights: Vec<WeightSeeds> = theirs().filter_map(|model| model?.weight_seeds).collect();
        let mean = |of: fn(&WeightSeeds) -> f64| weights.iter().map(of).sum::<f64>() / weights.len() as f64;
        let published = PUBLISHED.iter().find(|(known, _)| known == name).map(|(_, figures)| *figures);
        ModelRow {
            name: name.clone(),
            source,
            mass: *mass,
            horizon: *horizon,
            quality,
            ours_ahead,
            ours_behind,
            published,
            weights_r2: (!weights.is_empty())
                .then(|| (mean(|one| one.least_r2), mean(|one| one.greatest_r2))),
        }
    };
    first.models.iter().map(row).collect()
}
