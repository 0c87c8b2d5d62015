//! When to estimate the mass again: Fig. 4's policies and the change detector, on the same logs.

use answers::estimate::{Change, Instant, Policy, PolicyKind};
use fit::dataset::Row;
use plant::experiment::{Drive, SUPPLY_V};
use support::error::Result;

use super::contender::{CONTENDERS, Fitted, Log, moving};
use super::price::PricePoint;
use super::section7::Learned;
use super::spread::Spread;
use super::table::{Cell, Column, Format, Mark, Row as TableRow, Table, column};

/// Length of every window, s.
const WINDOW_S: f64 = 25.0;

/// Interval of the periodic policy, s: about half of a task.
const EVERY_S: f64 = 50.0;

/// Windows that are priced beside those of the sweep, s.
const SHORT_S: [u32; 3] = [1, 2, 3];

/// A mass is near the truth within this share.
const NEAR: f64 = 0.1;

/// A change's restart is the first one after it, up to this long, s.
const NOTICED_WITHIN_S: f64 = 30.0;

/// When the mass is estimated again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Again {
    Known,
    Periodic,
    Moving,
    Detected,
}

/// What is compared: a policy under a contender's estimator.
const COMPARED: [(&str, Again, usize); 7] = [
    ("known time (Fig. 4a)", Again::Known, 1),
    ("periodic (Fig. 4b)", Again::Periodic, 1),
    ("moving window (Fig. 11)", Again::Moving, 1),
    ("known time (Fig. 4a)", Again::Known, 0),
    ("periodic (Fig. 4b)", Again::Periodic, 0),
    ("moving window (Fig. 11)", Again::Moving, 0),
    ("change detector", Again::Detected, 0),
];

/// Of one comparison and one seed: delay (s, mean over the changes after which the estimate reached
/// the truth), false restarts an hour, energy error, the same with errors of both signs added,
/// share of the time without an estimate (%).
type Figures<T> = [T; 5];

/// What one seed gives.
pub(super) struct Seed {
    /// Of each comparison: figures, changes after which the estimate stayed wrong, changes.
    pub(super) outcomes: Vec<(Figures<f64>, u64, u64)>,
    /// Window, contender, misprediction with the old and with the new mass, W.
    pub(super) prices: Vec<(f64, usize, f64, f64)>,
    pub(super) rms_current_a: f64,
}

/// Drives and judges one seed.
pub(super) fn seed(learned: &Learned<'_>, windows_s: &[u32]) -> Result<Seed> {
    let fitted = &learned.fitted;
    let (log, _) = learned.drive(Drive::Errands)?;
    let outcomes = COMPARED
        .iter()
        .map(|(_, again, contender)| outcome(&fitted[*contender], &log, *again))
        .collect::<Result<Vec<_>>>()?;
    let mut prices = Vec::new();
    // A sensor may run for less than the shortest window of Fig. 12.
    for window_s in SHORT_S.iter().chain(windows_s).map(|window| f64::from(*window)) {
        for (index, fitted) in fitted.iter().enumerate().take(2) {
            let (old, new) = misprediction(fitted, &log, window_s)?;
            prices.push((window_s, index, old, new));
        }
    }
    let square = |row: &Row| (row.power / SUPPLY_V).powi(2);
    let mean_square = log.rows.iter().map(square).sum::<f64>() / log.rows.len() as f64;
    Ok(Seed { outcomes, prices, rms_current_a: mean_square.sqrt() })
}

