//! Section 7: the experiment's regime, seed by seed.

use super::contender::{CONTENDERS, Fitted, Log};
use super::experiment::Learned;
use super::spread_of;
use super::study::{Course, Experiment, Followed, ModelRow, Nearness, Settings, WindowRow};
use super::windows::{AtWindow, at_window};
use crate::baselines::{self, Card};
use crate::compare::{LeftOut, MassSource, Pair, evaluate};
use crate::error::Result;
use crate::estimate::{Instant, Policy, PolicyKind};
use crate::metrics::{Metrics, Quality};
use crate::plant::experiment::Drive;
use crate::robot::Robot;

/// The window of Fig. 13 to 15, s.
pub(super) const WINDOW_S: f64 = 25.0;

/// The windows of Fig. 11 and of the published worst cases, s.
const SHORT_AND_LONG_S: [f64; 2] = [PUBLISHED_WORST[0].0, PUBLISHED_WORST[1].0];

/// What one seed gives.
pub(super) struct Seed {
    models: Vec<Judged>,
    windows: Vec<(f64, &'static str, AtWindow)>,
    left_out: Vec<LeftOut>,
    known_share: f64,
    figures: Option<Figures>,
}

/// A model on the test log.
struct Judged {
    name: &'static str,
    source: &'static str,
    mass: MassSource,
    quality: Quality,
}

/// What is drawn of the first seed.
struct Figures {
    training: Course,
    test: Course,
    cumulative: Course,
    moving: Vec<(f64, Course)>,
}

/// Drives and judges one seed. `draw` keeps what figures need.
pub(super) fn seed(learned: &Learned<'_>, settings: &Settings, draw: bool) -> Result<Seed> {
    let Learned { robot, fitted, .. } = learned;
    let (log, wanted) = learned.drive(Drive::Test)?;
    let known = learned.training(&wanted)?;
    let mut windows = Vec::new();
    let lengths = settings.windows_s.iter().map(|length| f64::from(*length)).chain(SHORT_AND_LONG_S);
    for window_s in lengths {
        for fitted in fitted {
            let found = at_window(fitted, &log, window_s, robot.mape_floor_w())?;
            windows.push((window_s, fitted.contender.name, found));
        }
    }

    let followed = fitted
        .iter()
        .map(|fitted| Ok(fitted.follow_moving(&log, WINDOW_S)?.1))
        .collect::<Result<Vec<_>>>()?;
    let judged = judge(robot, &log, &followed);
    let (mut models, mut left_out) = (Vec::new(), Vec::new());
    for (contender, instants) in CONTENDERS.iter().zip(&followed) {
        let predicted = instants.iter().map(|now| now.predicted_w.unwrap_or(f64::NAN));
        models.push(Judged {
            name: contender.name,
            source: contender.source,
            mass: MassSource::Estimated,
            quality: judged.quality(predicted),
        });
    }
    let mut curves = Vec::new();
    for card in chosen(settings) {
        match evaluate(robot, card, &wanted, &known.points, &log.points) {
            Err(error) => {
                left_out.push(LeftOut { name: card.name.to_owned(), reason: error.to_string() });
            }
            Ok(evaluation) => {
                let predicted = || evaluation.pairs.iter().map(|(_, predicted): &Pair| *predicted);
                models.push(Judged {
                    name: card.name,
                    source: card.source,
                    mass: MassSource::of(card),
                    quality: judged.quality(predicted()),
                });
                curves.push(Followed {
                    method: card.name.to_owned(),
                    predicted_w: predicted().collect(),
                    ..Followed::default()
                });
            }
        }
    }
    let figures = if draw { Some(figures(fitted, &followed, &known, &log, curves)?) } else { None };
    let known_share = judged.samples as f64 / judged.settled as f64;
    Ok(Seed { models, windows, left_out, known_share, figures })
}

fn chosen(settings: &Settings) -> impl Iterator<Item = &'static Card> {
    baselines::ALL.iter().copied().filter(|card| settings.baselines.contains(&card.name))
}

/// The samples that every model is judged by: from the first full window on, where each contender knows the mass.
struct Judge<'a> {
    log: &'a Log,
    counts: Vec<bool>,
    samples: usize,
    settled: usize,
    floor_w: f64,
}

