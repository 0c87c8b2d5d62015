//! Logs, read once: Gram matrices of every row, and a thinned store of conditioned rows.
//!
//! The store keeps every k-th row, k doubling whenever it is full: memory is bounded, and since
//! speed and power have passed a low-pass filter, neighbouring rows of a long log repeat each
//! other. What needs single rows (which wheels are clamped, errors in percent, block-wise standard
//! errors) looks at the store; sums over all rows come from the stream.

use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::{Conditioner, RawRow, SampleReader};
use model_core::eq18::{self, Gate, REGRESSORS};
use support::context::Context;
use support::error::{Error, Result};
use support::progress::FileProgress;

use super::gram::Gram;
use super::physical::FreeTerms;
pub use super::rows::{Kept, Row, Rows, Stretch};

/// Most rows in the store.
pub const STORE_ROWS: usize = 1 << 18;

/// One run of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its log.
    pub file: PathBuf,
    /// Sums over all its rows; none for [`Gate::Signed`], whose fit needs single rows.
    pub gram: Gram<REGRESSORS>,
}

/// What the logs hold.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// The robot, with the filter's cutoff.
    pub robot: Chassis,
    /// The gate that the Gram matrices are formed with.
    pub gate: Gate,
    /// One entry a run.
    pub runs: Vec<Run>,
    /// The thinned rows, in the order of the logs.
    pub store: Rows,
    /// Every how many rows one is in the store.
    pub stride: u32,
    /// Median sample period of the first log, s.
    pub period_s: f64,
    /// Rows read.
    pub rows: u64,
    /// Rows used: those after the filter has settled.
    pub used: u64,
    /// Rows left out as unusable, over all logs.
    pub excluded: u64,
    /// The terms of the torque model that are free.
    pub free_terms: FreeTerms,
    /// Steps of a search so long that no further term was asked; `None` as a rule.
    pub long_search: Option<u32>,
    /// Payloads met, kg, to the gram, at most [`MOST_MASSES`].
    pub masses: Vec<f64>,
}

/// Payloads distinguished.
pub const MOST_MASSES: usize = 16;

/// What to read logs for.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    /// Products of which model.
    pub gate: Gate,
    /// Cutoff of the filter, Hz; the robot's, or chosen by the data ([`super::read`]), unless
    /// given.
    pub cutoff_hz: Option<f64>,
    /// Total mass where a log has no `mass_kg`, kg.
    pub mass_kg: f64,
}

impl Dataset {
    /// Reads the logs through the filter of `core`, each once. [`super::read`] chooses its cutoff
    /// first.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot; no usable row in any.
    pub fn read(
        context: &Context,
        robot: &Robot,
        core: Chassis,
        files: &[PathBuf],
        reading: &Reading,
    ) -> Result<Self> {
        let Some(first) = files.first() else { return Err(Error::usage("no log was given")) };
        let cutoff_hz = core.cutoff_hz();
        let mut dataset = Self::empty(core, reading.gate);
        let mut progress = FileProgress::new(context, files);
        for file in files {
            let mut reader = SampleReader::open(context, file, robot)?;
            dataset.read_log(context, file, &mut reader, reading.mass_kg, &mut progress)?;
            progress.done_with_file();
            let exclusions = reader.exclusions();
            dataset.excluded += exclusions.total();
            if exclusions.total() > 0 {
                context.notice(format_args!("{}: {exclusions}", file.display()));
            }
        }
        progress.finish();
        if dataset.store.is_empty() {
            return Err(Error::failed(format!(
                "no usable row: the filter (cutoff {cutoff_hz} Hz) needs {:.1} s to settle after each start and gap; \
                 expected a longer log",
                2.0 / cutoff_hz
            ))
            .in_file(first));
        }
        Ok(dataset)
    }

    pub fn empty(robot: Chassis, gate: Gate) -> Self {
        Self {
            robot,
            gate,
            runs: Vec::new(),
            store: Rows::default(),
            stride: 1,
            period_s: f64::NAN,
            rows: 0,
            used: 0,
            excluded: 0,
            free_terms: FreeTerms::default(),
            long_search: None,
            masses: Vec::new(),
        }
    }

