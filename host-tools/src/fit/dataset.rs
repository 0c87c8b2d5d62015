//! Logs, read once: Gram matrices of every row, and a thinned store of conditioned rows.
//!
//! The store keeps every k-th row, k doubling whenever it is full: memory is bounded, and since speed and power have
//! passed a low-pass filter, neighbouring rows of a long log repeat each other. What needs single rows (which wheels are
//! clamped, errors in percent, block-wise standard errors) looks at the store; sums over all rows come from the stream.

use std::path::{Path, PathBuf};

use model_core::coefficients::Robot as CoreRobot;
use model_core::eq18::{self, Gate};
use model_core::estimator::{Conditioner, Sample};
use model_core::motion::Motion;

use super::gram::Gram;
use crate::error::{Error, Result};
use crate::log::{DriveReader, Exclusions};
use crate::progress::FileProgress;
use crate::robot::Robot;

/// Most rows in the store.
pub const STORE_ROWS: usize = 1 << 18;

/// One conditioned row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<const N: usize> {
    /// Speeds and accelerations behind the filter.
    pub motion: Motion<f64, N>,
    /// Actuation power behind the filter, W.
    pub power: f64,
    /// Total mass, kg.
    pub mass: f64,
    /// Which run: files and values of their `run` column are counted through.
    pub run: u32,
    /// Time within its log, s.
    pub time: f64,
}

/// One run of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its log.
    pub file: PathBuf,
    /// Sums over all its rows.
    pub gram: Gram,
}

/// What the logs hold.
#[derive(Debug, Clone)]
pub struct Dataset<const N: usize> {
    /// The robot, with the filter's cutoff.
    pub robot: CoreRobot<f64, N>,
    /// The gate that the Gram matrices are formed with.
    pub gate: Gate,
    /// One entry a run.
    pub runs: Vec<Run>,
    /// The thinned rows, in the order of the logs.
    pub store: Vec<Row<N>>,
    /// Every how many rows one is in the store.
    pub stride: u32,
    /// Median sample period of the first log, s.
    pub period_s: f64,
    /// Rows read.
    pub rows: u64,
    /// Rows used: behind the filter's settling.
    pub used: u64,
    /// Rows left out as unusable, over all logs.
    pub excluded: u64,
    /// Payloads met, kg, to the gram, at most [`MOST_MASSES`].
    pub masses: Vec<f64>,
}

/// Payloads told apart.
pub const MOST_MASSES: usize = 16;

/// What to read logs for.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    /// Products of which model.
    pub gate: Gate,
    /// Cutoff of the filter, Hz; by the first log's sample rate unless given.
    pub cutoff_hz: Option<f64>,
    /// Total mass where a log has no `mass_kg`, kg.
    pub mass_kg: f64,
}

impl<const N: usize> Dataset<N> {
    /// Reads the logs, each once.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot; no usable row in any.
    pub fn read(robot: &Robot, files: &[PathBuf], reading: &Reading) -> Result<Self> {
        let mut dataset: Option<Self> = None;
        let mut progress = FileProgress::new(files);
        for file in files {
            let mut reader = DriveReader::<N>::open(file, robot)?;
            let period_s = reader.period_s();
            let dataset = match &mut dataset {
                Some(dataset) => dataset,
                none => {
                    let cutoff_hz = reading.cutoff_hz.unwrap_or_else(|| robot.cutoff_hz(period_s));
                    none.insert(Self::empty(robot.core(cutoff_hz)?, reading.gate, period_s))
                }
            };
            let exclusions = dataset.read_log(robot, file, &mut reader, reading, &mut progress)?;
            if exclusions.total() > 0 {
                progress.note(&format!("{}: {exclusions}", file.display()));
            }
        }
        progress.finish();
        let dataset = dataset.ok_or_else(|| Error::usage("no log was given"))?;
        if dataset.store.is_empty() {
            return Err(Error::failed(format!(
                "no usable row: the filter (cutoff {:.2} Hz) needs {:.1} s to settle after each start and gap",
                dataset.robot.cutoff_hz,
                2.0 / dataset.robot.cutoff_hz
            ))
            .in_file(&files[0]));
        }
        Ok(dataset)
    }

