//! A log as a drive: wheels, power, payload, runs and gaps.

use std::collections::VecDeque;
use std::path::Path;

use support::context::Context;
use support::error::{Error, Result};

use super::exclusions::Exclusions;
use super::header::Header;
use super::reader::{ColumnRequest, LogReader, Role};
use super::simulated::Torques;
use super::{
    MASS, POWER, RUN, SIM_POWER, TIME, YAW_RATE, acceleration_column, sim_torque_column, speed_column,
};
use crate::robot::chassis::PerWheel;
use crate::robot::{PowerSource, Robot};

/// A step longer than this many median sample periods is a gap: derivatives and filters start
/// afresh behind it.
pub const MIN_GAP_FACTOR: f64 = 3.0;

/// Rows looked at for the median sample period before the first one is handed out.
const PEEKED: usize = 4096;

/// A longer median step is taken for another unit than seconds.
const LONGEST_STEP_S: f64 = 10.0;

/// No robot draws or returns so much power, W: such a number is a fault, and its squares would
/// drown the others.
const MOST_W: f64 = 1e9;

/// No wheel turns so fast, rad/s.
const MOST_RAD_S: f64 = 1e6;

/// One row of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record {
    /// Line of the log, the header being line 1.
    pub line: u64,
    /// Run: 0, 1, … in order of appearance; 0 without a `run` column.
    pub run: usize,
    /// Whether this row does not continue the one before: the first row, a new run, or behind a
    /// gap.
    pub starts_segment: bool,
    /// Time, s.
    pub time_s: f64,
    /// Wheel speeds, rad/s.
    pub wheel_speed: PerWheel<f64>,
    /// Wheel accelerations, rad/s², if the log has them for all wheels.
    pub wheel_acceleration: Option<PerWheel<f64>>,
    /// Power, W: actuation or total, as [`Robot::power_is_total`] says.
    pub power_w: f64,
    /// Total mass, kg, where the log tells it.
    pub mass_kg: Option<f64>,
    /// Turn rate by a gyro, counter-clockwise, rad/s, where this row tells it.
    pub yaw_rate: Option<f64>,
}

/// A hole in a log.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Gap {
    /// First line behind the gap.
    pub line: u64,
    /// Time of the row before, s.
    pub from_s: f64,
    /// Time of the row behind, s.
    pub to_s: f64,
}

/// Wheel speed columns of a log: `wheel1_rad_s`, `wheel2_rad_s`, … without a hole.
pub fn wheel_columns(columns: &[String]) -> usize {
    (0..).take_while(|&wheel| columns.contains(&speed_column(wheel))).count()
}

/// Reads the log of a robot row by row.
pub struct DriveReader {
    reader: LogReader,
    wheels: usize,
    slots: Slots,
    /// What makes a power of a simulator's torques.
    torques: Option<Torques>,
    /// The mass that somebody weighed with this log, kg.
    weighed: Option<f64>,
    power_column: &'static str,
    values: Vec<f64>,
    extras: Vec<f64>,
    peeked: VecDeque<(Record, Vec<f64>)>,
    failed: Option<Error>,
    period_s: f64,
    last: Option<(usize, f64)>,
    gaps: u64,
    longest_gap: Option<Gap>,
}

/// Positions in the requested row.
struct Slots {
    acceleration: Option<usize>,
    /// Torques of a simulator, which stand for the power.
    torques: Option<usize>,
    mass: usize,
    run: Option<usize>,
    yaw_rate: Option<usize>,
    extras: usize,
}

const TIME_SLOT: usize = 0;
const POWER_SLOT: usize = 1;
const SPEED_SLOT: usize = 2;

impl DriveReader {
    /// Opens the log of a run of `robot`.
    ///
    /// # Errors
    /// As [`LogReader::open`]; the log has more or fewer wheels than the robot; accelerations of
    /// some wheels only; steps of time that cannot be seconds.
    pub fn open(context: &Context, path: &Path, robot: &Robot) -> Result<Self> {
        Self::open_with(context, path, robot, &[])
    }

    /// As [`open`](Self::open), with further columns (candidate drivers), handed out by
    /// [`extras`](Self::extras).
    ///
    /// # Errors
    /// As [`open`](Self::open); an extra column is missing.
    pub fn open_with(context: &Context, path: &Path, robot: &Robot, extra: &[&str]) -> Result<Self> {
        Self::of(Header::open(context, path)?, robot, extra)
    }

