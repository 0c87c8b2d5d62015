//! From a log to the sums of its runs, in one pass and in bounded memory.

use std::collections::BTreeMap;
use std::path::Path;

use crc::{CRC_32_ISO_HDLC, Crc};
use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::{self, Gate};
use model_core::model::Model;
use model_core::torque::Drive;

use super::local::{Local, Reference};
use super::polynomial;
use super::run::{FORMAT, RunGram, Setting};
use super::summary::{Instant, Summary};
use crate::coefficients::CoefficientsFile;
use crate::error::{Error, Result};
use crate::fit::dataset::{Row, condition};
use crate::fit::gram::Gram;
use crate::input::{MOST_DESCRIPTION, read_text};
use crate::log::{Header, MIN_GAP_FACTOR, SampleReader, conditioner};
use crate::robot::Robot;

/// How logs are read.
#[derive(Debug, Clone)]
pub struct Conditioned<const N: usize> {
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
    /// They cannot be read, are of another robot or of another model than the signed one, or hold effects.
    pub fn near(robot: &Robot, file: &Path, mass_kg: f64) -> Result<Self> {
        let read = CoefficientsFile::<N>::read(file, robot)?.coefficients;
        let Model::Signed { torque, drive } = read.model else {
            return Err(Error::failed("model eq18; expected signed").in_file(file).in_column("model"));
        };
        if read.columns.iter().next().is_some() {
            let message = "they hold effects; expected the coefficients as gmr fit wrote them";
            return Err(Error::failed(message).in_file(file).in_column("effects"));
        }
        let text = read_text(file, MOST_DESCRIPTION)?;
        let checksum = format!("{:08x}", Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(text.as_bytes()));
        Ok(Self {
            core: read.robot,
            drive,
            reference: Some((Reference { torque, drive }, checksum)),
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

/// What commands are called in logs.
const COMMAND: &str = "cmd_v_m_s";

/// Periods of the cutoff that the filter takes to forget, as after a start.
const SETTLES: f64 = 2.0;

/// Rows that are summed at a time.
const BLOCK: usize = 1024;

/// The sums of a log's runs, in the order in which they begin.
///
/// # Errors
/// A log that cannot be read, is not one of this robot or is too slow for the filter.
pub fn of_log<const N: usize>(robot: &Robot, how: &Conditioned<N>, file: &Path) -> Result<Vec<RunGram>> {
    let is_commanded = Header::open(file)?.has(COMMAND);
    let further: &[&str] = if is_commanded { &[COMMAND] } else { &[] };
    let mut reader = SampleReader::<N>::open_with(file, robot, further)?;
    let mut conditioner = conditioner(&how.core, file, reader.period_s())?;
    let most_elapsed = MIN_GAP_FACTOR * reader.period_s();
    let mut runs: Vec<RunGram> = Vec::new();
    let mut rows: Vec<Row<N>> = Vec::with_capacity(BLOCK);
    let mut free_from = BTreeMap::new();
    while let Some(raw) = reader.next_row()? {
        let place = raw.run as usize;
        while runs.len() <= place {
            runs.push(empty(how, robot, is_commanded));
        }
        let speeds = raw.sample.wheel_speed;
        let twist = how.core.kinematics.twist(&speeds);
        let fastest = speeds.iter().map(|speed| speed.abs()).fold(0.0, f64::max);
        let now = Instant {
            time_s: raw.time,
            elapsed_s: raw.elapsed,
            speed_m_s: twist.vx,
            turn_rad_s: twist.omega,
            fastest_rad_s: fastest,
            moves: fastest > how.core.dead_band,
            power_w: raw.sample.power,
            mass_kg: raw.mass.unwrap_or(how.mass_kg),
            command_m_s: reader.extras().first().copied().unwrap_or(f64::NAN),
        };
        runs[place].summary.add(&now, most_elapsed);
        if let Some(row) = condition(&mut conditioner, &raw, how.mass_kg) {
            rows.push(row);
        }
        if rows.len() == BLOCK {
            add(&mut runs, &rows, how, &mut free_from);
            rows.clear();
        }
    }
    add(&mut runs, &rows, how, &mut free_from);
    let (names, exclusions) = (reader.run_names(), reader.exclusions());
    let several = runs.len() > 1;
    for (place, run) in runs.iter_mut().enumerate() {
        run.run = file.display().to_string();
        if several {
            run.run += &format!("#{}", names.get(place).map_or("", String::as_str));
        }
    }
    if let Some(first) = runs.first_mut() {
        // They belong to the log; its first run tells of them.
        first.summary.exclusions = exclusions;
    }
    if runs.is_empty() {
        return Err(Error::failed("no row to use").in_file(file));
    }
    Ok(runs)
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

/// Adds rows to the sums of their runs; `free_from` is when the filter has forgotten the last row in which a wheel could be clamped.
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
