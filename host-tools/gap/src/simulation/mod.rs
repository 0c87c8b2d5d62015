//! The simulation's side: the plant driven along the measured wheel speeds, before and after the
//! named effect is added to it.
//!
//! The plant shares no formula with the model. It is calibrated on runs without effects, gets the
//! effect as a physical cause whose size is searched for on the open runs, and has to come closer
//! to the locked ones.

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
use model::effects::plant::{Finding, Part, Scene};
use model::effects::{Regressor, Switched, cause};
use plant::PlantSet;
use serde_json::{Map, Value, json};
use support::error::Result;

use self::filter::Behind;
use self::search::squares;
use self::track::Follower;
use super::confirm;
use crate::report::Report;
use crate::report::localise::{self, Cell};
use crate::report::page::{self, Course};
use residuals::thresholds::simulation::FOLLOWS;
use residuals::twin::Twin;
use residuals::types::Verdict;

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

/// One run, after the common filter: a value a row.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// Whether it was locked.
    pub locked: bool,
    /// Time since its start, s.
    pub time_s: Vec<f64>,
    /// Measured power, W.
    pub measured_w: Vec<f64>,
    /// Simulated power without effects, W.
    pub before_w: Vec<f64>,
    /// Simulated power with them, W.
    pub after_w: Vec<f64>,
}

impl Trace {
    /// Root mean square of measured less simulated power before and after, W.
    pub fn gap_w(&self) -> (f64, f64) {
        let gap = |simulated: &[f64]| {
            let sum: f64 = self.measured_w.iter().zip(simulated).map(|(m, s)| (m - s).powi(2)).sum();
            (sum / self.measured_w.len().max(1) as f64).sqrt()
        };
        (gap(&self.before_w), gap(&self.after_w))
    }
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
    /// Root mean square of measured less simulated power on them, W: what the plant gets wrong
    /// without any effect.
    pub calibrated_w: f64,
    /// How far the plant's wheels were off the recorded speeds, as a share of these: the worst run.
    pub missed: f64,
    /// Effects added.
    pub effects: Vec<Acting>,
    /// Effects that could not be.
    pub not_simulated: Vec<Missing>,
    /// Root mean square of measured less simulated power on the locked runs without effects, W.
    pub before_w: f64,
    /// The same with them.
    pub after_w: f64,
    /// The part of it that nothing removes, W: the model's noise floor with what the plant gets
    /// wrong without any effect.
    pub floor_w: f64,
    /// Share of the gap that is closed; `None` without effects.
    pub closed: Option<f64>,
    /// Where measured and simulated power disagree without effects, on the locked runs.
    pub cells_before: Vec<Cell>,
    /// And with them.
    pub cells_after: Vec<Cell>,
    /// All runs, in the order of the command line.
    pub runs: Vec<Trace>,
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

    let behind = Behind::new(chassis, raw)?;
    let mut missed = 0.0_f64;
    let none = drive(&follower, chassis, raw, |_| Ok(Vec::new()), &mut missed)?;
    let before = behind.filtered(&none)?;
    let lightest_kg =
        raw.iter().flat_map(|run| &run.rows).map(|(_, _, mass, _)| *mass).fold(f64::INFINITY, f64::min);
    let (mut parts, mut not_simulated): (Vec<(Part, f64)>, Vec<Missing>) = Default::default();
    let stands = matches!(report.verdict, Verdict::Named | Verdict::Ambiguous);
    let locked_times = locked_times(&behind, report);
    let mut ids = Vec::new();
    for named in report.effects.iter().filter(|_| stands) {
        let own = named.candidate.regressors.iter().find_map(|regressor| match regressor {
            Regressor::Switch(what, _) => locked_times.iter().find(|(other, _)| other == what),
            _ => None,
        });
        let scene = Scene {
            open: &report.split.open,
            locked: &report.split.locked,
            runs: raw.len(),
            locked_times: own.map(|(_, times)| &times[..]),
            rolling: follower.machine.wheels[0].rolling_resistance,
            lightest_kg,
        };
        let finding =
            Finding { candidate: &named.candidate, coefficients: &named.coefficients, scene: &scene };
        match cause(&finding)? {
            Ok(part) => {
                ids.push(named.candidate.id.clone());
                parts.push((part, 0.0));
            }
            Err(reason) => not_simulated.push(Missing { id: named.candidate.id.clone(), reason }),
        }
    }
    find_sizes(&follower, chassis, raw, report, &mut parts)?;
    let acting = |run: usize| -> Result<Vec<_>> {
        Ok(parts.iter().map(|(part, size)| part.in_run(*size, run)).collect::<Result<Vec<_>>>()?.concat())
    };
    let after = if parts.is_empty() {
        before.clone()
    } else {
        behind.filtered(&drive(&follower, chassis, raw, acting, &mut missed)?)?
    };