fn outcome(fitted: &Fitted<'_>, log: &Log, again: Again) -> Result<(Figures<f64>, u64, u64)> {
    let tasks = log.tasks();
    let changes_s: Vec<f64> = tasks.iter().skip(1).map(|task| log.rows[task.from].time).collect();
    let (kind, known_s, detect) = match again {
        Again::Known => (PolicyKind::Known, changes_s.clone(), false),
        Again::Periodic => (PolicyKind::Periodic(EVERY_S), Vec::new(), false),
        Again::Moving => (PolicyKind::Moving, Vec::new(), false),
        Again::Detected => (PolicyKind::Moving, Vec::new(), true),
    };
    let policy = Policy { window_s: WINDOW_S, kind, changes_s: known_s, detect };
    let (replayed, instants) = fitted.follow(log, &policy)?;
    let delays: Vec<Option<f64>> = tasks
        .iter()
        .skip(1)
        .map(|task| delay(&instants[task.from..task.to], &log.rows[task.from..task.to], task.mass_kg))
        .collect();
    let known: Vec<f64> = delays.iter().flatten().copied().collect();
    let hours = replayed.duration_s / 3600.0;
    let false_restarts = match again {
        Again::Known | Again::Moving => 0,
        Again::Periodic => needless(&periodic_restarts(replayed.duration_s), &changes_s),
        Again::Detected => needless(&noticed(&replayed.changes), &changes_s),
    };
    let energy = Energy::of(fitted, log, &instants);
    let figures = [
        known.iter().sum::<f64>() / known.len() as f64,
        false_restarts as f64 / hours,
        100.0 * (energy.predicted_j / energy.measured_j - 1.0).abs(),
        100.0 * energy.apart_j / energy.measured_j,
        100.0 * energy.unknown_share,
    ];
    Ok((figures, (delays.len() - known.len()) as u64, delays.len() as u64))
}

/// Time from the start of a task until the estimate is near its mass for good, s.
fn delay(instants: &[Instant], rows: &[Row], mass_kg: f64) -> Option<f64> {
    let is_near = |now: &Instant| now.mass_kg.is_some_and(|mass| (mass / mass_kg - 1.0).abs() <= NEAR);
    let from = instants.iter().rposition(|now| !is_near(now)).map_or(0, |last| last + 1);
    Some(rows.get(from)?.time - rows.first()?.time)
}

fn periodic_restarts(duration_s: f64) -> Vec<f64> {
    (1..).map(|round| f64::from(round) * EVERY_S).take_while(|time| *time < duration_s).collect()
}

fn noticed(changes: &[Change]) -> Vec<f64> {
    changes.iter().map(|change| change.noticed_s).collect()
}

/// Restarts without a payload change: each change accounts for the first one within
/// [`NOTICED_WITHIN_S`] after it.
fn needless(restarts_s: &[f64], changes_s: &[f64]) -> usize {
    let asked = changes_s.iter().filter(|change| {
        restarts_s.iter().any(|restart| (0.0..=NOTICED_WITHIN_S).contains(&(restart - **change)))
    });
    restarts_s.len() - asked.count().min(restarts_s.len())
}

/// Energies of a log, J. Where the mass is unknown the last known one is used, as for planning.
struct Energy {
    measured_j: f64,
    predicted_j: f64,
    apart_j: f64,
    unknown_share: f64,
}

impl Energy {
    fn of(fitted: &Fitted<'_>, log: &Log, instants: &[Instant]) -> Self {
        let mut energy = Self { measured_j: 0.0, predicted_j: 0.0, apart_j: 0.0, unknown_share: 0.0 };
        let (mut last, mut unknown, mut counted) = (None, 0_u64, 0_u64);
        for ((row, now), before) in log.rows.iter().zip(instants).skip(1).zip(&log.rows) {
            unknown += u64::from(now.mass_kg.is_none());
            counted += 1;
            last = now.mass_kg.or(last);
            // No prediction before the first estimate.
            let Some(mass) = last else { continue };
            let step_s = row.time - before.time;
            let predicted = fitted.power(row, mass);
            energy.measured_j += row.power * step_s;
            energy.predicted_j += predicted * step_s;
            energy.apart_j += (predicted - row.power).abs() * step_s;
        }
        energy.unknown_share = unknown as f64 / counted as f64;
        energy
    }
}

