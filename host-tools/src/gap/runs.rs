//! Runs in memory: conditioned as the board does it, thinned to some twenty rows a second, with every further column.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use model_core::coefficients::Robot as CoreRobot;
use model_core::effects::{Course, Layout};
use model_core::estimator::{Conditioner, Sample};
use model_core::filter::{Channel, LowPass};
use model_core::motion::Motion;

use super::edges::{Motions, Step};
use super::input;
use crate::error::{Error, Result};
use crate::fit::dataset::conditioner;
use crate::log::{DriveReader, Header, MASS, POWER, RUN, TIME, acceleration_column, speed_column};
use crate::robot::Robot;

/// Rows a second that are kept, at most about.
const ROWS_PER_S: f64 = 20.0;

/// Rows that are kept per period of the filter's cutoff, at least about: more of them repeat each other, and the band above
/// the cutoff holds nothing but what the model of filtered signals gets wrong.
const ROWS_PER_CUTOFF: f64 = 3.0;

/// Rows a second that are kept at least, where the log has them: interpolating a delay needs them.
const LEAST_ROWS_PER_S: f64 = 8.0;

/// Sample periods of two runs that differ by more than this share are different.
const SAME_PERIOD: f64 = 0.1;

/// One row behind the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<const N: usize> {
    /// The wheels.
    pub motion: Motion<f64, N>,
    /// Actuation power, W.
    pub power: f64,
    /// Total mass as the log tells it, kg.
    pub mass: f64,
    /// Time since the start of the run, s.
    pub time: f64,
    /// Turn rate, rad/s.
    pub turn_rate: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Cosine and sine of the heading since the start of the run.
    pub heading: [f64; 2],
    /// How long the robot has not moved, s: 0 while it moves, infinite before it first does.
    pub still: f64,
    /// Does not continue the row before: the first of the run, or behind a gap.
    pub starts: bool,
}

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run<const N: usize> {
    /// Its log, and its name there where the log holds several.
    pub name: String,
    /// Its rows.
    pub rows: Vec<Row<N>>,
    /// Further columns behind the filter, in the order of [`Runs::columns`]; empty where this run lacks one.
    pub extras: Vec<Vec<f64>>,
    /// When the robot moved.
    pub motions: Motions,
    /// One of those that the base was fitted to: without any effect.
    pub clean: bool,
}

/// All runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Runs<const N: usize> {
    /// The robot, with the filter's cutoff.
    pub robot: CoreRobot<f64, N>,
    /// Where its wheels are.
    pub layout: Layout<f64, N>,
    /// Names of further columns.
    pub columns: Vec<String>,
    /// The runs.
    pub runs: Vec<Run<N>>,
    /// Time between rows, s.
    pub period_s: f64,
    /// How the filter shows what is switched.
    pub step: Step,
}

/// A run as recorded.
#[derive(Debug, Clone, Default)]
pub struct RawRun<const N: usize> {
    /// Its name.
    pub name: String,
    /// Time, sample, mass and further columns of each row.
    pub rows: Vec<(f64, Sample<f64, N>, f64, Vec<f64>)>,
    /// Names of the further columns.
    pub columns: Vec<String>,
    /// Median sample period, s.
    pub period_s: f64,
}

impl<const N: usize> Runs<N> {
    /// Reads the logs of a robot; each value of a `run` column is a run.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot; runs of different sample rates; a run too short for the filter.
    pub fn read(robot: &Robot, core: &CoreRobot<f64, N>, files: &[PathBuf], mass_kg: f64) -> Result<Self> {
        Self::read_with(robot, core, files, mass_kg, &[])
    }

