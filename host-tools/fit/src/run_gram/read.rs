//! From a log to the sums of its runs, in one pass and in bounded memory.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use crc::{CRC_32_ISO_HDLC, Crc};
use logs::robot::Robot;
use logs::{Header, MIN_GAP_FACTOR, RawRow, SampleReader, conditioner};
use model::coefficients::{CoefficientsFile, Taking};
use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::{self, Gate};
use model_core::gyro::GyroConditioner;
use model_core::model::Model;
use model_core::torque::Drive;
use serde::Serialize;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};

use super::local::{Local, Reference};
use super::polynomial;
use super::run::{FORMAT, RunGram, Setting};
use super::summary::{Moment, Summary};
use crate::dataset::{Row, condition};
use crate::gram::Gram;

/// How logs are read.
#[derive(Debug, Clone)]
pub(super) struct Conditioned<const N: usize> {
    /// Filter, delay and slip memory.
    pub core: CoreRobot<f64, N>,
    /// Whether the drives clamp.
    pub drive: Drive,
    /// Coefficients with their checksum, that the sums of the signed model are taken near.
    pub reference: Option<(Reference, String)>,
    /// Total mass of logs that do not tell it, kg.
    pub mass_kg: f64,
}

impl<const N: usize> Conditioned<N> {
    /// As the coefficients of this file were fitted, and near them.
    ///
    /// # Errors
    /// They cannot be read, are of another robot or of another model than the signed one, or hold
    /// effects.
    pub(super) fn near(robot: &Robot, file: &Path, mass_kg: f64) -> Result<Self> {
        let text = read_text(file, MOST_DESCRIPTION)?;
        let read = CoefficientsFile::<N>::parse(&text, file, robot, Taking::default())?.coefficients;
        let Model::Signed { torque, drive } = read.model else {
            return Err(Error::failed("model eq18; expected signed").in_file(file).in_column("model"));
        };
        if read.columns.iter().next().is_some() {
            let message = "they hold effects; expected the coefficients as gmr fit wrote them";
            return Err(Error::failed(message).in_file(file).in_column("effects"));
        }
        Ok(Self {
            core: read.robot,
            drive,
            reference: Some((Reference { torque, drive }, checksum_of(&text))),
            mass_kg,
        })
    }

    fn setting(&self, robot: &Robot) -> Setting {
        let conditioning = &self.core.conditioning;
        Setting {
            robot: robot.name().to_owned(),
            wheels: N,
            static_power_w: robot.static_power_w().unwrap_or(0.0),
            filter_cutoff_hz: self.core.cutoff_hz,
            power_delay_s: conditioning.delay,
            slip: [conditioning.slip.half_slip, conditioning.slip.relaxation],
            reference: self.reference.as_ref().map(|(_, checksum)| checksum.clone()),
        }
    }
}

/// By what sums know the coefficients that they were taken near.
pub(super) fn checksum_of(coefficients: &str) -> String {
    format!("{:08x}", Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(coefficients.as_bytes()))
}

/// What commands are called in logs.
const COMMAND: &str = "cmd_v_m_s";

/// Periods of the cutoff that the filter takes to forget, as after a start.
const SETTLES: f64 = 2.0;

/// Rows that are summed at a time.
const BLOCK: usize = 1024;

/// Where the time went, s of one thread each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spent {
    /// Bytes to numbers.
    pub reading_s: f64,
    /// Filter, kinematics, and what a run was.
    pub filter_s: f64,
    /// Products and their sums.
    pub sums_s: f64,
}

impl Spent {
    /// Adds another's.
    pub fn add(&mut self, other: &Self) {
        self.reading_s += other.reading_s;
        self.filter_s += other.filter_s;
        self.sums_s += other.sums_s;
    }
}

/// What became of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Summed {
    /// The sums of its runs, in the order in which they begin.
    pub runs: Vec<RunGram>,
    /// What that took.
    pub spent: Spent,
}

/// Rows in the making.
struct Work<'a, const N: usize> {
    robot: &'a Robot,
    how: &'a Conditioned<N>,
    is_commanded: bool,
    most_elapsed_s: f64,
    runs: Vec<RunGram>,
    /// When the filter has forgotten the last row of a run in which a wheel could be clamped.
    free_from: BTreeMap<u32, f64>,
    spent: Spent,
}

