//! The one pass over a log that feeds everything else.

use std::path::Path;

use logs::robot::Robot;
use logs::standing::{Standings, Stuck};
use logs::suspicion::{Look, Suspicion};
use logs::{
    ColumnRequest, Exclusions, Header, LogReader, MASS, POWER, RUN, Role, TIME, acceleration_column,
    check_wheels, speed_column,
};
use support::context::Context;
use support::error::Result;

use super::blocks::{Block, Blocks};
use super::excitation::{Excitation, Watch};
use super::sensors::{Outliers, Spikes};
use super::timing::{Steps, Timing};

/// After a stop, power has settled this much later, s.
const SETTLING_S: f64 = 1.0;

/// A jump of speed from row to row by less than this share of the usual speed is a step of
/// quantisation, say, but no outlier of acceleration.
const SPEED_STEP: f64 = 0.02;

/// Rows between two reports of progress.
const PROGRESS_ROWS: u64 = 1 << 16;

/// What one pass finds.
pub(super) struct Scan {
    pub(super) rows: u64,
    pub(super) duration_s: f64,
    pub(super) period_s: f64,
    pub(super) timing: Timing,
    pub(super) exclusions: Exclusions,
    pub(super) outliers: Vec<Outliers>,
    pub(super) stuck: Vec<Stuck>,
    pub(super) excitation: Option<Excitation>,
    pub(super) blocks: Vec<Block>,
    pub(super) has_mass: bool,
    pub(super) suspicions: Vec<Suspicion>,
    pub(super) other_columns: Vec<String>,
}

const TIME_SLOT: usize = 0;
const POWER_SLOT: usize = 1;
const MASS_SLOT: usize = 2;
const RUN_SLOT: usize = 3;
const SPEED_SLOT: usize = 4;

/// The columns of a log: with wheels if it has any, which are then the robot's.
fn open(context: &Context, path: &Path, robot: &Robot) -> Result<(LogReader, usize, bool)> {
    let header = Header::open(context, path)?;
    let mut requests = vec![
        ColumnRequest::required(TIME, Role::Time),
        ColumnRequest::required(POWER, Role::Number),
        ColumnRequest::optional(MASS, Role::MaybeNumber),
        ColumnRequest::optional(RUN, Role::Run),
    ];
    let any_wheel = header.columns().iter().any(|column| column.starts_with("wheel"));
    let wheels = if any_wheel { robot.wheels() } else { 0 };
    if any_wheel {
        check_wheels(&header, robot)?;
        requests.extend((0..wheels).map(|wheel| ColumnRequest::required(speed_column(wheel), Role::Number)));
    }
    let accelerations = wheels > 0 && (0..wheels).any(|wheel| header.has(&acceleration_column(wheel)));
    if accelerations {
        requests.extend(
            (0..wheels).map(|wheel| ColumnRequest::required(acceleration_column(wheel), Role::Number)),
        );
    }
    let mut scales = vec![1.0; requests.len()];
    scales[POWER_SLOT] = robot.log_units().power_in_w();
    scales[MASS_SLOT] = robot.log_units().mass.in_kg();
    for (place, scale) in scales[SPEED_SLOT..].iter_mut().enumerate() {
        *scale = robot.log_speed_scale(place % wheels.max(1));
    }
    Ok((header.read(&requests)?.scaled(scales), wheels, accelerations))
}