    /// As [`read`](Self::read), with further columns that are powers (`…_w`), where a log has them.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_with(
        robot: &Robot,
        core: &CoreRobot<f64, N>,
        files: &[PathBuf],
        mass_kg: f64,
        powers: &[String],
    ) -> Result<Self> {
        Self::condition(core, Self::raw(robot, files, mass_kg, powers)?)
    }

    /// The logs as recorded, before any filter.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot.
    pub fn raw(robot: &Robot, files: &[PathBuf], mass_kg: f64, powers: &[String]) -> Result<Vec<RawRun<N>>> {
        let mut raw = Vec::new();
        for file in files {
            raw.extend(read_log::<N>(robot, file, mass_kg, powers)?);
        }
        Ok(raw)
    }

    /// Conditions runs as recorded.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn condition(core: &CoreRobot<f64, N>, raw: Vec<RawRun<N>>) -> Result<Self> {
        let mut columns: Vec<String> = Vec::new();
        for name in raw.iter().flat_map(|run| &run.columns) {
            if !columns.contains(name) {
                columns.push(name.clone());
            }
        }
        let Some(first) = raw.first() else { return Err(Error::usage("no log was given")) };
        let (first_name, period) = (first.name.clone(), first.period_s);
        let rate = (ROWS_PER_CUTOFF * core.cutoff_hz).clamp(LEAST_ROWS_PER_S, ROWS_PER_S);
        let stride = (1.0 / (period * rate)).round().max(1.0);
        let mut runs = Vec::new();
        for run in raw {
            if (run.period_s / period - 1.0).abs() > SAME_PERIOD {
                return Err(Error::failed(format!(
                    "sampled at {:.2} Hz, but {first_name} at {:.2} Hz; expected runs of one sample rate",
                    1.0 / run.period_s,
                    1.0 / period
                ))
                .in_file(&run.name));
            }
            runs.push(condition_run(core, run, &columns, stride as usize)?);
        }
        Ok(Self {
            robot: *core,
            layout: Layout::new(&core.kinematics),
            columns,
            runs,
            period_s: period * stride,
            step: Step::new(&filter(core, period, &first_name)?, period),
        })
    }

    /// The runs at these places.
    #[must_use]
    pub fn subset(&self, places: &[usize]) -> Self {
        let runs = places.iter().map(|&place| self.runs[place].clone()).collect();
        Self {
            robot: self.robot,
            layout: self.layout,
            columns: self.columns.clone(),
            runs,
            period_s: self.period_s,
            step: self.step.clone(),
        }
    }

    /// These runs, and behind them the clean ones of the base.
    #[must_use]
    pub fn with_clean(&self, clean: Option<&Self>) -> Self {
        let mut all = self.clone();
        for run in clean.iter().flat_map(|clean| &clean.runs) {
            let extras = self.columns.iter().map(|name| {
                let place = clean.and_then(|clean| clean.columns.iter().position(|own| own == name));
                place.map_or_else(Vec::new, |place| run.extras[place].clone())
            });
            all.runs.push(Run { clean: true, extras: extras.collect(), ..run.clone() });
        }
        all
    }

    /// Place of a further column that every run has.
    pub fn column(&self, name: &str) -> Option<usize> {
        let place = self.columns.iter().position(|column| column == name)?;
        self.runs.iter().all(|run| !run.extras[place].is_empty()).then_some(place)
    }
}

fn filter<const N: usize>(core: &CoreRobot<f64, N>, period_s: f64, run: &str) -> Result<LowPass<f64>> {
    LowPass::new(core.cutoff_hz, period_s).map_err(|_| Error::failed("too slow for the filter").in_file(run))
}

/// Where samples before the filter move this often while those behind it stand, they are noise.
const RESTLESS: f64 = 0.1;

