//! Rows of a log as numbers, in the columns asked for.

use std::collections::HashMap;
use std::path::Path;

use support::context::Context;
use support::error::{Error, Result};

use super::columnar::{Columnar, Values};
use super::exclusions::Exclusions;
use super::header::{From, Header};
use super::line::{Fault, Layout, Wanted, parse_row, plain_row};
use super::missing::missing;
use super::pieces::Pieces;
use super::run_numbers::{MOST_RUNS, Runs};
use super::scan;
use super::source::Line;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// A number that every row needs: rows without a finite one are excluded.
    Number,
    /// A number that may be missing: NaN then.
    MaybeNumber,
    /// Time in seconds; as `Number`, and it must increase within a run.
    Time,
    /// Number or text that names the run: handed out as 0, 1, … in order of appearance.
    Run,
}

/// A column to read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnRequest {
    name: String,
    role: Role,
    required: bool,
}

impl ColumnRequest {
    /// A column that the log must have.
    pub fn required(name: impl Into<String>, role: Role) -> Self {
        Self { name: name.into(), role, required: true }
    }

    /// A column whose value is NaN in every row if the log does not have it.
    pub fn optional(name: impl Into<String>, role: Role) -> Self {
        Self { name: name.into(), role, required: false }
    }
}

/// Bytes of a text that are read before threads that have nothing to do are asked to help, and that
/// are left to be worth it.
const ALONE: u64 = 1 << 20;

/// Reads a log row by row; memory does not grow with the file.
pub struct LogReader {
    from: From,
    /// Rows of a large text, of which others make numbers ahead.
    pieces: Option<Pieces>,
    /// Bytes of a text behind which they do.
    ahead_at: u64,
    columns: Vec<String>,
    layout: Layout,
    present: Vec<bool>,
    time_slot: Option<usize>,
    runs: Runs,
    /// Factor of each slot, where one is not 1.
    scales: Option<Vec<f64>>,
    last: Option<(f64, f64)>,
    rows: u64,
    exclusions: Exclusions,
}

impl Header {
    /// Goes on to the rows.
    ///
    /// # Errors
    /// A required column is missing.
    pub fn read(self, requests: &[ColumnRequest]) -> Result<LogReader> {
        LogReader::new(self.from, self.columns, requests)
    }
}

impl LogReader {
    /// Opens a log for the columns asked for.
    ///
    /// # Errors
    /// As [`Header::open`] and [`Header::read`].
    pub fn open(context: &Context, path: &Path, requests: &[ColumnRequest]) -> Result<Self> {
        Header::open(context, path)?.read(requests)
    }

    pub(super) fn new(from: From, columns: Vec<String>, requests: &[ColumnRequest]) -> Result<Self> {
        let mut from = from;
        let mut wanted = vec![None; columns.len()];
        let mut present = vec![false; requests.len()];
        let mut places: HashMap<&str, usize> = HashMap::with_capacity(columns.len());
        for (place, column) in columns.iter().enumerate() {
            places.entry(column).or_insert(place);
        }
        let slot_of = |role| requests.iter().position(|request| request.role == role);
        for (slot, request) in requests.iter().enumerate() {
            match places.get(request.name.as_str()).copied() {
                Some(position) => {
                    wanted[position] = Some(Wanted { slot, role: request.role });
                    present[slot] = true;
                }
                None if request.required => {
                    let mut message = missing(&request.name, &columns);
                    if let Some(lacks) = from.lacks() {
                        message = format!("{message}; it {lacks}");
                    }
                    return Err(Error::failed(message).in_file(from.path()).at_line(1));
                }
                None => {}
            }
        }
        if let From::Columns(columnar) = &mut from {
            columnar.only(&wanted.iter().map(Option::is_some).collect::<Vec<_>>());
        }
        while let Some(None) = wanted.last() {
            wanted.pop();
        }
        let plain = wanted.iter().map(|wanted| wanted.filter(|column| column.role != Role::Run));
        let plain: Option<Vec<usize>> = plain.map(|wanted| Some(wanted?.slot)).collect();
        let layout = Layout {
            plain: plain.filter(|slots| slots.len() == columns.len()),
            wanted,
            columns: columns.len(),
            width: requests.len(),
            run_slot: slot_of(Role::Run).filter(|&slot| present[slot]),
        };
        Ok(Self {
            time_slot: slot_of(Role::Time).filter(|&slot| present[slot]),
            layout,
            from,
            pieces: None,
            ahead_at: ALONE,
            columns,
            present,
            runs: Runs::default(),
            scales: None,
            last: None,
            rows: 0,
            exclusions: Exclusions::default(),
        })
    }

    /// Hands out the number of each slot times its factor: for logs in other units.
    ///
    /// # Panics
    /// If there are not as many as requests.
    #[must_use]
    pub fn scaled(mut self, scales: Vec<f64>) -> Self {
        assert_eq!(scales.len(), self.present.len(), "one factor a slot");
        self.scales = scales.iter().any(|scale| *scale != 1.0).then_some(scales);
        self
    }