    let locked = behind.measured.subset(&report.split.locked);
    let residual = |simulated: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let runs = locked.runs.iter().zip(&report.split.locked);
        runs.map(|(run, &place)| {
            run.rows.iter().zip(&simulated[place]).map(|(row, s)| row.power - s).collect()
        })
        .collect()
    };
    let (left_before, left_after) = (residual(&before), residual(&after));
    let mean = |left: &[Vec<f64>]| {
        left.iter().map(|run| squares(run)).sum::<f64>()
            / left.iter().map(Vec::len).sum::<usize>().max(1) as f64
    };
    let (before_w2, after_w2) = (mean(&left_before), mean(&left_after));
    // What the plant gets wrong on runs without effects is no effect's; of runs that may have one
    // it says nothing.
    let own_w2 = if clean.is_some() { calibrated_w.powi(2) } else { 0.0 };
    let floor_w2 = report.confirmed.floor_w.powi(2).max(own_w2).min(after_w2);
    let effects: Vec<Acting> = ids
        .into_iter()
        .zip(&parts)
        .map(|(id, (part, size))| {
            let unit = part.effects.first().map_or("", |effect| effect.entry().unit);
            Acting { id, size: *size, unit }
        })
        .collect();
    let to_close = before_w2 - floor_w2;
    let closed = (!effects.is_empty() && to_close > 0.0).then(|| (before_w2 - after_w2) / to_close);
    let traces = behind.measured.runs.iter().zip(before).zip(after).enumerate();
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
        cells_before: localise::cells(&locked, &left_before),
        cells_after: localise::cells(&locked, &left_after),
        runs: traces
            .map(|(place, ((run, before_w), after_w))| Trace {
                name: run.name.clone(),
                locked: report.split.locked.contains(&place),
                time_s: run.rows.iter().map(|row| row.time).collect(),
                measured_w: run.rows.iter().map(|row| row.power).collect(),
                before_w,
                after_w,
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
    parts: &mut [(Part, f64)],
) -> Result<()> {
    let places = &report.split.open;
    let open: Vec<RawRun> = places.iter().map(|&place| raw[place].clone()).collect();
    let behind = Behind::new(chassis, &open)?;
    let measured: Vec<f64> =
        behind.measured.runs.iter().flat_map(|run| &run.rows).map(|row| row.power).collect();
    let rounds = if parts.len() > 1 { 2 } else { 1 };
    for _ in 0..rounds {
        for own in 0..parts.len() {
            let power = |size: f64| -> Result<Vec<f64>> {
                let effects = |run: usize| -> Result<Vec<_>> {
                    let mut all = Vec::new();
                    for (place, (part, at)) in parts.iter().enumerate() {
                        all.extend(part.in_run(if place == own { size } else { *at }, places[run])?);
                    }
                    Ok(all)
                };
                let power = drive(follower, chassis, &open, effects, &mut 0.0)?;
                Ok(behind.filtered(&power)?.concat())
            };
            let without = power(0.0)?;
            let (size, _) = search::size(power, &measured, &without, parts[own].0.range)?;
            parts[own].1 = size;
        }
    }
    Ok(())
}

/// Times of steps in the locked runs, where they are the runs' own.
fn locked_times(behind: &Behind<'_>, report: &Report) -> Vec<(Switched, Arc<[f64]>)> {
    let locked = behind.measured.subset(&report.split.locked);
    let Some(basis) = &report.basis else { return Vec::new() };
    let twin = Twin { clean_delay: basis.lag, ..Twin::new(&locked, basis.drive) };
    let common =
        report.state.effects.iter().filter(|(regressor, _)| matches!(regressor, Regressor::Switch(..)));
    let switches: Vec<(Regressor, f64)> = common.cloned().collect();
    let timed = confirm::with_own_times(&twin, report.state.torque, switches);
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
    Ok(runs.iter().zip(&followed).map(|(run, followed)| followed.power(run, follower.lag_s)).collect())
}

/// Root mean square of measured less simulated power of runs without effects, W.
fn gap(chassis: &Chassis, follower: &Follower, runs: &[RawRun]) -> Result<f64> {
    let power = drive(follower, chassis, runs, |_| Ok(Vec::new()), &mut 0.0)?;
    let left = Behind::new(chassis, runs)?.residual(&power)?;
    Ok((squares(&left) / left.len().max(1) as f64).sqrt())
}

/// Works on runs on two threads.
fn in_parallel<T: Send>(
    runs: &[RawRun],
    work: impl Fn(usize, &RawRun) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let half = runs.len() / 2;
    let (left, right) = runs.split_at(half);
    let work = &work;
    thread::scope(|scope| {
        let other = scope.spawn(move || (0..).zip(left).map(|(k, run)| work(k, run)).collect::<Vec<_>>());
        let own: Vec<_> = (half..).zip(right).map(|(k, run)| work(k, run)).collect();
        other.join().unwrap_or_else(|panic| resume_unwind(panic)).into_iter().chain(own).collect()
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
                let (before, after) = run.gap_w();
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
        let courses = self.runs.iter().map(|run| Course {
            name: run.name.clone(),
            locked: run.locked,
            time_s: run.time_s.clone(),
            measured_w: run.measured_w.clone(),
            before_w: run.before_w.clone(),
            after_w: (!self.effects.is_empty()).then(|| run.after_w.clone()),
        });
        let after = self.cells_after.iter().map(Some).chain(std::iter::repeat(None));
        let cells = self.cells_before.iter().zip(after).map(|(before, after)| Cell {
            mean_after_w: after.map(|after| after.mean_residual_w),
            band_after_w: after.map(|after| after.band_w),
            ..before.clone()
        });
        page::Simulated { text: vec![self.line()], courses: courses.collect(), cells: cells.collect() }
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
