//! Samples of a board, as it takes them, into a log that every other command reads.
//!
//! The log is the one file here that is not written whole or not at all: it grows by whole lines,
//! so that it is of use up to the last sample whatever ends it. Columns: `time_s` since the board's
//! start; `wheel1_rad_s`, `wheel2_rad_s`; `power_w`, which is the motors' rail; `bus_v`, the
//! battery's voltage; `battery_w`, `motors_w`, `computer_w`, `lidar_w`; with coefficients the
//! board's own estimate, `board_power_w`, `board_mass_kg`, `board_mass_low_kg`,
//! `board_mass_high_kg`; `mass_kg` where it is given. Single-precision numbers have the digits that
//! bring back the same number, and what is not known is empty.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::time::Duration;

use firmware::control_table as table;
use firmware::record::{RECORD_BYTES, Record};
use firmware::wheels::WHEELS;
use logs::{MASS, POWER, TIME, speed_column};
use support::error::{Error, Result};

use super::client::{Board, Client};
use super::transport::Transport;
use super::{motors_rail, rail_names};

/// A board that answers but has taken no sample for so long takes none.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// Windows that are read until one begins where it was asked to.
const MOST_ATTEMPTS: u32 = 3;

/// What to record.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// On the board's clock, from the first sample; for ever without.
    pub duration: Option<Duration>,
    /// Total mass, kg, where it is known: for fits.
    pub mass_kg: Option<f64>,
    /// Begin with the oldest sample that the board keeps. If that is its first, a replay repeats
    /// the board's estimates exactly; otherwise its seconds begin at another time.
    pub backlog: bool,
}

/// How far a recording is.
pub struct Progress<'a> {
    /// Samples in the log.
    pub rows: u64,
    /// Samples that the board took and that never arrived.
    pub lost: u64,
    /// Between the first and the last sample, on the board's clock.
    pub elapsed: Duration,
    /// The last sample, where there is one.
    pub last: Option<&'a Record>,
}

/// Why a recording is over. Whatever it is: what was recorded is in the log.
#[derive(Debug)]
pub enum Ending {
    /// The duration asked for is over.
    Complete,
    /// Whoever watches has seen enough.
    Stopped,
    /// The board started again: its time would run backwards.
    Restarted,
    /// The board's clock jumped ahead, s: no time passed that its samples could tell of.
    Jumped {
        /// By so much, s.
        seconds: f64,
    },
    /// The board is gone, or takes no samples.
    Lost(Error),
}

/// What was recorded.
#[derive(Debug)]
pub struct Recording {
    /// Samples in the log.
    pub rows: u64,
    /// Samples that the board took and that never arrived: gaps in the log.
    pub lost: u64,
    /// Samples without wheel speed or motor power: commands that need these leave them out.
    pub incomplete: u64,
    /// Between the first and the last sample, on the board's clock.
    pub elapsed: Duration,
    /// Why it is over.
    pub ending: Ending,
}

/// Records until the duration is over, `progress` breaks, or the board is gone. `append` gets whole
/// lines, of a few samples at a time, and nothing before the first. `progress` is asked a few times
/// a second, whether there are new samples or not.
///
/// # Errors
/// The log cannot be written, or the board is gone before the first sample.
pub fn record<T: Transport>(
    client: &mut Client<T>,
    board: &Board,
    options: &Options,
    append: &mut dyn FnMut(&str) -> Result<()>,
    progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
) -> Result<Recording> {
    let size = usize::from(client.get::<u16>(&table::RECORD_SIZE)?);
    if size != RECORD_BYTES {
        return Err(Error::failed(format!("the board's records have {size} bytes; expected {RECORD_BYTES}")));
    }
    // Unless asked for, what the board kept before is no part of this run.
    let first = if options.backlog { &table::FIFO_OLDEST } else { &table::FIFO_NEXT };
    let next = client.get::<u32>(first)?;
    let mut run = Run {
        columns: Columns { estimate: board.has_coefficients, mass_kg: options.mass_kg },
        duration: options.duration,
        next,
        rate_hz: board.sample_rate_hz,
        first_us: None,
        last: None,
        rows: 0,
        lost: 0,
        incomplete: 0,
    };
    let ending = run.follow(client, board.sample_rate_hz, append, progress)?;
    match ending {
        Ending::Lost(error) if run.rows == 0 => Err(error),
        ending => Ok(Recording {
            rows: run.rows,
            lost: run.lost,
            incomplete: run.incomplete,
            elapsed: run.elapsed(),
            ending,
        }),
    }
}

