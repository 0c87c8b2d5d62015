//! The simulation's side: the plant driven along the measured wheel speeds, before and after the
//! named effect is added to it.
//!
//! The plant shares no formula with the model. It is calibrated on runs without effects and gets
//! the effect as a physical cause. The size of the cause is fitted to the open runs; the locked
//! runs then have to come closer.

pub mod calibrate;
pub mod filter;
pub mod search;
pub mod track;

use std::panic::resume_unwind;
use std::sync::Arc;
use std::thread;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::runs::RawRun;
use model::effects::plant::{Finding, PlantCause, Scene};
use model::effects::{Regressor, Switched, cause};
use plant::PlantSet;
use serde_json::{Map, Value, json};
use support::error::Result;

use self::filter::PowerFilter;
use self::search::squares;
use self::track::Follower;
use super::confirm;
use crate::report::Report;
use crate::report::localise::{self, Cell};
use crate::report::page::{self, Course};
use residuals::predictor::Predictor;
use residuals::thresholds::driven_plant::FOLLOWS;

/// An effect in the plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Acting {
    /// Its id.
    pub id: String,
    /// Its size in the plant, in `unit`.
    pub size: f64,
    /// The unit of the plant's cause, with what it means.
    pub unit: &'static str,
}

/// An effect that the plant was not given.
#[derive(Debug, Clone, PartialEq)]
pub struct Missing {
    /// Its id.
    pub id: String,
    /// Why not.
    pub reason: String,
}

/// What the simulation says.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Motors of the plant.
    pub plant: PlantSet,
    /// Parameters that were fitted, with their units.
    pub parameters: Map<String, Value>,
    /// Runs that they were fitted to.
    pub calibrated_on: Vec<String>,
    /// Root mean square of measured less simulated power on them, W: the plant's error without
    /// effects.
    pub calibrated_w: f64,
    /// Error of the plant's wheel speeds as a share of the recorded ones: the worst run.
    pub missed: f64,
    /// Effects added.
    pub effects: Vec<Acting>,
    /// Effects that could not be.
    pub not_simulated: Vec<Missing>,
    /// Root mean square of measured less simulated power on the locked runs without effects, W.
    pub before_w: f64,
    /// The same with them.
    pub after_w: f64,
    /// The part of it that nothing removes, W: the model's noise floor, or the plant's error
    /// without effects if that is greater.
    pub floor_w: f64,
    /// Share of the gap that is closed; `None` without effects.
    pub closed: Option<f64>,
    /// Where measured and simulated power disagree without effects, on the locked runs.
    pub cells_before: Vec<Cell>,
    /// And with them.
    pub cells_after: Vec<Cell>,
    /// All runs, in the order of the command line: measured, and simulated before and after.
    pub runs: Vec<Course>,
}