/// The sums of the runs of a log that is open.
///
/// # Errors
/// A log that is not one of this robot or is too slow for the filter.
pub(super) fn of_header<const N: usize>(
    robot: &Robot,
    how: &Conditioned<N>,
    header: Header,
) -> Result<Summed> {
    let file = header.path().to_owned();
    let is_commanded = header.has(COMMAND);
    let further: &[&str] = if is_commanded { &[COMMAND] } else { &[] };
    let mut reader = SampleReader::<N>::of(header, robot, further)?;
    let mut conditioner = conditioner(&how.core, &file, reader.period_s())?;
    let mut work = Work {
        robot,
        how,
        is_commanded,
        most_elapsed_s: MIN_GAP_FACTOR * reader.period_s(),
        runs: Vec::new(),
        free_from: BTreeMap::new(),
        spent: Spent::default(),
    };
    let mut raw: Vec<(RawRow<N>, f64)> = Vec::with_capacity(BLOCK);
    let mut rows: Vec<Row<N>> = Vec::with_capacity(BLOCK);
    loop {
        let started = Instant::now();
        raw.clear();
        while raw.len() < BLOCK
            && let Some(row) = reader.next_row()?
        {
            raw.push((row, reader.extras().first().copied().unwrap_or(f64::NAN)));
        }
        work.spent.reading_s += started.elapsed().as_secs_f64();
        if raw.is_empty() {
            break;
        }
        work.filter(&raw, &mut conditioner, &mut rows);
        work.sum(&rows);
    }
    let Work { mut runs, spent, .. } = work;
    let (names, exclusions) = (reader.run_names(), reader.exclusions());
    let several = runs.len() > 1;
    for (place, run) in runs.iter_mut().enumerate() {
        run.run = file.display().to_string();
        if several {
            run.run += &format!("#{}", names.get(place).map_or("", String::as_str));
        }
    }
    let Some(first) = runs.first_mut() else { return Err(Error::failed("no row to use").in_file(file)) };
    // They belong to the log; its first run tells of them.
    first.summary.exclusions = exclusions;
    Ok(Summed { runs, spent })
}

impl<const N: usize> Work<'_, N> {
    /// What rows were, and what of them comes out of the filter.
    fn filter(
        &mut self,
        raw: &[(RawRow<N>, f64)],
        conditioner: &mut GyroConditioner<f64, N>,
        rows: &mut Vec<Row<N>>,
    ) {
        let started = Instant::now();
        rows.clear();
        for (raw, command_m_s) in raw {
            let place = raw.run as usize;
            while self.runs.len() <= place {
                self.runs.push(empty(self.how, self.robot, self.is_commanded));
            }
            let speeds = raw.sample.wheel_speed;
            let twist = self.how.core.kinematics.twist(&speeds);
            let fastest = speeds.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
            let now = Moment {
                time_s: raw.time,
                elapsed_s: raw.elapsed,
                speed_m_s: twist.vx,
                turn_rad_s: twist.omega,
                fastest_rad_s: fastest,
                moves: fastest > self.how.core.dead_band,
                power_w: raw.sample.power,
                mass_kg: raw.mass.unwrap_or(self.how.mass_kg),
                command_m_s: *command_m_s,
            };
            self.runs[place].summary.add(&now, self.most_elapsed_s);
            rows.extend(condition(conditioner, raw, self.how.mass_kg));
        }
        self.spent.filter_s += started.elapsed().as_secs_f64();
    }

    fn sum(&mut self, rows: &[Row<N>]) {
        let started = Instant::now();
        add(&mut self.runs, rows, self.how, &mut self.free_from);
        self.spent.sums_s += started.elapsed().as_secs_f64();
    }
}

fn empty<const N: usize>(how: &Conditioned<N>, robot: &Robot, is_commanded: bool) -> RunGram {
    // A robot that does not say how fast it is: bins of 0.1 m/s, and of 0.25 rad/s.
    let limits = robot.limits();
    RunGram {
        format: FORMAT,
        run: String::new(),
        keys: BTreeMap::new(),
        setting: how.setting(robot),
        summary: Summary::new(
            limits.speed_m_s.unwrap_or(2.3),
            limits.turn_rad_s.unwrap_or(5.75),
            is_commanded,
        ),
        eq18: Gram::default(),
        eq18_published: Gram::default(),
        signed: Gram::default(),
        may_clamp: 0,
        local: how.reference.is_some().then(Local::default),
    }
}

/// Adds rows to the sums of their runs.
fn add<const N: usize>(
    runs: &mut [RunGram],
    rows: &[Row<N>],
    how: &Conditioned<N>,
    free_from: &mut BTreeMap<u32, f64>,
) {
    let memory = SETTLES / how.core.cutoff_hz;
    for rows in rows.chunk_by(|a, b| a.run == b.run) {
        let Some(run) = runs.get_mut(rows[0].run as usize) else { continue };
        let of = |gate: Gate, row: &Row<N>| {
            (eq18::regressors(gate, &eq18::products(gate, &row.motion), row.mass), row.power)
        };
        run.eq18.extend(rows.iter().map(|row| of(Gate::Corrected, row)));
        run.eq18_published.extend(rows.iter().map(|row| of(Gate::Published, row)));
        let before = run.signed.rows();
        let free = free_from.entry(rows[0].run).or_insert(f64::NEG_INFINITY);
        run.signed.extend(rows.iter().filter_map(|row| {
            if !polynomial::cannot_clamp(&row.motion, how.drive) {
                *free = row.time + memory;
            }
            (row.time >= *free).then(|| (polynomial::regressors(&row.motion, row.mass), row.power))
        }));
        run.may_clamp += rows.len() as u64 - (run.signed.rows() - before);
        if let (Some(local), Some((reference, _))) = (&mut run.local, &how.reference) {
            rows.iter().for_each(|row| local.add(row, reference));
        }
    }
}