    /// Of an opened log.
    ///
    /// # Errors
    /// As [`open_with`](Self::open_with).
    pub fn of(header: Header, robot: &Robot, extra: &[&str]) -> Result<Self> {
        let wheels = robot.wheels();
        check_wheels(&header, robot)?;
        let power = match robot.power_source() {
            PowerSource::Measured => ColumnRequest::required(POWER, Role::Number),
            PowerSource::Simulated => ColumnRequest::required(SIM_POWER, Role::Number),
            PowerSource::SimulatedTorques => ColumnRequest::optional(POWER, Role::MaybeNumber),
        };
        let mut requests = vec![ColumnRequest::required(TIME, Role::Time), power];
        requests.extend((0..wheels).map(|wheel| ColumnRequest::required(speed_column(wheel), Role::Number)));
        let mass = requests.len();
        let mut slots =
            Slots { acceleration: None, torques: None, mass, run: None, yaw_rate: None, extras: 0 };
        requests.push(ColumnRequest::optional(MASS, Role::MaybeNumber));
        if (0..wheels).any(|wheel| header.has(&acceleration_column(wheel))) {
            slots.acceleration = Some(requests.len());
            requests.extend(
                (0..wheels).map(|wheel| ColumnRequest::required(acceleration_column(wheel), Role::Number)),
            );
        }
        let torques = match robot.power_source() {
            PowerSource::SimulatedTorques => Some(Torques::of(robot)?),
            _ => None,
        };
        if torques.is_some() {
            slots.torques = Some(requests.len());
            requests.extend(
                (0..wheels).map(|wheel| ColumnRequest::required(sim_torque_column(wheel), Role::Number)),
            );
        }
        if header.has(RUN) {
            slots.run = Some(requests.len());
            requests.push(ColumnRequest::required(RUN, Role::Run));
        }
        // A column is read once, for whomever.
        let wanted = extra.iter().position(|name| *name == YAW_RATE);
        if wanted.is_none() && header.has(YAW_RATE) {
            slots.yaw_rate = Some(requests.len());
            requests.push(ColumnRequest::required(YAW_RATE, Role::MaybeNumber));
        }
        slots.extras = requests.len();
        slots.yaw_rate = slots.yaw_rate.or(wanted.map(|place| slots.extras + place));
        requests.extend(extra.iter().map(|name| ColumnRequest::required(*name, Role::MaybeNumber)));
        let mut scales = vec![1.0; requests.len()];
        scales[POWER_SLOT] = robot.log_units().power_in_w();
        scales[slots.mass] = robot.log_units().mass.in_kg();
        for wheel in 0..wheels {
            for slot in [Some(SPEED_SLOT), slots.acceleration].into_iter().flatten() {
                scales[slot + wheel] = robot.log_speed_scale(wheel);
            }
            if let Some(slot) = slots.torques {
                scales[slot + wheel] = robot.log_speed_scale(wheel).signum();
            }
        }

        let weighed = robot.log_units().mass_of(header.path());
        let mut drive = Self {
            values: vec![0.0; requests.len()],
            reader: header.read(&requests)?.scaled(scales),
            wheels,
            torques,
            weighed,
            power_column: if robot.power_source() == PowerSource::Simulated { SIM_POWER } else { POWER },
            extras: vec![f64::NAN; extra.len()],
            slots,
            peeked: VecDeque::new(),
            failed: None,
            period_s: f64::NAN,
            last: None,
            gaps: 0,
            longest_gap: None,
        };
        drive.peek()?;
        Ok(drive)
    }

    /// Reads ahead for the median sample period; a fault found there is reported when its row is
    /// asked for, unless no row comes before it.
    fn peek(&mut self) -> Result<()> {
        let mut steps = Vec::with_capacity(PEEKED);
        let mut last: Option<(usize, f64)> = None;
        while self.peeked.len() < PEEKED {
            match self.read_record() {
                Ok(Some(record)) => {
                    if let Some((run, time)) = last
                        && run == record.run
                    {
                        steps.push(record.time_s - time);
                    }
                    last = Some((record.run, record.time_s));
                    let extras = self.values[self.slots.extras..].to_vec();
                    self.peeked.push_back((record, extras));
                }
                Ok(None) => break,
                Err(error) if self.peeked.is_empty() || self.reader.rows() < 2 => return Err(error),
                Err(error) => {
                    self.failed = Some(error);
                    break;
                }
            }
        }
        if steps.is_empty() {
            return Ok(());
        }
        let middle = steps.len() / 2;
        self.period_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        if self.period_s > LONGEST_STEP_S {
            let message = format!(
                "the median step is {} s; expected seconds, at most {LONGEST_STEP_S} s a step (is this milliseconds or \
                 nanoseconds?)",
                self.period_s
            );
            return Err(Error::failed(message).in_file(self.reader.path()).at_line(2).in_column(TIME));
        }
        Ok(())
    }

