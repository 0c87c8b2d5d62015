//! Files of sums: JSON, a run a line, or Parquet, a run a row.

use std::io::{BufRead as _, BufReader};
use std::path::Path;

use support::context::Context;
use support::error::{Error, Result};
use support::input::Input;
use support::output::write_whole;

use super::parquet;
use super::run::{FORMAT, RunGram};

/// Writes them, whole or not at all: a file `….parquet` as such, any other as JSON, a run a line.
///
/// # Errors
/// What the operating system refuses.
pub fn write_all(file: &Path, grams: &[RunGram]) -> Result<()> {
    if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet")) {
        return parquet::write(file, grams);
    }
    write_whole(file, |out| {
        for gram in grams {
            let line = gram.line()?;
            out.write_all(line.as_bytes())
                .and_then(|()| out.write_all(b"\n"))
                .map_err(|error| Error::io(file, &error))?;
        }
        Ok(())
    })
}

/// Bytes of a line, at most: a gram has some 15 thousand.
const MOST_LINE: u64 = 1 << 20;

/// Reads them, of either kind.
///
/// # Errors
/// A line or row that is no gram of this format: names it.
pub fn read_all(context: &Context, file: &Path) -> Result<Vec<RunGram>> {
    let mut text = BufReader::new(Input::open(context, file)?);
    if text.fill_buf().is_ok_and(|head| head.starts_with(parquet::MAGIC)) {
        return parquet::read(file);
    }
    let mut grams = Vec::new();
    for number in 1.. {
        let mut line = String::new();
        let wrong = |message: String| Error::failed(message).in_file(file).at_line(number);
        let length = std::io::Read::take(&mut text, MOST_LINE)
            .read_line(&mut line)
            .map_err(|error| wrong(format!("{error}; expected grams: a JSON object a line")))?;
        if length == 0 {
            break;
        }
        let format = serde_json::from_str::<serde_json::Value>(&line)
            .ok()
            .and_then(|gram| gram.get("format")?.as_u64());
        if let Some(other) = format.filter(|format| *format != u64::from(FORMAT)) {
            return Err(wrong(format!(
                "format {other}; expected {FORMAT}: make the grams again with this gmr gram"
            )));
        }
        let gram: RunGram = serde_json::from_str(&line)
            .map_err(|error| wrong(format!("is no gram ({error}); expected what gmr gram writes")))?;
        if gram.local.as_ref().is_some_and(|local| !local.is_whole()) {
            return Err(wrong("local has another number of sums; expected what gmr gram writes".to_owned()));
        }
        grams.push(gram);
    }
    if grams.is_empty() {
        return Err(Error::failed("is empty; expected grams: a JSON object a line").in_file(file));
    }
    Ok(grams)
}
