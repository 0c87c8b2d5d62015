//! Section 6: the simulated robot of Tables 2 and 3, seed by seed.

use std::path::Path;

use answers::estimate::{Policy, PolicyKind};
use logs::robot::Robot;
use plant::log::{Columns, write};
use plant::{Kinematics, PayloadSchedule, PlantSet, Profile, ProfileKind, Rounds, Scenario};
use serde_json::Value;
use support::context::Context;
use support::error::Result;
use support::metrics::Metrics;

use super::contender::{CONTENDERS, Fitted, Log, moving, training};
use super::course::Course;
use super::spread::Spread;
use super::table::{Cell, Column, Format, Mark, Row, Table, column, number};
use crate::compare::points::Wanted;

/// The window of Fig. 6, s.
const WINDOW_S: f64 = 10.0;

/// When the payload changes in training and in the test, s.
const CHANGES_S: [f64; 2] = [100.0, 50.0];

/// Figures of a method: MAPE (%) and R² of the predicted power; mass error of the first window, of
/// the first one after the change, of the worst one (%).
type Figures<T> = [T; 5];

/// Drives of Section 6's simulation, beside the payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Drives {
    /// Arcs, turns on the spot, stops and legs in reverse, as brisk as the robot's limits allow:
    /// the paper does not say.
    Any,
    /// Forward arcs that change speed by 0.3 m/s² at most.
    Gentle,
}

/// As tables call gentle drives.
const GENTLE: &str = "forward, ≤ 0.3 m/s²";

/// Rounds of gentle drives.
const GENTLE_ROUNDS: Rounds = Rounds {
    speed: (0.2, 1.0),
    curve: 0.3,
    hold_s: (1.0, 5.0),
    acceleration_m_s2: (0.05, 0.3),
    shares: [0.0; 3],
};

/// What one seed gives.
pub(super) struct Seed {
    /// In the order of the contenders: any drives, then gentle ones.
    pub(super) outcomes: Vec<Figures<f64>>,
    /// Training, payload known; test, payload from the first 10 s of each task; test, moving window
    /// of 10 s.
    pub(super) courses: Option<[Course; 3]>,
}