/// A recording under way.
struct Run {
    columns: Columns,
    duration: Option<Duration>,
    /// Sequence number of the record that comes next.
    next: u32,
    rate_hz: u16,
    first_us: Option<u64>,
    last: Option<Record>,
    rows: u64,
    lost: u64,
    incomplete: u64,
}

impl Run {
    fn follow<T: Transport>(
        &mut self,
        client: &mut Client<T>,
        rate_hz: u16,
        append: &mut dyn FnMut(&str) -> Result<()>,
        progress: &mut dyn FnMut(&Progress<'_>) -> ControlFlow<()>,
    ) -> Result<Ending> {
        // Twice as often as the window fills.
        let pause =
            Duration::from_secs(1) * table::FIFO_WINDOW_RECORDS as u32 / 2 / u32::from(rate_hz.max(1));
        let mut last_sample = client.now();
        let mut lines = String::new();
        loop {
            let window = match Window::read(client, self.next) {
                Ok(window) => window,
                Err(error) => return Ok(Ending::Lost(error)),
            };
            lines.clear();
            let ending = self.take(&window, &mut lines);
            if !lines.is_empty() {
                append(&lines)?;
            }
            let now = Progress {
                rows: self.rows,
                lost: self.lost,
                elapsed: self.elapsed(),
                last: self.last.as_ref(),
            };
            if let Some(ending) = ending {
                return Ok(ending);
            }
            if progress(&now).is_break() {
                return Ok(Ending::Stopped);
            }
            if !lines.is_empty() {
                last_sample = client.now();
            } else if client.now().saturating_sub(last_sample) >= LONGEST_PAUSE {
                let seconds = LONGEST_PAUSE.as_secs();
                let message = format!("the board answers, but has taken no sample for {seconds} s");
                return Ok(Ending::Lost(Error::failed(message)));
            }
            if window.records.len() < table::FIFO_WINDOW_RECORDS
                && let Err(error) = client.wait(pause)
            {
                return Ok(Ending::Lost(error));
            }
        }
    }

    /// The records of a window as lines; why the recording is over, if it is.
    fn take(&mut self, window: &Window, lines: &mut String) -> Option<Ending> {
        if is_before(window.next, self.next) {
            return Some(Ending::Restarted);
        }
        for record in &window.records {
            if self.last.as_ref().is_some_and(|last| record.time_us <= last.time_us) {
                return Some(Ending::Restarted);
            }
            if let Some(seconds) = self.jump(record) {
                return Some(Ending::Jumped { seconds });
            }
            let first_us = *self.first_us.get_or_insert(record.time_us);
            let elapsed = Duration::from_micros(record.time_us.saturating_sub(first_us));
            if self.duration.is_some_and(|duration| elapsed + self.half_a_period() >= duration) {
                return Some(Ending::Complete);
            }
            if self.rows == 0 {
                lines.push_str(&self.columns.header());
            }
            self.lost += u64::from(record.sequence.wrapping_sub(self.next));
            self.next = record.sequence.wrapping_add(1);
            self.rows += 1;
            self.incomplete += u64::from(record.wheel_speed.is_none() || motors_power(record).is_none());
            self.columns.push_row(lines, record);
            self.last = Some(*record);
        }
        None
    }

    /// How far its clock is ahead of the time that the samples since the last one take, s, where
    /// that is more than a board pauses.
    fn jump(&self, record: &Record) -> Option<f64> {
        let last = self.last.as_ref()?;
        let passed = Duration::from_micros(record.time_us - last.time_us).as_secs_f64();
        let samples = f64::from(record.sequence.wrapping_sub(last.sequence));
        let ahead = passed - samples / f64::from(self.rate_hz.max(1));
        // Samples that come at half their rate are late, not a jump.
        (ahead > LONGEST_PAUSE.as_secs_f64() && ahead > 0.5 * passed).then_some(ahead)
    }

    /// A first sample that was stamped a little late is no reason for one more at the end.
    fn half_a_period(&self) -> Duration {
        Duration::from_secs(1) / 2 / u32::from(self.rate_hz.max(1))
    }

    fn elapsed(&self) -> Duration {
        match (self.first_us, &self.last) {
            (Some(first), Some(last)) => Duration::from_micros(last.time_us.saturating_sub(first)),
            _ => Duration::ZERO,
        }
    }
}

/// Whether one sequence number precedes the other; they wrap.
fn is_before(sequence: u32, other: u32) -> bool {
    sequence.wrapping_sub(other) > u32::MAX / 2
}

fn motors_power(record: &Record) -> Option<f32> {
    *record.rail_power.get(motors_rail()?)?
}

/// What the board shows of its records.
struct Window {
    /// Sequence number that its next sample will have.
    next: u32,
    records: Vec<Record>,
}

impl Window {
    /// The records from `from` on, all before which have arrived.
    fn read<T: Transport>(client: &mut Client<T>, from: u32) -> Result<Self> {
        let mut attempts = 1;
        let block = loop {
            // A board that has started again refuses a number that it has not come to.
            let acknowledged = client.set(&table::FIFO_ACKNOWLEDGE, from);
            let block = client.block(&table::FIFO_ACKNOWLEDGE, &table::FIFO_WINDOW)?;
            if acknowledged.is_err() && is_before(block.get(&table::FIFO_NEXT)?, from) {
                break block;
            }
            acknowledged?;
            // Another number stands in an answer to an earlier question.
            if block.get::<u32>(&table::FIFO_ACKNOWLEDGE)? == from {
                break block;
            }
            if attempts == MOST_ATTEMPTS {
                return Err(Error::failed("the board does not take what it is told"));
            }
            attempts += 1;
        };
        let count = usize::from(block.get::<u16>(&table::FIFO_COUNT)?);
        let (records, _) = block.bytes(&table::FIFO_WINDOW)?.as_chunks::<RECORD_BYTES>();
        let records = records.iter().take(count).map(|bytes| {
            Record::decode(bytes).ok_or_else(|| Error::failed("a record that this version does not know"))
        });
        Ok(Self { next: block.get(&table::FIFO_NEXT)?, records: records.collect::<Result<_>>()? })
    }
}

/// Which columns a log has.
struct Columns {
    estimate: bool,
    mass_kg: Option<f64>,
}

impl Columns {
    fn header(&self) -> String {
        let mut header = TIME.to_owned();
        for wheel in 0..WHEELS {
            header += &format!(",{}", speed_column(wheel));
        }
        header += &format!(",{POWER},bus_v");
        for rail in rail_names() {
            header += &format!(",{rail}_w");
        }
        if self.estimate {
            header += ",board_power_w,board_mass_kg,board_mass_low_kg,board_mass_high_kg";
        }
        if self.mass_kg.is_some() {
            header += &format!(",{MASS}");
        }
        header + "\n"
    }

    fn push_row(&self, line: &mut String, record: &Record) {
        let [left, right] = record.wheel_speed.map_or([None; WHEELS], |speeds| speeds.map(Some));
        let mut fields = vec![left, right, motors_power(record), record.battery_voltage];
        fields.extend(record.rail_power);
        if self.estimate {
            let mass = record.mass;
            fields.extend([record.predicted_power, mass.map(|mass| mass.mass)]);
            fields.extend([mass.map(|mass| mass.low), mass.map(|mass| mass.high)]);
        }
        // Writing to a String cannot fail.
        let _ = write!(line, "{}.{:06}", record.time_us / 1_000_000, record.time_us % 1_000_000);
        for field in fields {
            line.push(',');
            if let Some(value) = field.filter(|value| value.is_finite()) {
                // As few digits as no other number of its precision has.
                let _ = write!(line, "{value}");
            }
        }
        if let Some(mass) = self.mass_kg {
            let _ = write!(line, ",{mass}");
        }
        line.push('\n');
    }
}