    fn empty(robot: CoreRobot<f64, N>, gate: Gate, period_s: f64) -> Self {
        Self {
            robot,
            gate,
            runs: Vec::new(),
            store: Vec::new(),
            stride: 1,
            period_s,
            rows: 0,
            used: 0,
            excluded: 0,
            masses: Vec::new(),
        }
    }

    fn read_log(
        &mut self,
        robot: &Robot,
        file: &Path,
        reader: &mut DriveReader<N>,
        reading: &Reading,
        progress: &mut FileProgress,
    ) -> Result<Exclusions> {
        let mut conditioner = conditioner(&self.robot, file, reader.period_s())?;
        let static_power = robot.static_power_w().unwrap_or(0.0);
        let first_run = self.runs.len();
        let mut last_time = f64::NAN;
        let mut last_mass = f64::NAN;
        while let Some(record) = reader.next_record()? {
            self.rows += 1;
            if self.rows.is_multiple_of(1 << 16) {
                progress.at(reader.progress());
            }
            let run = first_run + record.run;
            while self.runs.len() <= run {
                self.runs.push(Run { file: file.to_owned(), gram: Gram::default() });
            }
            let sample = Sample {
                wheel_speed: record.wheel_speed,
                wheel_acceleration: record.wheel_acceleration,
                power: record.power_w - static_power,
            };
            // A new run starts the filter anew, as a gap does.
            let elapsed = if record.starts_segment { f64::INFINITY } else { record.time_s - last_time };
            last_time = record.time_s;
            let Some(now) = conditioner.push(&sample, elapsed) else { continue };
            if !now.settled {
                continue;
            }
            let mass = record.mass_kg.unwrap_or(reading.mass_kg);
            if mass.to_bits() != f64::to_bits(last_mass) {
                self.note_mass(mass, file, record.line)?;
                last_mass = mass;
            }
            let products = eq18::products(self.gate, &now.motion);
            self.runs[run].gram.add(&eq18::regressors(self.gate, &products, mass), now.power);
            if self.used.is_multiple_of(u64::from(self.stride)) {
                self.keep(Row {
                    motion: now.motion,
                    power: now.power,
                    mass,
                    run: run as u32,
                    time: record.time_s,
                });
            }
            self.used += 1;
        }
        progress.done_with_file();
        let exclusions = reader.exclusions();
        self.excluded += exclusions.total();
        Ok(exclusions)
    }

    fn note_mass(&mut self, mass: f64, file: &Path, line: u64) -> Result<()> {
        if mass <= 0.0 {
            return Err(Error::failed(format!("a total mass of {mass} kg; expected above 0"))
                .in_file(file)
                .at_line(line)
                .in_column(crate::log::MASS));
        }
        let known = self.masses.iter().any(|known| (known - mass).abs() < 1e-3);
        if !known && self.masses.len() < MOST_MASSES {
            self.masses.push(mass);
        }
        Ok(())
    }

    fn keep(&mut self, row: Row<N>) {
        if self.store.len() == STORE_ROWS {
            let mut index = 0_usize;
            self.store.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
            if !self.used.is_multiple_of(u64::from(self.stride)) {
                return;
            }
        }
        self.store.push(row);
    }

    /// Sums over all rows of all runs.
    pub fn gram(&self) -> Gram {
        let mut total = Gram::default();
        for run in &self.runs {
            total.merge(&run.gram);
        }
        total
    }

    /// Time between rows of the store, s.
    pub fn store_period_s(&self) -> f64 {
        self.period_s * f64::from(self.stride)
    }
}

/// The conditioner for a log of this robot.
///
/// # Errors
/// The log is too slow for the filter.
pub fn conditioner<const N: usize>(
    robot: &CoreRobot<f64, N>,
    file: &Path,
    period_s: f64,
) -> Result<Conditioner<f64, N>> {
    Conditioner::new(robot, period_s).map_err(|error| {
        Error::failed(format!(
            "sampled at {:.2} Hz, too slow for the filter's cutoff of {} Hz; expected a cutoff below {:.2} Hz \
             (filter_cutoff_hz in robot.toml)",
            1.0 / period_s,
            error.cutoff_hz,
            error.below_hz
        ))
        .in_file(file)
    })
}