/// Runs the plant along the runs that were investigated.
///
/// # Errors
/// A robot whose wheels the plant cannot have; runs that it cannot follow.
pub fn simulate(
    set: PlantSet,
    robot: &Robot,
    chassis: &Chassis,
    raw: &[RawRun],
    clean: Option<&[RawRun]>,
    report: &Report,
) -> Result<Simulated> {
    let mut follower = Follower::new(set, robot)?;
    let open: Vec<RawRun> = report.split.open.iter().map(|&place| raw[place].clone()).collect();
    let calibration = clean.unwrap_or(&open);
    follower.calibrate(chassis, calibration)?;
    let calibrated_w = gap(chassis, &follower, calibration)?;

    let filter = PowerFilter::new(chassis, raw)?;
    let mut missed = 0.0_f64;
    let none = drive(&follower, chassis, raw, |_| Ok(Vec::new()), &mut missed)?;
    let before = filter.filtered(&none)?;
    let lightest_kg =
        raw.iter().flat_map(|run| &run.rows).map(|(_, _, mass, _)| *mass).fold(f64::INFINITY, f64::min);
    let (mut causes, mut not_simulated): (Vec<(PlantCause, f64)>, Vec<Missing>) = Default::default();
    let stands = report.verdict.stands();
    let locked_times = locked_times(&filter, report);
    let mut ids = Vec::new();
    for named in report.effects.iter().filter(|_| stands) {
        let times = named.candidate.regressors.iter().find_map(|regressor| match regressor {
            Regressor::Switch(what, _) => locked_times.iter().find(|(other, _)| other == what),
            _ => None,
        });
        let scene = Scene {
            open: &report.split.open,
            locked: &report.split.locked,
            runs: raw.len(),
            locked_times: times.map(|(_, times)| &times[..]),
            rolling: follower.machine.wheels[0].rolling_resistance,
            lightest_kg,
        };
        let finding =
            Finding { candidate: &named.candidate, coefficients: &named.coefficients, scene: &scene };
        match cause(&finding)? {
            Ok(cause) => {
                ids.push(named.candidate.id.clone());
                causes.push((cause, 0.0));
            }
            Err(reason) => not_simulated.push(Missing { id: named.candidate.id.clone(), reason }),
        }
    }
    find_sizes(&follower, chassis, raw, report, &mut causes)?;
    let acting = |run: usize| -> Result<Vec<_>> {
        Ok(causes.iter().map(|(cause, size)| cause.in_run(*size, run)).collect::<Result<Vec<_>>>()?.concat())
    };
    let after = if causes.is_empty() {
        before.clone()
    } else {
        filter.filtered(&drive(&follower, chassis, raw, acting, &mut missed)?)?
    };

    let locked = filter.measured.subset(&report.split.locked);
    let residual = |simulated: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let runs = locked.runs.iter().zip(&report.split.locked);
        runs.map(|(run, &place)| {
            run.rows.iter().zip(&simulated[place]).map(|(row, s)| row.power - s).collect()
        })
        .collect()
    };
    let (residual_before, residual_after) = (residual(&before), residual(&after));
    let mean = |residual: &[Vec<f64>]| {
        residual.iter().map(|run| squares(run)).sum::<f64>()
            / residual.iter().map(Vec::len).sum::<usize>().max(1) as f64
    };
    let (before_w2, after_w2) = (mean(&residual_before), mean(&residual_after));
    // The plant's error on clean runs belongs to no effect. Without clean runs that error is
    // unknown.
    let plant_w2 = if clean.is_some() { calibrated_w.powi(2) } else { 0.0 };
    let floor_w2 = report.confirmed.floor_w.powi(2).max(plant_w2).min(after_w2);
    let effects: Vec<Acting> = ids
        .into_iter()
        .zip(&causes)
        .map(|(id, (cause, size))| {
            let unit = cause.effects.first().map_or("", |effect| effect.entry().unit);
            Acting { id, size: *size, unit }
        })
        .collect();
    let has_effects = !effects.is_empty();
    let to_close = before_w2 - floor_w2;
    let closed = (has_effects && to_close > 0.0).then(|| (before_w2 - after_w2) / to_close);
    let traces = filter.measured.runs.iter().zip(before).zip(after).enumerate();
    Ok(Simulated {
        plant: set,
        parameters: follower.parameters(),
        calibrated_on: calibration.iter().map(|run| run.name.clone()).collect(),
        calibrated_w,
        missed,
        effects,
        not_simulated,
        before_w: before_w2.sqrt(),
        after_w: after_w2.sqrt(),
        floor_w: floor_w2.sqrt(),
        closed,
        cells_before: localise::cells(&locked, &residual_before),
        cells_after: localise::cells(&locked, &residual_after),
        runs: traces
            .map(|(place, ((run, before_w), after_w))| Course {
                name: run.name.clone(),
                locked: report.split.locked.contains(&place),
                time_s: run.rows.iter().map(|row| row.time).collect(),
                measured_w: run.rows.iter().map(|row| row.power).collect(),
                before_w,
                after_w: has_effects.then_some(after_w),
            })
            .collect(),
    })
}

/// Searches the sizes on the open runs, one after the other; twice where there are several.
fn find_sizes(
    follower: &Follower,
    chassis: &Chassis,
    raw: &[RawRun],
    report: &Report,
    causes: &mut [(PlantCause, f64)],
) -> Result<()> {
    let places = &report.split.open;
    let open: Vec<RawRun> = places.iter().map(|&place| raw[place].clone()).collect();
    let filter = PowerFilter::new(chassis, &open)?;
    let measured: Vec<f64> =
        filter.measured.runs.iter().flat_map(|run| &run.rows).map(|row| row.power).collect();
    let rounds = if causes.len() > 1 { 2 } else { 1 };
    for _ in 0..rounds {
        for searched in 0..causes.len() {
            let power = |size: f64| -> Result<Vec<f64>> {
                let effects = |run: usize| -> Result<Vec<_>> {
                    let mut all = Vec::new();
                    for (place, (cause, at)) in causes.iter().enumerate() {
                        all.extend(cause.in_run(if place == searched { size } else { *at }, places[run])?);
                    }
                    Ok(all)
                };
                let power = drive(follower, chassis, &open, effects, &mut 0.0)?;
                Ok(filter.filtered(&power)?.concat())
            };
            let without = power(0.0)?;
            let (size, _) = search::size(power, &measured, &without, causes[searched].0.range)?;
            causes[searched].1 = size;
        }
    }
    Ok(())
}

/// Times of steps in the locked runs, for steps at a time per run.
fn locked_times(filter: &PowerFilter<'_>, report: &Report) -> Vec<(Switched, Arc<[f64]>)> {
    let locked = filter.measured.subset(&report.split.locked);
    let Some(basis) = &report.basis else { return Vec::new() };
    let predictor = Predictor { clean_delay: basis.clean_delay, ..Predictor::new(&locked, basis.drive) };
    let common =
        report.state.effects.iter().filter(|(regressor, _)| matches!(regressor, Regressor::Switch(..)));
    let switches: Vec<(Regressor, f64)> = common.cloned().collect();
    let timed = confirm::with_run_times(&predictor, report.state.torque, switches);
    let times = timed.into_iter().filter_map(|(regressor, _)| match regressor {
        Regressor::Switch(what, times) => Some((what, times)),
        _ => None,
    });
    times.collect()
}

