//! Section 6: the simulated robot of Tables 2 and 3, seed by seed.

use std::path::Path;

use super::contender::{CONTENDERS, Fitted, Log, training};
use super::spread_of;
use super::study::{Course, PublishedSimulation, Simulation, SimulationRow};
use crate::compare::points::Wanted;
use crate::error::Result;
use crate::estimate::{Policy, PolicyKind, Replay, WindowMass};
use crate::metrics::{Metrics, Quality};
use crate::plant::log::{Columns, write};
use crate::plant::{Kinematics, PayloadSchedule, PlantSet, ProfileKind, Scenario};
use crate::robot::Robot;

/// The window of Fig. 6, s.
const WINDOW_S: f64 = 10.0;

/// When the payload changes in training and in the test, s.
const CHANGES_S: [f64; 2] = [100.0, 50.0];

/// What one seed gives: a figure a contender.
pub(super) struct Seed {
    outcomes: Vec<Outcome>,
    figures: Option<[Course; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Outcome {
    quality: Quality,
    after_start_percent: f64,
    after_change_percent: f64,
    worst_start_percent: f64,
}

/// The logs of a seed: training from 1 to 6 kg, test from 3 to 4 kg, exact sensors as in the paper's Simulink.
pub(super) fn scenarios(seed: u64) -> Result<[Scenario; 2]> {
    let scenario = |profile, change_s: f64, masses: [f64; 2], seed| {
        let duration_s = 2.0 * change_s;
        let scenario = Scenario::new(PlantSet::Table3, Kinematics::Differential, profile, duration_s, seed);
        let payload = PayloadSchedule::steps(vec![(0.0, masses[0]), (change_s, masses[1])])?;
        Ok(Scenario { payload, ..scenario })
    };
    let [train_s, test_s] = CHANGES_S;
    Ok([
        scenario(ProfileKind::Training, train_s, [1.0, 6.0], 2 * seed)?,
        scenario(ProfileKind::Test, test_s, [3.0, 4.0], 2 * seed + 1)?,
    ])
}

/// Drives, fits and judges one seed. `draw` keeps what figures need.
pub(super) fn seed(folder: &Path, robot: &Robot, seed: u64, draw: bool) -> Result<Seed> {
    let file = |name: &str| folder.join(format!("table3-{name}-{seed}.csv"));
    let (train, test) = (file("training"), file("test"));
    for (scenario, file) in scenarios(seed)?.iter().zip([&train, &test]) {
        write(file, scenario, &Columns::default())?;
    }
    let dataset = training(robot, &train)?;
    let wanted = Wanted::of(robot, &[train.clone(), test.clone()])?;
    let known = Log::read(robot, &dataset, &train, &wanted)?;
    let log = Log::read(robot, &dataset, &test, &wanted)?;
    let fitted =
        CONTENDERS.iter().map(|contender| contender.fit(robot, &dataset)).collect::<Result<Vec<_>>>()?;
    let outcomes = fitted.iter().map(|one| judge(one, &log, robot.mape_floor_w())).collect::<Result<_>>()?;
    let figures = if draw { Some(figures(&fitted, &known, &log)?) } else { None };
    Ok(Seed { outcomes, figures })
}

/// Step two once a task, over its first ten seconds; step three with that mass.
fn judge(fitted: &Fitted<'_>, log: &Log, floor_w: f64) -> Result<Outcome> {
    let (replayed, _) = fitted.follow(log, &super::contender::moving(WINDOW_S, false))?;
    let mut metrics = Metrics::new(floor_w);
    let mut first_percent = [f64::NAN; 2];
    let mut worst = f64::NAN;
    for (task, first_percent) in log.tasks().iter().zip(&mut first_percent) {
        let error = |mass: f64| 100.0 * (mass / task.mass_kg - 1.0).abs();
        let masses: Vec<f64> = of_task(&replayed, task.mass_kg).filter_map(|window| window.mass_kg).collect();
        worst = masses.iter().map(|mass| error(*mass)).fold(worst, f64::max);
        // A window in which the robot stood says nothing: the next one is asked.
        let Some(mass) = masses.first() else { continue };
        *first_percent = error(*mass);
        for row in &log.rows[task.from..task.to] {
            metrics.add(row.power, fitted.power(row, *mass));
        }
    }
    let [after_start_percent, after_change_percent] = first_percent;
    let quality = metrics.quality().unwrap_or(super::windows::NO_QUALITY);
    Ok(Outcome { quality, after_start_percent, after_change_percent, worst_start_percent: worst })
}

fn of_task(replayed: &Replay, mass_kg: f64) -> impl Iterator<Item = &WindowMass> {
    replayed.windows.iter().filter(move |window| window.truth_kg == Some(mass_kg))
}

fn figures(fitted: &[Fitted<'_>], known: &Log, log: &Log) -> Result<[Course; 3]> {
    let follow = |policy: &Policy| -> Result<Course> {
        let methods = fitted
            .iter()
            .map(|fitted| Ok(fitted.followed(&fitted.follow(log, policy)?.1)))
            .collect::<Result<Vec<_>>>()?;
        Ok(Course { trace: log.trace(), methods })
    };
    let [_, change_s] = CHANGES_S;
    let known_change =
        Policy { window_s: WINDOW_S, kind: PolicyKind::Known, changes_s: vec![change_s], detect: false };
    Ok([
        Course { trace: known.trace(), methods: fitted.iter().map(|fitted| fitted.told(known)).collect() },
        follow(&known_change)?,
        follow(&super::contender::moving(WINDOW_S, false))?,
    ])
}

/// Section 6 as published.
const PUBLISHED: PublishedSimulation = PublishedSimulation {
    mape_percent: 4.3,
    r2: 0.973,
    after_start_percent: 5.6,
    after_change_percent: 5.5,
    worst_start_percent: 22.0,
};

/// Over all seeds, in their order; the first one is drawn.
pub(super) fn gather(seeds: Vec<Seed>) -> Simulation {
    let rows = CONTENDERS.iter().enumerate().map(|(index, contender)| {
        let spread =
            |value: fn(&Outcome) -> Option<f64>| spread_of(&seeds, |seed| value(seed.outcomes.get(index)?));
        SimulationRow {
            method: contender.name.to_owned(),
            mape_percent: spread(|outcome| outcome.quality.mape_percent),
            r2: spread(|outcome| outcome.quality.r2),
            after_start_percent: spread(|outcome| Some(outcome.after_start_percent)),
            after_change_percent: spread(|outcome| Some(outcome.after_change_percent)),
            worst_start_percent: spread(|outcome| Some(outcome.worst_start_percent)),
        }
    });
    let rows = rows.collect();
    let drawn = seeds.into_iter().find_map(|seed| seed.figures);
    let [training, test, moving] = drawn.unwrap_or_default();
    Simulation { training, test, moving, rows, published: PUBLISHED }
}
