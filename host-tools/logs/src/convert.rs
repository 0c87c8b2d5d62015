//! Logs of any format that is read, as one log in CSV, Parquet or MCAP.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use log_formats::table::Cell;
use log_formats::write::{Mcap, Parquet};
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::progress::FileProgress;

use crate::arguments::{Log, paths};
use crate::{MASS, RUN, TableReader, foreign};

/// What is to be written where.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The logs; of several, each is a run.
    pub logs: &'a [Log],
    /// Total mass of logs without one of their own, kg.
    pub mass_kg: Option<f64>,
    /// The file; its ending says as what.
    pub out: &'a Path,
}

/// What was written.
#[derive(Debug, Serialize)]
pub struct Answer {
    /// The file.
    pub out: String,
    /// Its rows.
    pub rows: u64,
    /// Names of its columns.
    pub columns: Vec<String>,
}

impl Request<'_> {
    /// What needs no log to be refused.
    ///
    /// # Errors
    /// An ending that says nothing; a mass that no robot has.
    pub fn check(&self) -> Result<()> {
        Target::of(self.out)?;
        if let Some(mass) = self.mass_kg.filter(|mass| !is_mass(*mass)) {
            return Err(Error::usage(format!("--mass {mass}: expected a mass above 0 kg")));
        }
        for log in self.logs {
            if let Some(mass) = log.mass_kg.filter(|mass| !is_mass(*mass)) {
                let message = format!("={mass}: expected a total mass above 0 kg behind the log's name");
                return Err(Error::usage(message).in_file(&log.path));
            }
        }
        Ok(())
    }

    /// The total mass that is written for a log, kg.
    fn mass_of(&self, log: &Log) -> Option<f64> {
        log.mass_kg.or(self.mass_kg)
    }
}

fn is_mass(kg: f64) -> bool {
    kg > 0.0 && kg.is_finite()
}

#[derive(Clone, Copy)]
enum Target {
    Csv,
    Parquet,
    Mcap,
}

impl Target {
    fn of(file: &Path) -> Result<Self> {
        match file.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            Some("mcap") => Ok(Self::Mcap),
            _ => Err(Error::usage("expected a name that ends in .csv, .parquet or .mcap").in_file(file)),
        }
    }
}

/// Writes the logs as one, whole or not at all.
///
/// # Errors
/// As [`Request::check`]; logs that cannot be read, have other columns than the first, or say a
/// mass as well; what cannot be written.
pub fn convert(context: &Context, request: &Request<'_>) -> Result<Answer> {
    request.check()?;
    let target = Target::of(request.out)?;
    let columns = columns(context, request)?;
    let rows = output::write_whole(request.out, |to| write(context, request, target, &columns, to))?;
    Ok(Answer { out: request.out.display().to_string(), rows, columns })
}

fn write(
    context: &Context,
    request: &Request<'_>,
    target: Target,
    columns: &[String],
    to: &mut dyn Write,
) -> Result<u64> {
    let is_text: Vec<bool> = columns.iter().map(|name| name == RUN).collect();
    let refused = |error: io::Error| Error::io(request.out, &error);
    if let Target::Csv = target {
        writeln!(to, "{}", columns.join(",")).map_err(refused)?;
        return each_row(context, request, columns, &mut |row| write_csv(to, row).map_err(refused));
    }
    // Both formats go back to write what they know at the end only.
    let mut kept = tempfile::tempfile().map_err(refused)?;
    let file: BufWriter<&File> = BufWriter::new(&kept);
    let wrong = |error| foreign::wrong(error).in_file(request.out);
    let rows = if let Target::Parquet = target {
        let mut writer = Parquet::new(file, columns, &is_text).map_err(wrong)?;
        let rows = each_row(context, request, columns, &mut |row| writer.row(row).map_err(wrong))?;
        writer.finish().map_err(wrong)?;
        rows
    } else {
        let mut writer = Mcap::new(file, columns, &is_text).map_err(wrong)?;
        let rows = each_row(context, request, columns, &mut |row| writer.row(row).map_err(wrong))?;
        writer.finish().map_err(wrong)?;
        rows
    };
    kept.rewind().map_err(refused)?;
    io::copy(&mut kept, to).map_err(refused)?;
    Ok(rows)
}

/// Columns of the first log, which the others have to have as well; with the run's, where there are
/// several logs.
fn columns(context: &Context, request: &Request<'_>) -> Result<Vec<String>> {
    let mut columns = TableReader::open(context, &request.logs[0].path)?.columns().to_vec();
    for log in &request.logs[1..] {
        let other = TableReader::open(context, &log.path)?;
        if other.columns() != columns {
            let message = format!(
                "has the columns {}; expected {}, as the first log",
                other.columns().join(", "),
                columns.join(", ")
            );
            return Err(Error::failed(message).in_file(&log.path));
        }
    }
    let weighed = request.logs.iter().filter(|log| request.mass_of(log).is_some()).count();
    if let Some(log) = request.logs.iter().find(|log| weighed > 0 && request.mass_of(log).is_none()) {
        let message = format!("has no mass, and others have; expected {}=KG", log.path.display());
        return Err(Error::usage(message).in_file(&log.path));
    }
    if weighed > 0 {
        if columns.iter().any(|name| name == MASS) {
            let message = format!("tells its mass ({MASS}); expected none where --mass is given");
            return Err(Error::usage(message).in_file(&request.logs[0].path));
        }
        columns.push(MASS.to_owned());
    }
    if request.logs.len() > 1 && !columns.iter().any(|name| name == RUN) {
        columns.push(RUN.to_owned());
    }
    Ok(columns)
}

/// Hands out the rows of all logs. Gives their number.
fn each_row(
    context: &Context,
    request: &Request<'_>,
    columns: &[String],
    take: &mut dyn FnMut(&[Cell]) -> Result<()>,
) -> Result<u64> {
    let several = request.logs.len() > 1;
    let mut progress = FileProgress::new(context, &paths(request.logs));
    let mut rows = 0;
    let mut row = Vec::with_capacity(columns.len());
    for (place, log) in request.logs.iter().enumerate() {
        let mut reader = TableReader::open(context, &log.path)?;
        let own_run = reader.columns().iter().position(|name| name == RUN);
        // Two logs of one name are two runs still.
        let name = log.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let name =
            if request.logs.iter().filter(|other| other.path.file_stem() == log.path.file_stem()).count() > 1
            {
                format!("{}-{name}", place + 1)
            } else {
                name
            };
        while reader.next_row(&mut row)? {
            row.extend(request.mass_of(log).map(Cell::Number));
            match own_run {
                Some(run) if several => {
                    if let Cell::Text(label) = &row[run] {
                        row[run] = Cell::Text(format!("{name}#{label}"));
                    }
                }
                None if several => row.push(Cell::Text(name.clone())),
                _ => {}
            }
            take(&row)?;
            rows += 1;
            if rows % 4096 == 0 {
                progress.at(reader.progress());
            }
        }
    }
    progress.finish();
    Ok(rows)
}

fn write_csv(to: &mut dyn Write, row: &[Cell]) -> io::Result<()> {
    for (place, cell) in row.iter().enumerate() {
        if place > 0 {
            to.write_all(b",")?;
        }
        match cell {
            Cell::Number(number) if number.is_nan() => {}
            Cell::Number(number) => write!(to, "{number}")?,
            Cell::Text(text) if text.contains([',', '"']) => write!(to, "\"{}\"", text.replace('"', "\"\""))?,
            Cell::Text(text) => to.write_all(text.as_bytes())?,
        }
    }
    to.write_all(b"\n")
}