    fn read_log(
        &mut self,
        context: &Context,
        file: &Path,
        reader: &mut SampleReader,
        mass_kg: f64,
        progress: &mut FileProgress,
    ) -> Result<()> {
        let mut conditioner = Conditioner::of_log(&self.robot, file, reader.period_s())?;
        if self.period_s.is_nan() {
            self.period_s = reader.period_s();
        }
        let first_run = self.runs.len();
        let (out, blocks) = sync_channel(BLOCKS_AHEAD);
        thread::scope(|scope| {
            // Text to numbers is half of the work: on another core, if there is one.
            let parser = scope.spawn(move || parse(reader, &out));
            let mut rows = Rows::default();
            for Block { raw_rows, bytes } in blocks {
                self.rows += raw_rows.len() as u64;
                progress.at(bytes);
                context.point();
                for raw in &raw_rows {
                    let run = first_run + raw.run as usize;
                    while self.runs.len() <= run {
                        self.runs.push(Run { file: file.to_owned(), gram: Gram::default() });
                    }
                    if let Some(row) = condition(&mut conditioner, raw, mass_kg) {
                        let row = Kept { run: run as u32, ..row };
                        self.take(row);
                        // The signed model's fit looks at the store only.
                        if self.gate != Gate::Signed {
                            rows.push(row);
                        }
                    }
                }
                self.add_to_grams(rows.all());
                rows.clear();
            }
            parser.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    }

    /// Takes a conditioned row into the store, if it is its turn.
    pub(super) fn take(&mut self, row: Kept<'_>) {
        if self.used.is_multiple_of(u64::from(self.stride)) {
            self.keep(row);
        }
        self.used += 1;
        let known = self.masses.iter().any(|known| (known - row.mass).abs() < 1e-3);
        if !known && self.masses.len() < MOST_MASSES {
            self.masses.push(row.mass);
        }
    }

    pub fn keep(&mut self, row: Kept<'_>) {
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

    /// The stored rows with the sums of another model. What a split has held out is then in
    /// neither.
    pub fn with_gate(&self, gate: Gate) -> Self {
        let mut other = Self { gate, ..self.clone() };
        for run in &mut other.runs {
            run.gram = Gram::default();
        }
        other.add_to_grams(self.store.all());
        other
    }

    /// Takes conditioned rows into the sums of their runs.
    fn add_to_grams(&mut self, rows: Stretch<'_>) {
        // With the gate known where it is compiled, the products stay in registers.
        for rows in rows.chunk_by(|a, b| a.run == b.run) {
            let Some(run) = self.runs.get_mut(rows.others()[0].run as usize) else { continue };
            match self.gate {
                Gate::Published => run.gram.extend(rows.iter().map(|row| summand(Gate::Published, row))),
                Gate::Corrected => run.gram.extend(rows.iter().map(|row| summand(Gate::Corrected, row))),
                Gate::Signed => run.gram.extend(rows.iter().map(|row| summand(Gate::Signed, row))),
            }
        }
    }

    /// Sums over all rows of all runs.
    pub fn gram(&self) -> Gram<REGRESSORS> {
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

/// Regressors and power of a row.
#[inline(always)]
fn summand(gate: Gate, row: Kept<'_>) -> ([f64; REGRESSORS], f64) {
    (eq18::regressors(gate, &row.products(gate), row.mass), row.power)
}

/// Rows that are handed from thread to thread at a time.
const BLOCK_ROWS: usize = 1024;

/// Blocks that wait for the conditioning thread at most.
const BLOCKS_AHEAD: usize = 4;

/// Rows as read.
struct Block {
    raw_rows: Vec<RawRow>,
    /// Bytes read and the size of the file.
    bytes: (u64, Option<u64>),
}

/// Reads a log to its end, or until nobody listens any more.
fn parse(reader: &mut SampleReader, out: &SyncSender<Block>) -> Result<()> {
    loop {
        let raw_rows = reader.next_block(BLOCK_ROWS)?;
        let block = Block { raw_rows, bytes: reader.progress() };
        if block.raw_rows.is_empty() || out.send(block).is_err() {
            return Ok(());
        }
    }
}

/// A raw row after the filter; `None` while that settles, and of a robot with true slip where the
/// row has no turn rate.
pub fn condition<'a>(conditioner: &'a mut Conditioner, raw: &RawRow, mass_kg: f64) -> Option<Kept<'a>> {
    let now = conditioner.push(raw).filter(|now| now.settled)?;
    Some(Kept::of(now, raw, mass_kg))
}
