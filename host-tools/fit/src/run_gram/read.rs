//! From a log to the sums of its runs, in one pass and in bounded memory.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use crc::{CRC_32_ISO_HDLC, Crc};
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::{Conditioner, Header, MIN_GAP_FACTOR, RawRow, SampleReader};
use model::coefficients::{CoefficientsFile, Taking};
use model_core::eq18::{self, Gate};
use model_core::model::Model;
use model_core::torque::Drive;
use serde::Serialize;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};

use super::local::{Local, Reference};
use super::polynomial;
use super::run::{FORMAT, RunGram, Setting};
use super::summary::{Moment, Summary};
use crate::dataset::{Kept, Rows, Stretch, condition};
use crate::gram::Gram;

/// How logs are read.
#[derive(Debug, Clone)]
pub(super) struct Conditioned {
    /// Filter, delay and slip memory.
    pub core: Chassis,
    /// Whether the drives clamp.
    pub drive: Drive,
    /// Coefficients with their checksum, that the sums of the signed model are taken near.
    pub reference: Option<(Reference, String)>,
    /// Total mass of logs that do not tell it, kg.
    pub mass_kg: f64,
}

impl Conditioned {
    /// As the coefficients of this file were fitted, and near them.
    ///
    /// # Errors
    /// They cannot be read, are of another robot or of another model than the signed one, or hold
    /// effects.
    pub(super) fn near(robot: &Robot, file: &Path, mass_kg: f64) -> Result<Self> {
        let text = read_text(file, MOST_DESCRIPTION)?;
        let (core, reference) = signed(robot, file, &text)?;
        let drive = reference.drive;
        Ok(Self { core, drive, reference: Some((reference, checksum_of(&text))), mass_kg })
    }

    fn setting(&self, robot: &Robot) -> Setting {
        let conditioning = self.core.conditioning();
        Setting {
            robot: robot.name().to_owned(),
            wheels: self.core.wheels(),
            static_power_w: robot.static_power_w().unwrap_or(0.0),
            filter_cutoff_hz: self.core.cutoff_hz(),
            power_delay_s: conditioning.delay,
            slip: [conditioning.slip.half_slip, conditioning.slip.relaxation],
            reference: self.reference.as_ref().map(|(_, checksum)| checksum.clone()),
        }
    }
}

/// The signed model of a file without effects, and its robot.
fn signed(robot: &Robot, file: &Path, text: &str) -> Result<(Chassis, Reference)> {
    let read = CoefficientsFile::parse(text, file, robot, Taking::default())?.coefficients;
    let Model::Signed { torque, drive } = read.model else {
        return Err(Error::failed("model eq18; expected signed").in_file(file).in_column("model"));
    };
    if read.columns.iter().next().is_some() {
        let message = "they hold effects; expected the coefficients as gmr fit wrote them";
        return Err(Error::failed(message).in_file(file).in_column("effects"));
    }
    Ok((read.robot, Reference { torque, drive }))
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

/// Blocks that are read and filtered while those before them are summed, on another core if there
/// is one that has nothing to do.
const BLOCKS: usize = 8;

/// Where the time went, s of one thread each. What idle threads decode ahead is not in it.
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

/// The sums of the runs of a log that is open. Its order is that of its rows, however many cores
/// work: so are the bits.
///
/// # Errors
/// A log that is not one of this robot or is too slow for the filter.
pub(super) fn of_header(robot: &Robot, how: &Conditioned, header: Header) -> Result<Summed> {
    let file = header.path().to_owned();
    let mut filtered = Filtered::of(robot, how, header)?;
    let mut sums = Sums::new(robot, how);
    let (mut blocks, mut ready) = (Vec::new(), Vec::new());
    loop {
        let (is_more, ()) = rayon::join(|| filtered.read(&mut blocks), || sums.add(&ready));
        if !is_more? {
            break;
        }
        std::mem::swap(&mut blocks, &mut ready);
    }
    let Filtered { reader, summaries, spent, .. } = filtered;
    let mut runs = sums.runs;
    let (names, exclusions) = (reader.run_names(), reader.exclusions());
    let several = summaries.len() > 1;
    runs.resize_with(summaries.len(), || empty(how, robot));
    for (place, (run, summary)) in runs.iter_mut().zip(summaries).enumerate() {
        run.summary = summary;
        run.run = file.display().to_string();
        if several {
            run.run += &format!("#{}", names.get(place).map_or("", String::as_str));
        }
    }
    let Some(first) = runs.first_mut() else { return Err(Error::failed("no row to use").in_file(file)) };
    // They belong to the log; its first run tells of them.
    first.summary.exclusions = exclusions;
    let spent = Spent { sums_s: sums.spent_s, ..spent };
    Ok(Summed { runs, spent })
}

/// Rows of a log after the filter.
struct Filtered<'a> {
    robot: &'a Robot,
    how: &'a Conditioned,
    reader: SampleReader,
    conditioner: Conditioner,
    is_commanded: bool,
    most_elapsed_s: f64,
    /// What each run was.
    summaries: Vec<Summary>,
    /// A block as it was read, each row with what was commanded.
    raw: Vec<(RawRow, f64)>,
    spent: Spent,
}

impl<'a> Filtered<'a> {
    fn of(robot: &'a Robot, how: &'a Conditioned, header: Header) -> Result<Self> {
        let started = Instant::now();
        let file = header.path().to_owned();
        let is_commanded = header.has(COMMAND);
        let further: &[&str] = if is_commanded { &[COMMAND] } else { &[] };
        let reader = SampleReader::of(header, robot, further)?;
        Ok(Self {
            robot,
            how,
            conditioner: Conditioner::of_log(&how.core, &file, reader.period_s())?,
            is_commanded,
            most_elapsed_s: MIN_GAP_FACTOR * reader.period_s(),
            reader,
            summaries: Vec::new(),
            raw: Vec::with_capacity(BLOCK),
            spent: Spent { reading_s: started.elapsed().as_secs_f64(), ..Spent::default() },
        })
    }