fn judge<'a>(robot: &Robot, log: &'a Log, followed: &[Vec<Instant>]) -> Judge<'a> {
    let full = |index: usize| log.rows[index].time >= WINDOW_S;
    let known = |index: usize| followed.iter().all(|instants| instants[index].predicted_w.is_some());
    let counts: Vec<bool> = (0..log.rows.len()).map(|index| full(index) && known(index)).collect();
    let samples = counts.iter().filter(|counts| **counts).count();
    let settled = (0..log.rows.len()).filter(|index| full(*index)).count();
    Judge { log, counts, samples, settled, floor_w: robot.mape_floor_w() }
}

impl Judge<'_> {
    fn quality(&self, predicted: impl Iterator<Item = f64>) -> Quality {
        let mut metrics = Metrics::new(self.floor_w);
        for ((row, counts), predicted) in self.log.rows.iter().zip(&self.counts).zip(predicted) {
            if *counts {
                metrics.add(row.power, predicted);
            }
        }
        metrics.quality().unwrap_or(super::windows::NO_QUALITY)
    }
}

fn figures(
    fitted: &[Fitted<'_>],
    followed: &[Vec<Instant>],
    known: &Log,
    log: &Log,
    baselines: Vec<Followed>,
) -> Result<Figures> {
    let trace = log.trace();
    let course = |methods: Vec<Followed>| Course { trace: trace.clone(), methods };
    let tested = fitted.iter().zip(followed).map(|(fitted, instants)| fitted.followed(instants));
    let changes_s: Vec<f64> = log.tasks().iter().skip(1).map(|task| log.rows[task.from].time).collect();
    let since_change = Policy { window_s: WINDOW_S, kind: PolicyKind::Cumulative, changes_s, detect: false };
    let cumulative = fitted
        .iter()
        .map(|fitted| Ok(fitted.followed(&fitted.follow(log, &since_change)?.1)))
        .collect::<Result<Vec<_>>>()?;
    let moving = SHORT_AND_LONG_S
        .iter()
        .map(|window_s| {
            let methods = fitted
                .iter()
                .map(|fitted| Ok(fitted.followed(&fitted.follow_moving(log, *window_s)?.1)))
                .collect::<Result<Vec<_>>>()?;
            Ok((*window_s, course(methods)))
        })
        .collect::<Result<Vec<_>>>()?;
    Ok(Figures {
        training: Course {
            trace: known.trace(),
            methods: fitted.iter().map(|fitted| fitted.told(known)).collect(),
        },
        test: course(tested.chain(baselines).collect()),
        cumulative: course(cumulative),
        moving,
    })
}

/// Over all seeds, in their order; the first one is drawn.
pub(super) fn gather(seeds: Vec<Seed>, rails: super::study::Rails) -> Experiment {
    let windows = window_rows(&seeds);
    let models = model_rows(&seeds);
    let nearness = nearness(&windows, &models);
    let share_known = spread_of(&seeds, |seed| Some(100.0 * seed.known_share));
    let left_out = seeds.first().map_or(Vec::new(), |seed| seed.left_out.clone());
    let drawn = seeds.into_iter().find_map(|seed| seed.figures);
    let Figures { training, test, cumulative, moving } = drawn.unwrap_or_else(|| Figures {
        training: Course::default(),
        test: Course::default(),
        cumulative: Course::default(),
        moving: Vec::new(),
    });
    Experiment {
        knobs: super::regime::knobs(),
        nearness,
        rails,
        training,
        test,
        cumulative,
        moving,
        windows,
        models,
        left_out,
        share_known,
    }
}

fn window_rows(seeds: &[Seed]) -> Vec<WindowRow> {
    let mut lengths: Vec<f64> =
        seeds.iter().flat_map(|seed| seed.windows.iter().map(|(length, ..)| *length)).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let mut rows = Vec::new();
    for window_s in lengths {
        for contender in &CONTENDERS {
            let spread = |value: fn(&AtWindow) -> f64| {
                spread_of(seeds, |seed| {
                    let is_it =
                        |entry: &&(f64, &str, AtWindow)| entry.0 == window_s && entry.1 == contender.name;
                    seed.windows.iter().find(is_it).map(|(.., found)| value(found))
                })
            };
            rows.push(WindowRow {
                window_s,
                method: contender.name.to_owned(),
                worst_mass_percent: spread(|found| found.worst_mass_percent),
                mean_mass_percent: spread(|found| found.mean_mass_percent),
                mape_percent: spread(|found| found.mape_percent),
                r2: spread(|found| found.r2),
                known_percent: spread(|found| 100.0 * found.known_share),
            });
        }
    }
    rows
}

/// Models in the order of the first seed.
fn model_rows(seeds: &[Seed]) -> Vec<ModelRow> {
    let Some(first) = seeds.first() else { return Vec::new() };
    let row = |model: &Judged| {
        let spread = |value: fn(&Quality) -> Option<f64>| {
            spread_of(seeds, |seed| {
                value(&seed.models.iter().find(|other| other.name == model.name)?.quality)
            })
        };
        let (ours_ahead, ours_behind) = duels(seeds, model.name);
        ModelRow {
            ours_ahead,
            ours_behind,
            name: model.name.to_owned(),
            source: model.source.to_owned(),
            mass: model.mass,
            mape_percent: spread(|quality| quality.mape_percent),
            r2: spread(|quality| quality.r2),
            rmse_w: spread(|quality| Some(quality.rmse_w)),
            published: PUBLISHED
                .iter()
                .find(|(name, ..)| *name == model.name)
                .map(|(_, mape, r2)| (*mape, *r2)),
        }
    };
    first.models.iter().map(row).collect()
}

/// Seeds in which ours is better than a model by MAPE and by R², and those in which it is worse by either.
fn duels(seeds: &[Seed], name: &str) -> (u64, u64) {
    let (mut ahead, mut behind) = (0, 0);
    for seed in seeds {
        let (Some(ours), Some(theirs)) =
            (seed.models.first(), seed.models.iter().find(|model| model.name == name))
        else {
            continue;
        };
        let figures = |model: &Judged| Some((model.quality.mape_percent?, model.quality.r2?));
        if let (Some((our_mape, our_r2)), Some((their_mape, their_r2))) = (figures(ours), figures(theirs)) {
            ahead += u64::from(our_mape < their_mape && our_r2 > their_r2);
            behind += u64::from(our_mape > their_mape || our_r2 < their_r2);
        }
    }
    (ahead, behind)
}

/// MAPE (%) and R² at 25 s (Section 8): the paper's method, its regression, its perceptron.
const PUBLISHED: [(&str, f64, f64); 3] =
    [("eq18-published", 9.12, 0.78), ("linear", 12.7, 0.44), ("mlp", 10.2, 0.69)];

/// Worst-case windows (Section 8): length in s, mass error and MAPE in %, R².
pub(super) const PUBLISHED_WORST: [(f64, f64, f64, f64); 2] =
    [(12.5, 19.8, 11.1, 0.68), (50.0, 11.6, 8.6, 0.79)];

fn nearness(windows: &[WindowRow], models: &[ModelRow]) -> Vec<Nearness> {
    let mut near = Vec::new();
    let ours = models.first();
    for (name, mape, r2) in PUBLISHED {
        let here = models.iter().find(|row| row.name == name);
        if let (Some(here), Some(ours)) = (here, ours) {
            let what = |of: &str| format!("{name}, 25 s: {of}");
            near.push(Nearness {
                what: what("MAPE"),
                published: mape,
                here: here.mape_percent,
                ours: ours.mape_percent,
                unit: "%",
            });
            near.push(Nearness { what: what("R²"), published: r2, here: here.r2, ours: ours.r2, unit: "" });
        }
    }
    for (window_s, mass_percent, mape_percent, r2) in PUBLISHED_WORST {
        let row = |method: &str| windows.iter().find(|row| row.window_s == window_s && row.method == method);
        if let (Some(here), Some(ours)) = (row("eq18-published"), row("signed")) {
            let what = |of: &str| format!("worst window of {window_s} s: {of}");
            let (here_mass, ours_mass) = (here.worst_mass_percent, ours.worst_mass_percent);
            near.push(Nearness {
                what: what("mass error"),
                published: mass_percent,
                here: here_mass,
                ours: ours_mass,
                unit: "%",
            });
            near.push(Nearness {
                what: what("MAPE"),
                published: mape_percent,
                here: here.mape_percent,
                ours: ours.mape_percent,
                unit: "%",
            });
            near.push(Nearness { what: what("R²"), published: r2, here: here.r2, ours: ours.r2, unit: "" });
        }
    }
    near
}