fn condition_run<const N: usize>(
    core: &CoreRobot<f64, N>,
    run: RawRun<N>,
    columns: &[String],
    stride: usize,
) -> Result<Run<N>> {
    let mut conditioner: Conditioner<f64, N> = conditioner(core, Path::new(&run.name), run.period_s)?;
    let filter = filter(core, run.period_s, &run.name)?;
    let places: Vec<Option<usize>> =
        columns.iter().map(|name| run.columns.iter().position(|own| own == name)).collect();
    let mut channels = vec![Channel::default(); columns.len()];
    let mut held = vec![f64::NAN; columns.len()];
    let mut extras: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    let mut rows = Vec::new();
    let (mut course, mut starts) = (Course::default(), true);
    let mut last = f64::NEG_INFINITY;
    let mut since = 0_usize;
    // Whether a wheel moves, before and behind the filter.
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
        let Some(now) = conditioner.push(sample, elapsed) else { continue };
        let raw = sample.wheel_speed.iter().any(|speed| speed.abs() > core.dead_band);
        moves.push((course.time(), raw, now.motion.is_moving()));
        let speeds = now.motion.wheels.map(|wheel| wheel.speed);
        let twist = core.kinematics.twist(&speeds);
        course.see(twist.omega, now.motion.is_moving());
        if !now.settled {
            starts = true;
            since = 0;
            continue;
        }
        if since.is_multiple_of(stride) {
            rows.push(Row {
                motion: now.motion,
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
            core.cutoff_hz,
            2.0 / core.cutoff_hz
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
    Ok(Run { name: run.name, rows, extras, motions, clean: false })
}

/// Reads a log whole: its runs as recorded, static power taken off.
fn read_log<const N: usize>(
    robot: &Robot,
    file: &Path,
    mass_kg: f64,
    powers: &[String],
) -> Result<Vec<RawRun<N>>> {
    let columns = further_columns::<N>(file, powers)?;
    let names: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut reader = DriveReader::<N>::open_with(file, robot, &names)?;
    let static_power = robot.static_power_w().unwrap_or(0.0);
    let mut runs: Vec<RawRun<N>> = Vec::new();
    while let Some(record) = reader.next_record()? {
        if let Some(mass) = record.mass_kg {
            input::check_mass(robot, mass).map_err(|error| error.in_file(file).at_line(record.line))?;
        }
        while runs.len() <= record.run {
            runs.push(RawRun { columns: columns.clone(), period_s: reader.period_s(), ..RawRun::default() });
        }
        let sample = Sample {
            wheel_speed: record.wheel_speed,
            wheel_acceleration: record.wheel_acceleration,
            power: record.power_w - static_power,
        };
        let mass = record.mass_kg.unwrap_or(mass_kg);
        runs[record.run].rows.push((record.time_s, sample, mass, reader.extras().to_vec()));
    }
    let excluded = reader.exclusions();
    if excluded.total() > 0 {
        eprintln!("gmr: {}: {excluded}", file.display());
    }
    let several = runs.len() > 1;
    for (run, name) in runs.iter_mut().zip(0..) {
        let label = reader.run_names().get(name).cloned().unwrap_or_else(|| name.to_string());
        run.name = file.display().to_string();
        if several {
            run.name += &format!("#{label}");
        }
    }
    runs.retain(|run| !run.rows.is_empty());
    Ok(runs)
}

/// Columns of what a board estimated while it was recorded.
const BOARD: &str = "board_";

/// Columns beyond those of a drive that hold numbers. Powers (`…_w`) are left out, but for those asked for: they are what is to be
/// explained; and what a board made of them, its mass above all: a gap moves it.
fn further_columns<const N: usize>(file: &Path, powers: &[String]) -> Result<Vec<String>> {
    let header = Header::open(file)?;
    let known = |name: &str| {
        [TIME, POWER, MASS, RUN, ""].contains(&name)
            || (name.ends_with("_w") && !powers.iter().any(|power| power == name))
            || name.starts_with(BOARD)
            || (0..N).any(|wheel| name == speed_column(wheel) || name == acceleration_column(wheel))
    };
    let text = File::open(file).map_err(|error| Error::io(file, &error))?;
    let row = BufReader::new(text).lines().nth(1).and_then(std::result::Result::ok).unwrap_or_default();
    let numbers: Vec<bool> =
        row.split(',').map(|field| field.trim().is_empty() || field.trim().parse::<f64>().is_ok()).collect();
    let columns = header.columns().iter().enumerate();
    let wanted =
        columns.filter(|(place, name)| !known(name) && numbers.get(*place).copied().unwrap_or(false));
    Ok(wanted.map(|(_, name)| name.clone()).collect())
}