/// Misprediction of a task's power with the previous task's mass, and with that of the task's first
/// window: mean over its rows of |P̂(m) − P̂(truth)|, then over tasks, W. Where that window gives
/// no mass, the previous one stays.
fn misprediction(fitted: &Fitted<'_>, log: &Log, window_s: f64) -> Result<(f64, f64)> {
    let (replayed, _) = fitted.follow(log, &moving(window_s, false))?;
    let tasks = log.tasks();
    let (mut old, mut new, mut count) = (0.0, 0.0, 0.0);
    for pair in tasks.windows(2) {
        let [before, task] = pair else { continue };
        let rows = &log.rows[task.from..task.to];
        let Some(start_s) = rows.first().map(|row| row.time) else { continue };
        // The last errand may be shorter than the window.
        let Some(first) = replayed.windows.iter().find(|window| window.t0_s >= start_s) else { continue };
        let mean = |mass: f64| {
            let apart = |row: &Row| (fitted.power(row, mass) - fitted.power(row, task.mass_kg)).abs();
            rows.iter().map(apart).sum::<f64>() / rows.len() as f64
        };
        old += mean(before.mass_kg);
        new += mean(first.mass_kg.unwrap_or(before.mass_kg));
        count += 1.0;
    }
    Ok((old / count, new / count))
}

const COLUMNS: [Column; 8] = [
    column("policy", "policy", Format::Words),
    column("method", "estimator", Format::Words),
    column("delay_s", "delay s", Format::Error(1)),
    column("never", "never", Format::AsShown),
    column("false_restarts_per_hour", "needless restarts 1/h", Format::Error(1)),
    column("energy_error_percent", "energy error %", Format::Error(2)),
    column("absolute_energy_error_percent", "absolute %", Format::Error(2)),
    column("unknown_percent", "unknown %", Format::Share(1)),
];

/// Every comparison over all seeds.
pub(super) fn table(seeds: &[Seed]) -> Table {
    let row = |(index, (policy, _, contender)): (usize, &(&str, Again, usize))| {
        let outcomes = || seeds.iter().filter_map(|seed| seed.outcomes.get(index));
        let [delay, restarts, error, absolute, unknown] =
            Spread::of_each(outcomes().map(|outcome| outcome.0)).map(Cell::from);
        let never: u64 = outcomes().map(|outcome| outcome.1).sum();
        let changes: u64 = outcomes().map(|outcome| outcome.2).sum();
        let never = Cell::shown(vec![never, changes], format!("{never} of {changes}"));
        let method = CONTENDERS[*contender].name;
        TableRow::new(
            Mark::None,
            [(*policy).into(), method.into(), delay, never, restarts, error, absolute, unknown],
        )
    };
    Table {
        name: "recalibration",
        title: "Fig. 4: policies of recalibration, and the change detector",
        columns: &COLUMNS,
        rows: COMPARED.iter().enumerate().map(row).collect(),
        note: "delay: from a change until the mass is within 10 % for good, mean over the changes after which it ever is; never: changes \
               after which it is not; needless restarts: those that no change asked for, of the periodic policy its rounds without one; energy error: of the total, absolute: errors of both signs added up"
            .to_owned(),
    }
}

/// What sensing saves, by window and contender.
pub(super) fn prices(seeds: &[Seed]) -> Vec<PricePoint> {
    let Some(first) = seeds.first() else { return Vec::new() };
    let mean = |value: &dyn Fn(&Seed) -> Option<f64>| {
        Spread::over(&seeds.iter().filter_map(value).collect::<Vec<_>>()).mean
    };
    let actuation_a = mean(&|seed| Some(seed.rms_current_a));
    let point = |(index, (window_s, contender, ..)): (usize, &(f64, usize, f64, f64))| PricePoint {
        window_s: *window_s,
        method: CONTENDERS[*contender].name,
        old_mass_w: mean(&|seed| Some(seed.prices.get(index)?.2)),
        new_mass_w: mean(&|seed| Some(seed.prices.get(index)?.3)),
        actuation_a,
    };
    first.prices.iter().enumerate().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::needless;

    #[test]
    fn a_change_asks_for_one_restart() {
        // Changes at 100 and 200 s; the restart at 105 s is the first one's, those at 20, 110 and
        // 290 s nobody's.
        assert_eq!(needless(&[20.0, 105.0, 110.0, 290.0], &[100.0, 200.0]), 3);
        assert_eq!(needless(&[], &[100.0]), 0);
        assert_eq!(needless(&[99.0], &[100.0]), 1);
    }
}
