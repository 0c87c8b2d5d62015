//! A run after the filter, as the board conditions it, thinned to some twenty rows a second.

use std::collections::HashMap;
use std::path::Path;

use model_core::effects::Course;
use model_core::filter::{Channel, LowPass};
use support::error::{Error, Result};

use super::YAW_RATE;
use super::conditioner::Conditioner;
use super::motions::Motions;
use super::raw::RawRun;
use super::robot::chassis::{Chassis, Together as _};
use super::row::{Row, Run};
use super::shared::Shared;

/// A filter of a robot's logs, stepped every `period_s`.
///
/// # Errors
/// The run is too slow for it.
pub(super) fn filter(cutoff_hz: f64, period_s: f64, run: &str) -> Result<LowPass<f64>> {
    LowPass::new(cutoff_hz, period_s).map_err(|_| Error::failed("too slow for the filter").in_file(run))
}

/// What is said of a log without a gyro where coefficients hold true slip.
pub const NO_GYRO: &str = "no such column; expected one, for the coefficients hold true slip, which a gyro tells (gmr fit --no-gyro does without)";

/// Where samples before the filter move this often while those behind it stand, they are noise.
const RESTLESS: f64 = 0.1;

/// One run; of every `stride` rows one is kept.
///
/// # Errors
/// It is too slow, or too short, for the filter.
pub(super) fn condition(robot: &Chassis, run: RawRun, columns: &[String], stride: usize) -> Result<Run> {
    let mut conditioner = Conditioner::of_log(robot, Path::new(&run.name), run.period_s)?;
    let filter = filter(robot.cutoff_hz(), run.period_s, &run.name)?;
    let yaw_rate = run.columns.iter().position(|name| name == YAW_RATE);
    if robot.conditioning().true_slip != 0.0 && yaw_rate.is_none() {
        return Err(Error::failed(NO_GYRO).in_file(&run.name).in_column(YAW_RATE));
    }
    let of_run: HashMap<&str, usize> = run.columns.iter().map(String::as_str).zip(0..).collect();
    let places: Vec<Option<usize>> = columns.iter().map(|name| of_run.get(name.as_str()).copied()).collect();
    let mut channels = vec![Channel::default(); columns.len()];
    let mut held = vec![f64::NAN; columns.len()];
    let mut extras: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    let mut rows = Vec::new();
    let (mut course, mut starts) = (Course::default(), true);
    let mut last = f64::NEG_INFINITY;
    let mut since = 0_usize;
    // Whether a wheel moves, before and after the filter.
    let mut moves: Vec<(f64, bool, bool)> = Vec::new();
    for (time, sample, mass, further) in &run.rows {
        let elapsed = time - last;
        last = *time;
        course.pass(elapsed);
        for (((place, channel), held), _) in places.iter().zip(&mut channels).zip(&mut held).zip(columns) {
            let Some(value) = place.map(|place| further[place]) else { continue };
            if value.is_finite() {
                if held.is_nan() {
                    filter.settle(channel, value);
                }
                *held = filter.step(channel, value).value;
            }
        }
        let turn_rate = yaw_rate.map_or(f64::NAN, |place| further[place]);
        let Some(now) = conditioner.push_sample(sample, turn_rate, elapsed) else { continue };
        let raw = sample.wheel_speed.iter().any(|speed| speed.abs() > robot.dead_band());
        moves.push((course.time(), raw, now.wheels.is_moving()));
        let twist = robot.twist(now.wheels.iter().map(|wheel| wheel.speed));
        course.see(twist.omega, now.wheels.is_moving());
        if !now.settled {
            starts = true;
            since = 0;
            continue;
        }
        if since.is_multiple_of(stride) {
            rows.push(Row {
                wheels: now.wheels,
                power: now.power,
                mass: *mass,
                time: course.time(),
                turn_rate: twist.omega,
                speed: twist.vx,
                heading: course.heading(),
                still: course.still(),
                starts,
            });
            starts = false;
            for ((column, held), place) in extras.iter_mut().zip(&held).zip(&places) {
                if place.is_some() {
                    column.push(if held.is_finite() { *held } else { 0.0 });
                }
            }
        }
        since += 1;
    }
    if rows.is_empty() {
        return Err(Error::failed(format!(
            "no usable row: the filter (cutoff {} Hz) needs {:.1} s to settle after each start and gap; expected a longer run",
            robot.cutoff_hz(),
            2.0 / robot.cutoff_hz()
        ))
        .in_file(&run.name));
    }
    // A column in which nothing was ever measured is none.
    for (column, held) in extras.iter_mut().zip(&held) {
        if held.is_nan() {
            column.clear();
        }
    }
    let standing = moves.iter().filter(|(_, _, behind)| !behind).count() as f64;
    let restless = moves.iter().filter(|(_, before, behind)| *before && !behind).count() as f64;
    let by_raw = restless <= RESTLESS * standing;
    let motions = Motions::new(
        moves.iter().map(|&(time, before, behind)| (time, if by_raw { before } else { behind })),
    );
    let extras = extras.into_iter().map(Shared::from).collect();
    Ok(Run { name: run.name, rows: rows.into(), extras, motions: motions.into(), clean: false })
}