    #[inline]
    fn read_record(&mut self) -> Result<Option<Record>> {
        let Some(line) = self.reader.next_row(&mut self.values)? else { return Ok(None) };
        let mut limits =
            (0..self.wheels).map(|wheel| (SPEED_SLOT + wheel, MOST_RAD_S)).chain([(POWER_SLOT, MOST_W)]);
        if let Some((slot, most)) = limits.find(|(slot, most)| self.values[*slot].abs() >= *most) {
            let column = if slot == POWER_SLOT {
                self.power_column.to_owned()
            } else {
                speed_column(slot - SPEED_SLOT)
            };
            let message = format!("{:e} is beyond any robot; expected below {most:e}", self.values[slot]);
            return Err(Error::failed(message).in_file(self.reader.path()).at_line(line).in_column(&column));
        }
        let wheels = |slot: usize| PerWheel::new(self.wheels, |wheel| self.values[slot + wheel]);
        let mass = self.values[self.slots.mass];
        let wheel_speed = wheels(SPEED_SLOT);
        let power_w = match (&self.torques, self.slots.torques) {
            (Some(torques), Some(slot)) => torques.power_w(&wheels(slot), &wheel_speed),
            _ => self.values[POWER_SLOT],
        };
        Ok(Some(Record {
            line,
            run: self.slots.run.map_or(0, |slot| self.values[slot] as usize),
            starts_segment: false,
            time_s: self.values[TIME_SLOT],
            wheel_speed,
            wheel_acceleration: self.slots.acceleration.map(wheels),
            power_w,
            mass_kg: self.weighed.or(mass.is_finite().then_some(mass)),
            yaw_rate: self.slots.yaw_rate.map(|slot| self.values[slot]).filter(|rate| rate.is_finite()),
        }))
    }

    /// The next row, or `None` at the end.
    ///
    /// # Errors
    /// As [`LogReader::next_row`]; a power or a speed beyond any robot.
    #[inline]
    pub fn next_record(&mut self) -> Result<Option<Record>> {
        let mut record = if let Some((record, extras)) = self.peeked.pop_front() {
            self.extras.copy_from_slice(&extras);
            record
        } else {
            if let Some(error) = self.failed.take() {
                return Err(error);
            }
            let Some(record) = self.read_record()? else { return Ok(None) };
            self.extras.copy_from_slice(&self.values[self.slots.extras..]);
            record
        };
        record.starts_segment = match self.last {
            Some((run, time)) if run == record.run => {
                let gap = record.time_s - time > MIN_GAP_FACTOR * self.period_s;
                if gap {
                    self.add_gap(Gap { line: record.line, from_s: time, to_s: record.time_s });
                }
                gap
            }
            _ => true,
        };
        self.last = Some((record.run, record.time_s));
        Ok(Some(record))
    }

    #[cold]
    fn add_gap(&mut self, gap: Gap) {
        self.gaps += 1;
        if self.longest_gap.is_none_or(|longest| gap.to_s - gap.from_s > longest.to_s - longest.from_s) {
            self.longest_gap = Some(gap);
        }
    }

    /// Values of the extra columns in the row handed out last; NaN where a field was empty.
    pub fn extras(&self) -> &[f64] {
        &self.extras
    }

    /// Median sample period of the first rows, s; NaN if no two rows belong to one run.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Gaps met so far and the longest of them.
    pub fn gaps(&self) -> (u64, Option<Gap>) {
        (self.gaps, self.longest_gap)
    }

    /// Rows left out so far. While rows are peeked this runs ahead of the rows handed out.
    pub fn exclusions(&self) -> Exclusions {
        self.reader.exclusions()
    }

    /// Whether the log tells the mass.
    pub fn has_mass(&self) -> bool {
        self.weighed.is_some() || self.reader.has(self.slots.mass)
    }

    /// Names of the runs seen so far, indexed by [`Record::run`].
    pub fn run_names(&self) -> &[String] {
        self.reader.run_names()
    }

    /// All column names of the log.
    pub fn columns(&self) -> &[String] {
        self.reader.columns()
    }

    /// Path of the log.
    pub fn path(&self) -> &Path {
        self.reader.path()
    }

    /// Bytes read and the size of the file, where it has one: for a progress bar.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.reader.progress()
    }
}

/// Whether log and robot have the same wheels.
///
/// # Errors
/// They have not.
pub fn check_wheels(header: &Header, robot: &Robot) -> Result<()> {
    let wheels = robot.wheels();
    let highest = header.columns().iter().filter_map(|column| wheel_number(column)).max().unwrap_or(0);
    if highest == 0 && !header.has(&speed_column(0)) {
        // The missing column itself says it best.
        return Ok(());
    }
    let columns = wheel_columns(header.columns());
    if columns == highest && columns != wheels {
        let message = format!(
            "the log has {columns} wheel speed column{}, but robot {} has {wheels} wheels: wrong robot?",
            if columns == 1 { "" } else { "s" },
            robot.name()
        );
        return Err(Error::failed(message).in_file(header.path()).at_line(1));
    }
    Ok(())
}

/// `k` of `wheel{k}_rad_s`.
fn wheel_number(column: &str) -> Option<usize> {
    column.strip_prefix("wheel")?.strip_suffix("_rad_s")?.parse().ok()
}