    /// The next blocks; false at the end.
    fn read(&mut self, blocks: &mut Vec<Rows>) -> Result<bool> {
        blocks.resize_with(BLOCKS, Rows::default);
        let mut is_more = false;
        for rows in blocks {
            rows.clear();
            let started = Instant::now();
            self.raw.clear();
            while self.raw.len() < BLOCK
                && let Some(row) = self.reader.next_row()?
            {
                self.raw.push((row, self.reader.extras().first().copied().unwrap_or(f64::NAN)));
            }
            self.spent.reading_s += started.elapsed().as_secs_f64();
            if self.raw.is_empty() {
                continue;
            }
            is_more = true;
            self.filter(rows);
        }
        Ok(is_more)
    }

    /// What rows were, and what of them comes out of the filter.
    fn filter(&mut self, rows: &mut Rows) {
        let started = Instant::now();
        for (raw, command_m_s) in &self.raw {
            let place = raw.run as usize;
            while self.summaries.len() <= place {
                self.summaries.push(summary(self.robot, self.is_commanded));
            }
            let twist = self.how.core.twist(raw.sample.wheel_speed.iter().copied());
            let fastest = raw.sample.wheel_speed.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
            let now = Moment {
                time_s: raw.time,
                elapsed_s: raw.elapsed,
                speed_m_s: twist.vx,
                turn_rad_s: twist.omega,
                fastest_rad_s: fastest,
                moves: fastest > self.how.core.dead_band(),
                power_w: raw.sample.power,
                mass_kg: raw.mass.unwrap_or(self.how.mass_kg),
                command_m_s: *command_m_s,
            };
            self.summaries[place].add(&now, self.most_elapsed_s);
            if let Some(row) = condition(&mut self.conditioner, raw, self.how.mass_kg) {
                rows.push(row);
            }
        }
        self.spent.filter_s += started.elapsed().as_secs_f64();
    }
}

/// What no run has said anything of.
fn summary(robot: &Robot, is_commanded: bool) -> Summary {
    // A robot that does not say how fast it is: bins of 0.1 m/s, and of 0.25 rad/s.
    let limits = robot.limits();
    Summary::new(limits.speed_m_s.unwrap_or(2.3), limits.turn_rad_s.unwrap_or(5.75), is_commanded)
}

fn empty(how: &Conditioned, robot: &Robot) -> RunGram {
    RunGram {
        format: FORMAT,
        run: String::new(),
        keys: BTreeMap::new(),
        setting: how.setting(robot),
        summary: summary(robot, false),
        eq18: Gram::default(),
        eq18_published: Gram::default(),
        signed: Gram::default(),
        may_clamp: 0,
        local: how.reference.is_some().then(Local::default),
    }
}

/// Sums of rows after the filter.
struct Sums<'a> {
    robot: &'a Robot,
    how: &'a Conditioned,
    runs: Vec<RunGram>,
    /// When the filter has forgotten the last row of a run in which a wheel could be clamped.
    free_from: BTreeMap<u32, f64>,
    spent_s: f64,
}

impl<'a> Sums<'a> {
    fn new(robot: &'a Robot, how: &'a Conditioned) -> Self {
        Self { robot, how, runs: Vec::new(), free_from: BTreeMap::new(), spent_s: 0.0 }
    }

    fn add(&mut self, blocks: &[Rows]) {
        let started = Instant::now();
        for rows in blocks.iter().flat_map(|rows| rows.all().chunk_by(|a, b| a.run == b.run)) {
            let run = rows.others()[0].run;
            let place = run as usize;
            if self.runs.len() <= place {
                self.runs.resize_with(place + 1, || empty(self.how, self.robot));
            }
            let free = self.free_from.entry(run).or_insert(f64::NEG_INFINITY);
            add(&mut self.runs[place], rows, self.how, free);
        }
        self.spent_s += started.elapsed().as_secs_f64();
    }
}

/// Adds rows to the sums of their run, each kind of sums on a core of its own where there are some.
fn add(run: &mut RunGram, rows: Stretch<'_>, how: &Conditioned, free: &mut f64) {
    let RunGram { eq18, eq18_published, signed, may_clamp, local, .. } = run;
    let of = |gate: Gate, row: &Kept<'_>| (eq18::regressors(gate, &row.products(gate), row.mass), row.power);
    let of_eq18 = || {
        eq18.extend(rows.iter().map(|row| of(Gate::Corrected, &row)));
        eq18_published.extend(rows.iter().map(|row| of(Gate::Published, &row)));
    };
    let of_signed = || {
        let (memory, before) = (SETTLES / how.core.cutoff_hz(), signed.rows());
        signed.extend(rows.iter().filter_map(|row| {
            if !polynomial::cannot_clamp(row.wheels, how.drive) {
                *free = row.time + memory;
            }
            (row.time >= *free).then(|| (polynomial::regressors(&row), row.power))
        }));
        *may_clamp += rows.others().len() as u64 - (signed.rows() - before);
    };
    let of_local = || {
        if let (Some(local), Some((reference, _))) = (local, &how.reference) {
            rows.iter().for_each(|row| local.add(&row, reference));
        }
    };
    rayon::join(of_eq18, || rayon::join(of_signed, of_local));
}
