//! Rows of a log in another format, kept in a temporary file as the numbers that they are: row by
//! row, 64 bits a cell.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::sync::{Arc, Mutex, PoisonError};

use log_formats::table::{Cell, Taker, Values};
use support::error::Error;

/// Rows that are read at a time.
const BATCH: usize = 1024;

/// A cell that is a text is a number that none is, with the text's place in its lower half.
const TEXT: u64 = 0x7ff9_0000_0000_0000;

/// Bytes of a cell.
const CELL: usize = size_of::<u64>();

/// All rows of a log. Whoever opens the log reads them from their start.
#[derive(Debug, Clone)]
pub(crate) struct Spool(Arc<Rows>);

#[derive(Debug)]
struct Rows {
    names: Vec<String>,
    /// Whether a column holds a text anywhere.
    is_text: Vec<bool>,
    texts: Vec<String>,
    rows: u64,
    lacks: Option<String>,
    file: Mutex<File>,
}

impl Spool {
    /// The columns' names.
    pub(crate) fn names(&self) -> &[String] {
        &self.0.names
    }

    /// What was looked for in the log and not found, and how robot.toml may name it.
    pub(crate) fn lacks(&self) -> Option<&str> {
        self.0.lacks.as_deref()
    }

    /// How many rows there are.
    pub(crate) fn rows(&self) -> u64 {
        self.0.rows
    }

    /// Takes the rows from `first` on into `batch`, a column each, as many as come at a time; their
    /// number, 0 at the end.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub(crate) fn read(&self, first: u64, batch: &mut [Values]) -> io::Result<usize> {
        let Rows { names, is_text, texts, rows, file, .. } = &*self.0;
        let count = (rows - first).min(BATCH as u64) as usize;
        let width = CELL * names.len();
        let mut bytes = vec![0; count * width];
        {
            let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
            file.seek(SeekFrom::Start(first * width as u64))?;
            file.read_exact(&mut bytes)?;
        }
        let (cells, _) = bytes.as_chunks::<CELL>();
        let cell = |row: usize, column: usize| u64::from_ne_bytes(cells[row * names.len() + column]);
        for (column, values) in batch.iter_mut().enumerate() {
            let cells = (0..count).map(|row| cell(row, column));
            *values = if is_text[column] {
                Values::Texts(cells.map(|bits| text(bits, texts)).collect())
            } else {
                Values::Numbers(cells.map(f64::from_bits).collect())
            };
        }
        Ok(count)
    }
}

/// A cell of a column with texts; `None` where the row has none.
fn text(bits: u64, texts: &[String]) -> Option<String> {
    if bits & TEXT == TEXT {
        return texts.get((bits ^ TEXT) as usize).cloned();
    }
    let number = f64::from_bits(bits);
    (!number.is_nan()).then(|| number.to_string())
}

/// Takes rows; errors of it are ours, and pass through the readers.
pub(super) struct Writer {
    to: BufWriter<File>,
    names: Vec<String>,
    is_text: Vec<bool>,
    texts: Vec<String>,
    places: HashMap<String, u64>,
    rows: u64,
    /// What was looked for in the log and not found, and how robot.toml may name it.
    pub(super) lacks: Option<String>,
}

impl Writer {
    /// Into a temporary file.
    ///
    /// # Errors
    /// There is no place for one.
    pub(super) fn new() -> io::Result<Self> {
        Ok(Self {
            to: BufWriter::with_capacity(1 << 20, tempfile::tempfile()?),
            names: Vec::new(),
            is_text: Vec::new(),
            texts: Vec::new(),
            places: HashMap::new(),
            rows: 0,
            lacks: None,
        })
    }

    /// All that it took.
    ///
    /// # Errors
    /// The disk is full.
    pub(super) fn finish(self) -> support::error::Result<Spool> {
        let Self { to, names, is_text, texts, rows, lacks, .. } = self;
        let file = to.into_inner().map_err(|error| failed(error.error()))?;
        Ok(Spool(Arc::new(Rows { names, is_text, texts, rows, lacks, file: Mutex::new(file) })))
    }

    fn bits(&mut self, column: usize, cell: &Cell) -> u64 {
        match cell {
            // Of the many that are none, one: the others are texts.
            Cell::Number(number) if number.is_nan() => f64::NAN.to_bits(),
            Cell::Number(number) => number.to_bits(),
            Cell::Text(text) => {
                self.is_text[column] = true;
                let place = match self.places.get(text) {
                    Some(place) => *place,
                    None => {
                        let place = self.texts.len() as u64;
                        self.texts.push(text.clone());
                        self.places.insert(text.clone(), place);
                        place
                    }
                };
                TEXT | place
            }
        }
    }
}

impl Taker for Writer {
    fn columns(&mut self, columns: &[String]) -> log_formats::Result<()> {
        self.names = columns.to_vec();
        self.is_text = vec![false; columns.len()];
        Ok(())
    }

    fn row(&mut self, row: &[Cell]) -> log_formats::Result<()> {
        self.rows += 1;
        for (column, cell) in row.iter().enumerate() {
            let bits = self.bits(column, cell);
            self.to
                .write_all(&bits.to_ne_bytes())
                .map_err(|error| log_formats::Error::Taker(Box::new(failed(&error))))?;
        }
        Ok(())
    }
}

fn failed(error: &io::Error) -> Error {
    let said = io::Error::new(error.kind(), format!("its rows cannot be kept in a temporary file: {error}"));
    Error::of_system(&said)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers come back bit for bit, texts as they were, over several batches; what is no number
    /// is none, whatever its bits.
    #[test]
    fn rows_come_back_as_they_were() {
        let mut writer = Writer::new().unwrap();
        writer.columns(&["a", "b"].map(str::to_owned)).unwrap();
        let odd = f64::from_bits(TEXT | 3);
        let number = |row: usize| if row == 7 { odd } else { 0.1 * row as f64 - 0.0 };
        let name = |row: usize| {
            if row.is_multiple_of(3) { Cell::Number(1.5) } else { Cell::Text(format!("{}", row % 5)) }
        };
        let count = 2 * BATCH + 3;
        for row in 0..count {
            writer.row(&[Cell::Number(number(row)), name(row)]).unwrap();
        }
        let spool = writer.finish().unwrap();
        assert_eq!((spool.rows(), spool.names()), (count as u64, &["a", "b"].map(str::to_owned)[..]));
        let (mut batch, mut first) = (vec![Values::Unread; 2], 0);
        loop {
            let read = spool.read(first as u64, &mut batch).unwrap();
            if read == 0 {
                break;
            }
            let (Values::Numbers(numbers), Values::Texts(texts)) = (&batch[0], &batch[1]) else { panic!() };
            for place in 0..read {
                let row = first + place;
                assert_eq!(numbers[place].to_bits(), if row == 7 { f64::NAN } else { number(row) }.to_bits());
                let expected = match name(row) {
                    Cell::Number(number) => number.to_string(),
                    Cell::Text(text) => text,
                };
                assert_eq!(texts[place].as_ref(), Some(&expected));
            }
            first += read;
        }
        assert_eq!(first, count);
    }
}
