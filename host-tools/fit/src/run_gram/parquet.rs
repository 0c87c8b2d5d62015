//! Grams as Parquet: a run a row, its sums as columns.

use std::path::Path;

use log_formats::table::{Cell, Columns, Values};
use log_formats::write::Parquet;
use logs::foreign::wrong;
use support::error::{Error, Result};
use support::output::write_content;

use super::columns::{Flat, TEXTS, names};
use super::run::RunGram;

/// How such a file begins.
pub(super) const MAGIC: &[u8] = b"PAR1";

/// Writes them, whole or not at all.
///
/// # Errors
/// What the operating system refuses.
pub(super) fn write(file: &Path, grams: &[RunGram]) -> Result<()> {
    let columns: Vec<String> = TEXTS
        .iter()
        .map(|text| (*text).to_owned())
        .chain(names().iter().map(|column| column.name.clone()))
        .collect();
    let is_text: Vec<bool> = (0..columns.len()).map(|place| place < TEXTS.len()).collect();
    let failed = |error| wrong(error).in_file(file);
    let mut content = Vec::new();
    let mut writer = Parquet::new(&mut content, &columns, &is_text).map_err(failed)?;
    for gram in grams {
        let Flat { texts, numbers } = Flat::of(gram)?;
        let row: Vec<Cell> =
            texts.into_iter().map(Cell::Text).chain(numbers.into_iter().map(Cell::Number)).collect();
        writer.row(&row).map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    write_content(file, content)
}

/// Reads them; columns of other names are left alone.
///
/// # Errors
/// A file that is damaged, lacks a column or holds a row that is no gram: names it.
pub(super) fn read(file: &Path) -> Result<Vec<RunGram>> {
    let failed = |error| wrong(error).in_file(file);
    let mut columns = Columns::open(file).map_err(failed)?;
    let place = |name: &str| {
        columns.names().iter().position(|column| column == name).ok_or_else(|| {
            let message = "is missing; expected the columns that gmr gram writes";
            Error::failed(message).in_file(file).in_column(name)
        })
    };
    let texts = TEXTS.iter().map(|name| place(name)).collect::<Result<Vec<usize>>>()?;
    let numbers = names().iter().map(|column| place(&column.name)).collect::<Result<Vec<usize>>>()?;
    let mut values = vec![Values::Unread; columns.names().len()];
    let mut grams = Vec::new();
    loop {
        let count = columns.next(&mut values).map_err(failed)?;
        if count == 0 {
            return Ok(grams);
        }
        for row in 0..count {
            let text = |place: usize| match &values[place] {
                Values::Texts(texts) => texts[row].clone().unwrap_or_default(),
                _ => String::new(),
            };
            let number = |place: &usize| match &values[*place] {
                Values::Numbers(numbers) => numbers[row],
                _ => f64::NAN,
            };
            let flat = Flat {
                texts: std::array::from_fn(|place| text(texts[place])),
                numbers: numbers.iter().map(number).collect(),
            };
            let line = grams.len() as u64 + 1;
            grams.push(flat.gram().map_err(|error| error.in_file(file).at_line(line))?);
        }
    }
}