    /// All column names of the log, wanted or not.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Whether the log has the column of the request at `slot`.
    pub fn has(&self, slot: usize) -> bool {
        self.present[slot]
    }

    /// Path of the log.
    pub fn path(&self) -> &Path {
        self.from.path()
    }

    /// Rows handed out so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// What was left out so far.
    pub fn exclusions(&self) -> Exclusions {
        self.exclusions
    }

    /// Names of the runs seen so far, indexed by the value of the run column.
    pub fn run_names(&self) -> &[String] {
        &self.runs.names
    }

    /// Bytes read and the size of the file, where it has one: for a progress bar.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.from.progress()
    }

    /// The next row into `values`, in the order of the requests; its line number, or `None` at the
    /// end.
    ///
    /// # Errors
    /// Text in a number, too few or too many fields, time that does not increase, or fewer than two
    /// rows in all.
    ///
    /// # Panics
    /// If `values` is shorter than the requests.
    #[inline]
    pub fn next_row(&mut self, values: &mut [f64]) -> Result<Option<u64>> {
        let line = self.next_written(values)?;
        if let Some(scales) = &self.scales {
            for (value, scale) in values.iter_mut().zip(scales) {
                *value *= scale;
            }
        }
        Ok(line)
    }

    /// The same, as written.
    #[inline]
    fn next_written(&mut self, values: &mut [f64]) -> Result<Option<u64>> {
        loop {
            values[..self.present.len()].fill(f64::NAN);
            let source = match &mut self.from {
                From::Text(source) => source,
                From::Columns(columnar) => {
                    let Some(place) = columnar.advance()? else { return self.finish() };
                    let line = columnar.line_number();
                    let read = columns_row(columnar, place, &self.layout.wanted, &mut self.runs, values);
                    let finite = read.map_err(|fault| self.fault_in_column(place, &fault))?;
                    if self.takes(line, finite, values)? {
                        return Ok(Some(line));
                    }
                    continue;
                }
            };
            if let Some(pieces) = &mut self.pieces {
                let Some((rows, place)) = pieces.row() else {
                    match pieces.advance() {
                        Some(bytes) => source.count_bytes(bytes),
                        None => self.go_on_alone()?,
                    }
                    continue;
                };
                source.count_line();
                let line = source.line_number();
                let taken = rows.take(place, &self.layout, &mut self.runs, values);
                let finite = taken.map_err(|fault| self.fault(&[], fault))?;
                if self.takes(line, finite, values)? {
                    return Ok(Some(line));
                }
                continue;
            }
            if let Some(slots) = &self.layout.plain
                && let Some(length) = plain_row(source.unread(), slots, values)
            {
                source.skip_line(length);
                let line = source.line_number();
                self.check_time(values)?;
                self.rows += 1;
                return Ok(Some(line));
            }
            if source.consumed() >= self.ahead_at {
                self.ahead_at = u64::MAX;
                if rayon::current_num_threads() > 1
                    && source.has_left(ALONE)
                    && let Some((file, unread)) = source.lend()
                {
                    self.pieces = Some(Pieces::new(file, unread, self.layout.clone()));
                    continue;
                }
            }
            let (start, end) = match source.next_line()? {
                Line::Whole(start, end) => (start, end),
                Line::Cut(start, end) => {
                    if !source.bytes(start, end).trim_ascii().is_empty() {
                        self.exclusions.cut_line = 1;
                    }
                    continue;
                }
                Line::End => return self.finish(),
            };
            let number = source.line_number();
            let line = source.bytes(start, end);
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            match parse_row(line, &self.layout.wanted, self.columns.len(), &mut self.runs, values) {
                Ok(finite) => {
                    if self.takes(number, finite, values)? {
                        return Ok(Some(number));
                    }
                }
                Err(fault) => {
                    if line.trim_ascii().is_empty() {
                        self.blank_line()?;
                        continue;
                    }
                    let line = line.to_owned();
                    return Err(self.fault(&line, fault));
                }
            }
        }
    }

    /// What is left of a large text is read as that of a small one.
    #[cold]
    fn go_on_alone(&mut self) -> Result<()> {
        let From::Text(source) = &mut self.from else { return Ok(()) };
        let rest = self.pieces.take().and_then(Pieces::end);
        let Some((file, unread)) = rest else {
            return Err(Error::failed("is no longer there to be read").in_file(self.path()));
        };
        source.take_back(file, unread);
        Ok(())
    }

    /// Blank lines are fine at the end only.
    fn blank_line(&mut self) -> Result<()> {
        let From::Text(source) = &mut self.from else { return Ok(()) };
        let blank = source.line_number();
        loop {
            match source.next_line()? {
                Line::Whole(start, end) | Line::Cut(start, end) => {
                    if !source.bytes(start, end).trim_ascii().is_empty() {
                        let message = "blank line in the middle of the log; expected a row";
                        return Err(Error::failed(message).in_file(self.path()).at_line(blank));
                    }
                }
                Line::End => return Ok(()),
            }
        }
    }

    /// Counts a row, as one to hand out or as one that is left out for what is not finite.
    #[inline]
    fn takes(&mut self, line: u64, finite: bool, values: &[f64]) -> Result<bool> {
        let is_taken = self.check_time(values)? && finite;
        if is_taken {
            self.rows += 1;
        } else {
            self.exclusions.add_non_finite(line);
        }
        Ok(is_taken)
    }

    fn check_time(&mut self, values: &[f64]) -> Result<bool> {
        let Some(slot) = self.time_slot else { return Ok(true) };
        let time = values[slot];
        if !time.is_finite() {
            return Ok(false);
        }
        let run = self.layout.run_slot.map_or(0.0, |slot| values[slot]);
        if let Some((last_run, last_time)) = self.last
            && last_run == run
            && time <= last_time
        {
            let remedy = if time == last_time {
                "keep one row of each time"
            } else {
                "sort the rows, or tell runs apart by a column run"
            };
            let message = format!(
                "time {time} follows {last_time}; expected time to increase from row to row ({remedy})"
            );
            return Err(self.here(message).in_column(super::TIME));
        }
        self.last = Some((run, time));
        Ok(true)
    }

    fn finish(&mut self) -> Result<Option<u64>> {
        if self.rows >= 2 {
            return Ok(None);
        }
        let excluded = match self.exclusions.total() {
            0 => String::new(),
            _ => format!(" ({})", self.exclusions),
        };
        let rows = match self.rows {
            0 => "no row",
            _ => "only one row",
        };
        let message = format!("the log has {rows} to use{excluded}; expected at least two");
        Err(Error::failed(message).in_file(self.path()))
    }

    fn here(&self, message: impl Into<String>) -> Error {
        Error::failed(message).in_file(self.path()).at_line(self.from.line_number())
    }

    #[cold]
    fn fault_in_column(&self, place: usize, fault: &Fault) -> Error {
        let Fault::Text { field } = fault else { return self.fault(&[], Fault::Runs) };
        let text = match &self.from {
            From::Columns(columnar) => match columnar.values(*field) {
                Values::Texts(texts) => texts[place].clone().unwrap_or_default(),
                _ => String::new(),
            },
            From::Text(_) => String::new(),
        };
        self.here(format!("{:?} is not a number; expected a number", shortened(text.as_bytes())))
            .in_column(&self.columns[*field])
    }

    #[cold]
    fn fault(&self, line: &[u8], fault: Fault) -> Error {
        match fault {
            Fault::Text { field } => {
                let text = scan::Fields::new(line).nth(field).unwrap_or_default();
                let expected = if has_decimal_comma(text) {
                    "expected a number with a decimal point, not a comma"
                } else {
                    "expected a number"
                };
                self.here(format!("{:?} is not a number; {expected}", shortened(text)))
                    .in_column(&self.columns[field])
            }
            Fault::Runs => {
                self.here(format!("another run; expected at most {MOST_RUNS} in a log")).in_column(super::RUN)
            }
            Fault::FieldCount => {
                let fields = scan::Fields::new(line).count();
                let expected = self.columns.len();
                let s = if fields == 1 { "" } else { "s" };
                let hint =
                    if fields > expected { " (decimal commas? write numbers with a point)" } else { "" };
                self.here(format!("{fields} field{s}; expected {expected} as in the header{hint}"))
            }
        }
    }
}