/// Power of all runs, W, a value a row of the log, and the worst share of the speeds that was
/// missed.
fn drive(
    follower: &Follower,
    chassis: &Chassis,
    runs: &[RawRun],
    effects: impl Fn(usize) -> Result<Vec<plant::Effect>> + Sync,
    missed: &mut f64,
) -> Result<Vec<Vec<f64>>> {
    let followed = in_parallel(runs, |place, run| follower.follow(chassis, run, &effects(place)?))?;
    *missed = followed.iter().map(|followed| followed.missed).fold(*missed, f64::max);
    Ok(runs.iter().zip(&followed).map(|(run, followed)| followed.power(run, follower.delay_s)).collect())
}

/// Root mean square of measured less simulated power of runs without effects, W.
fn gap(chassis: &Chassis, follower: &Follower, runs: &[RawRun]) -> Result<f64> {
    let power = drive(follower, chassis, runs, |_| Ok(Vec::new()), &mut 0.0)?;
    let residual = PowerFilter::new(chassis, runs)?.residual(&power)?;
    Ok((squares(&residual) / residual.len().max(1) as f64).sqrt())
}

/// Works on runs on two threads.
fn in_parallel<T: Send>(
    runs: &[RawRun],
    work: impl Fn(usize, &RawRun) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let half = runs.len() / 2;
    let (first, second) = runs.split_at(half);
    let work = &work;
    thread::scope(|scope| {
        let other = scope.spawn(move || (0..).zip(first).map(|(k, run)| work(k, run)).collect::<Vec<_>>());
        let here: Vec<_> = (half..).zip(second).map(|(k, run)| work(k, run)).collect();
        other.join().unwrap_or_else(|panic| resume_unwind(panic)).into_iter().chain(here).collect()
    })
}

impl Simulated {
    /// For scripts; the traces are left to the plots.
    pub fn json(&self) -> Value {
        let effects: Vec<Value> = self
            .effects
            .iter()
            .map(|effect| json!({"id": effect.id, "size": effect.size, "unit": effect.unit}))
            .collect();
        let missing: Vec<Value> = self
            .not_simulated
            .iter()
            .map(|missing| json!({"id": missing.id, "reason": missing.reason}))
            .collect();
        let runs: Vec<Value> = self
            .runs
            .iter()
            .map(|run| {
                let (before, after) = run.gaps();
                let after = after.unwrap_or(before);
                json!({"run": run.name, "locked": run.locked, "gap_before_w": before, "gap_after_w": after})
            })
            .collect();
        json!({
            "plant": self.plant,
            "parameters": self.parameters,
            "calibrated_on": self.calibrated_on,
            "calibrated_gap_w": self.calibrated_w,
            "speed_missed": self.missed,
            "effects": effects,
            "not_simulated": missing,
            "gap_before_w": self.before_w,
            "gap_after_w": self.after_w,
            "noise_floor_w": self.floor_w,
            "gap_closed": self.closed,
            "localisation_before": self.cells_before,
            "localisation_after": self.cells_after,
            "runs": runs,
        })
    }

    /// As the page shows it.
    pub fn picture(&self) -> page::Simulated {
        let after = self.cells_after.iter().map(Some).chain(std::iter::repeat(None));
        let cells = self.cells_before.iter().zip(after).map(|(before, after)| Cell {
            mean_after_w: after.map(|after| after.mean_residual_w),
            band_after_w: after.map(|after| after.band_w),
            ..before.clone()
        });
        page::Simulated { text: vec![self.line()], courses: self.runs.clone(), cells: cells.collect() }
    }

    /// One line for the terminal.
    pub fn line(&self) -> String {
        let mut line = format!(
            "simulation ({}): {:.4} W before",
            serde_json::to_value(self.plant)
                .ok()
                .and_then(|name| name.as_str().map(str::to_owned))
                .unwrap_or_default(),
            self.before_w
        );
        if !self.effects.is_empty() {
            let effects: Vec<String> =
                self.effects.iter().map(|effect| format!("{} {:.3e}", effect.id, effect.size)).collect();
            line += &format!(", {:.4} W with {} in the plant", self.after_w, effects.join(", "));
        }
        if let Some(closed) = self.closed {
            line += &format!("; {:.0} % closed", 100.0 * closed);
        }
        for missing in &self.not_simulated {
            line += &format!("; {} not simulated: {}", missing.id, missing.reason);
        }
        if self.missed > FOLLOWS {
            line += &format!("; its wheels are {:.0} % off the recorded speeds", 100.0 * self.missed);
        }
        line
    }
}