/// The logs of a seed: training from 1 to 6 kg, test from 3 to 4 kg, exact sensors as in the
/// paper's Simulink.
pub(super) fn scenarios(drives: Drives, seed: u64) -> Result<[Scenario; 2]> {
    let scenario = |profile, change_s: f64, masses: [f64; 2], seed| {
        let duration_s = 2.0 * change_s;
        let mut scenario =
            Scenario::new(PlantSet::Table3, Kinematics::Differential, profile, duration_s, seed);
        if drives == Drives::Gentle {
            let robot = &scenario.robot;
            scenario.profile =
                Profile::rounds(&robot.geometry, &robot.limits, duration_s, &GENTLE_ROUNDS, seed);
        }
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
pub(super) fn seed(context: &Context, folder: &Path, robot: &Robot, seed: u64, draw: bool) -> Result<Seed> {
    let mut any = judged(context, folder, robot, Drives::Any, seed, draw)?;
    any.outcomes.extend(judged(context, folder, robot, Drives::Gentle, seed, false)?.outcomes);
    Ok(any)
}

/// Every contender on drives of a kind.
fn judged(
    context: &Context,
    folder: &Path,
    robot: &Robot,
    drives: Drives,
    seed: u64,
    draw: bool,
) -> Result<Seed> {
    let file = |name: &str| folder.join(format!("table3-{}-{name}-{seed}.csv", drives as u8));
    let [train, test] = ["training", "test"].map(file);
    for (scenario, file) in scenarios(drives, seed)?.iter().zip([&train, &test]) {
        write(file, scenario, &Columns::default())?;
    }
    let dataset = training(context, robot, &train)?;
    let wanted = Wanted::of(context, robot, &[train.clone(), test.clone()])?;
    let known = Log::read(context, robot, &dataset, &train, &wanted)?;
    let log = Log::read(context, robot, &dataset, &test, &wanted)?;
    let fitted = CONTENDERS
        .iter()
        .map(|contender| contender.fit(context, robot, &dataset))
        .collect::<Result<Vec<_>>>()?;
    let outcomes = fitted.iter().map(|one| judge(one, &log, robot.mape_floor_w())).collect::<Result<_>>()?;
    let courses = if draw { Some(courses(&fitted, &known, &log)?) } else { None };
    Ok(Seed { outcomes, courses })
}

/// Step two once a task, over its first ten seconds; step three with that mass.
fn judge(fitted: &Fitted<'_>, log: &Log, floor_w: f64) -> Result<Figures<f64>> {
    let (replayed, _) = fitted.follow(log, &moving(WINDOW_S, false))?;
    let mut metrics = Metrics::new(floor_w);
    let mut first_percent = [f64::NAN; 2];
    let mut worst = f64::NAN;
    for (task, first_percent) in log.tasks().iter().zip(&mut first_percent) {
        let error = |mass: f64| 100.0 * (mass / task.mass_kg - 1.0).abs();
        let windows = replayed.windows.iter().filter(|window| window.truth_kg == Some(task.mass_kg));
        let masses: Vec<f64> = windows.filter_map(|window| window.mass_kg).collect();
        worst = masses.iter().map(|mass| error(*mass)).fold(worst, f64::max);
        // A window at rest gives no mass: the next one counts.
        let Some(mass) = masses.first() else { continue };
        *first_percent = error(*mass);
        for row in &log.rows[task.from..task.to] {
            metrics.add(row.power, fitted.power(row, *mass));
        }
    }
    let quality = metrics.quality();
    let mape = quality.and_then(|quality| quality.mape_percent).unwrap_or(f64::NAN);
    let r2 = quality.and_then(|quality| quality.r2).unwrap_or(f64::NAN);
    Ok([mape, r2, first_percent[0], first_percent[1], worst])
}

fn courses(fitted: &[Fitted<'_>], known: &Log, log: &Log) -> Result<[Course; 3]> {
    let [_, change_s] = CHANGES_S;
    let known_change =
        Policy { window_s: WINDOW_S, kind: PolicyKind::Known, changes_s: vec![change_s], detect: false };
    Ok([
        Course { trace: known.trace(), methods: fitted.iter().map(|one| one.given_mass(known)).collect() },
        log.course(fitted, |_| known_change.clone())?,
        log.course(fitted, |_| moving(WINDOW_S, false))?,
    ])
}

const COLUMNS: [Column; 6] = [
    column("method", "method", Format::Words),
    column("mape_percent", "MAPE %", Format::Error(2)),
    column("r2", "R²", Format::R2(4)),
    column("after_start_percent", "mass error after start %", Format::Error(2)),
    column("after_change_percent", "after change %", Format::Error(2)),
    column("worst_start_percent", "worst start %", Format::Error(2)),
];

/// As published, with the digits that it has.
const PUBLISHED: Figures<(f64, usize)> = [(4.3, 1), (0.973, 3), (5.6, 1), (5.5, 1), (22.0, 1)];

/// The published figures for scripts.
pub(super) fn published() -> Value {
    let named = COLUMNS[1..].iter().zip(PUBLISHED);
    named.map(|(column, (value, _))| (column.key.to_owned(), Value::from(value))).collect()
}

/// Every contender's figures over all seeds: on any drives, then on gentle ones.
pub(super) fn rows(seeds: &[Seed]) -> Vec<(String, Figures<Spread>)> {
    let of = |place: usize| {
        seeds.iter().map(move |seed| seed.outcomes.get(place).copied().unwrap_or([f64::NAN; 5]))
    };
    let names = CONTENDERS.iter().map(|contender| contender.name.to_owned());
    let gentle = CONTENDERS.iter().map(|contender| format!("{}, {GENTLE}", contender.name));
    names.chain(gentle).enumerate().map(|(place, name)| (name, Spread::of_each(of(place)))).collect()
}

/// The section's table.
pub(super) fn table(rows: &[(String, Figures<Spread>)]) -> Table {
    let published = PUBLISHED.map(|(value, digits)| Cell::shown(value, number(value, digits)));
    let published = Row::new(Mark::Published, std::iter::once("published".into()).chain(published));
    let ours = |place| if place % CONTENDERS.len() == 0 { Mark::Ours } else { Mark::None };
    let rows = rows.iter().enumerate().map(|(place, (name, figures))| {
        Row::new(ours(place), std::iter::once(name.as_str().into()).chain(figures.map(Cell::from)))
    });
    Table {
        name: "simulation",
        title: "Section 6: simulation of Tables 2 and 3, windows of 10 s",
        columns: &COLUMNS,
        rows: std::iter::once(published).chain(rows).collect(),
        note: "power with the mass of each task's first 10 s; worst start: the worst of both payloads; published: Section 6 and Section 8; \
               the published figures are not reproduced: the profiles are not given; forward, ≤ 0.3 m/s²: drives ahead that change speed by no more"
            .to_owned(),
    }
}