pub(super) fn scan(
    context: &Context,
    path: &Path,
    robot: &Robot,
    progress: &mut dyn FnMut(u64, Option<u64>),
) -> Result<Scan> {
    let (mut reader, wheels, accelerations) = open(context, path, robot)?;
    let weighed = robot.log_units().mass_of(path);
    let mut values = vec![0.0; SPEED_SLOT + wheels * if accelerations { 2 } else { 1 }];
    let mut before = values.clone();
    let mut steps = Steps::default();
    let mut power_spikes = Spikes::new(POWER.to_owned());
    let mut wheel_spikes: Vec<Spikes> =
        (1..=wheels).map(|wheel| Spikes::new(format!("acceleration of wheel {wheel}"))).collect();
    let mut standings = Standings::new(robot, wheels);
    let mut watch = (wheels > 0).then(|| Watch::new(robot));
    let mut look = (wheels > 0).then(|| Look::new(robot));
    let static_power = robot.static_power_w().unwrap_or(0.0);
    let mut blocks = Blocks::new();
    let mut last_moving = f64::NEG_INFINITY;
    let mut duration_s = 0.0;
    let mut started = false;

    while let Some(line) = reader.next_row(&mut values)? {
        if let Some(mass) = weighed {
            values[MASS_SLOT] = mass;
        }
        let (time_s, power_w) = (values[TIME_SLOT], values[POWER_SLOT]);
        let run_before = before[RUN_SLOT].to_bits();
        let new_run = !started || (reader.has(RUN_SLOT) && values[RUN_SLOT].to_bits() != run_before);
        let step = time_s - before[TIME_SLOT];
        let gap = !new_run && steps.add(line, before[TIME_SLOT], time_s);
        if !new_run {
            duration_s += step;
        }
        let fresh = new_run || gap;
        if fresh {
            power_spikes.restart();
            wheel_spikes.iter_mut().for_each(Spikes::restart);
            if let Some(watch) = &mut watch {
                watch.restart();
            }
            blocks.restart();
            last_moving = f64::NEG_INFINITY;
        }

        let speeds = &values[SPEED_SLOT..SPEED_SLOT + wheels];
        power_spikes.add(line, power_w);
        for (wheel, spikes) in wheel_spikes.iter_mut().enumerate() {
            let slot = SPEED_SLOT + wheel;
            if accelerations {
                spikes.add(line, values[slot + wheels]);
            } else if !fresh {
                spikes.add(line, (values[slot] - before[slot]) / step);
            }
        }
        standings.add(line, time_s, fresh, speeds, power_w);
        if let Some(watch) = &mut watch {
            watch.add(time_s, speeds, power_w, values[MASS_SLOT]);
        }
        if let Some(look) = &mut look {
            look.add(time_s, fresh, speeds, power_w - static_power, values[MASS_SLOT]);
        }
        if speeds.iter().any(|speed| speed.abs() > robot.speed_dead_band_rad_s()) {
            last_moving = time_s;
        }
        blocks.add(time_s, power_w, wheels == 0 || time_s - last_moving > SETTLING_S);

        before.copy_from_slice(&values);
        started = true;
        if reader.rows() % PROGRESS_ROWS == 0 {
            let (read, size) = reader.progress();
            progress(read, size);
        }
    }

    let known = |column: &String| {
        let wheel = |name: fn(usize) -> String| (0..wheels).any(|wheel| *column == name(wheel));
        [TIME, POWER, MASS, RUN].contains(&column.as_str())
            || wheel(speed_column)
            || wheel(acceleration_column)
    };
    let (period_s, timing) = steps.finish();
    let excitation = watch.map(Watch::finish);
    let usual_speed = excitation.as_ref().map_or(0.0, |drive| drive.speed_quantiles_rad_s[2]);
    let speed_step = SPEED_STEP * usual_speed;
    Ok(Scan {
        rows: reader.rows(),
        duration_s,
        period_s,
        timing,
        exclusions: reader.exclusions(),
        outliers: std::iter::once(power_spikes.finish(0.0))
            .chain(wheel_spikes.into_iter().map(|spikes| spikes.finish(speed_step / period_s)))
            .collect(),
        stuck: standings.finish(),
        excitation,
        blocks: blocks.finish(),
        has_mass: weighed.is_some() || reader.has(MASS_SLOT),
        suspicions: look.map_or_else(Vec::new, Look::finish),
        other_columns: reader.columns().iter().filter(|column| !known(column)).cloned().collect(),
    })
}