/// Takes the wanted columns of a row; whether all that are needed are finite.
#[inline]
fn columns_row(
    columnar: &Columnar,
    place: usize,
    wanted: &[Option<Wanted>],
    runs: &mut Runs,
    values: &mut [f64],
) -> std::result::Result<bool, Fault> {
    let mut finite = true;
    for (field, wanted) in wanted.iter().enumerate() {
        let Some(Wanted { slot, role }) = wanted else { continue };
        let value = match (role, columnar.values(field)) {
            (Role::Run, Values::Numbers(numbers)) => runs.id(numbers[place].to_string().as_bytes()) as f64,
            (Role::Run, Values::Texts(texts)) => {
                runs.id(texts[place].as_deref().unwrap_or_default().trim().as_bytes()) as f64
            }
            (_, Values::Numbers(numbers)) => numbers[place],
            (_, Values::Texts(texts)) => match &texts[place] {
                Some(text) => scan::number_in_field(text.as_bytes()).ok_or(Fault::Text { field })?,
                None => f64::NAN,
            },
            (_, Values::Unread) => f64::NAN,
        };
        if *role == Role::Run && value >= MOST_RUNS as f64 {
            return Err(Fault::Runs);
        }
        finite &= value.is_finite() || *role == Role::MaybeNumber;
        values[*slot] = value;
    }
    Ok(finite)
}

/// Whether a field in quotes is a number as some countries write it.
fn has_decimal_comma(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text).replacen(',', ".", 1);
    text.trim_matches('"').trim().parse::<f64>().is_ok()
}

/// Text for a message: printable and short.
fn shortened(text: &[u8]) -> String {
    const LONGEST: usize = 24;
    let text = String::from_utf8_lossy(text);
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into_owned(),
    }
}
