//! Logs as columns, and columns as logs. Numbers cross as the bytes of an array: the stable
//! interface has no more before Python 3.11.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use logs::{ColumnRequest, Header, RUN, Role, TIME};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use support::context::Context;
use support::error::{Error, Result};
use support::output;

use crate::command::stoppable;

/// Columns of a log as `gmr` reads it: their names, their numbers (f64, native order), the name of
/// each row's run where the log tells several (or else none), and what was left out.
type Columns<'py> = (Vec<String>, Vec<Bound<'py, PyBytes>>, Vec<String>, Vec<u32>, String);

/// Reads a log: every column of numbers.
#[pyfunction]
pub(crate) fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Columns<'_>> {
    let (table, _) = stoppable(py, move |context| Table::read(context, &path))?;
    let columns = table.columns.iter().map(|column| {
        let bytes: Vec<u8> = column.iter().flat_map(|value| value.to_ne_bytes()).collect();
        PyBytes::new(py, &bytes)
    });
    let columns = columns.collect();
    Ok((table.names, columns, table.run_names, table.runs, table.excluded))
}

/// Writes a log from columns of equal length: their names and numbers, and the name of each row's
/// run where there are any.
#[pyfunction]
pub(crate) fn write_log(
    py: Python<'_>,
    path: PathBuf,
    names: Vec<String>,
    columns: Vec<Vec<u8>>,
    runs: Option<Vec<String>>,
) -> PyResult<()> {
    let columns: Vec<Vec<f64>> = columns.iter().map(|bytes| numbers(bytes)).collect();
    let rows = columns.first().map_or(0, Vec::len);
    let lengths = columns.iter().map(Vec::len).chain(runs.as_ref().map(Vec::len));
    if names.len() != columns.len() || lengths.into_iter().any(|length| length != rows) {
        return Err(PyValueError::new_err("columns differ in length"));
    }
    stoppable(py, move |context| write(context, &path, &names, &columns, runs.as_deref())).map(|_| ())
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (values, _) = bytes.as_chunks();
    values.iter().map(|value| f64::from_ne_bytes(*value)).collect()
}

/// What a log holds.
struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    run_names: Vec<String>,
    /// The run of each row; empty where the log has one only.
    runs: Vec<u32>,
    excluded: String,
}

impl Table {
    fn read(context: &Context, path: &Path) -> Result<Self> {
        let header = Header::open(context, path)?;
        let names: Vec<String> =
            header.columns().iter().filter(|name| !name.is_empty() && *name != RUN).cloned().collect();
        let has_runs = header.has(RUN);
        let role = |name: &String| if name == TIME { Role::Time } else { Role::MaybeNumber };
        let mut requests: Vec<ColumnRequest> =
            names.iter().map(|name| ColumnRequest::required(name, role(name))).collect();
        requests.push(ColumnRequest::optional(RUN, Role::Run));
        let mut reader = header.read(&requests)?;
        let mut columns = vec![Vec::new(); names.len()];
        let mut runs = Vec::new();
        let mut row = vec![0.0; requests.len()];
        while reader.next_row(&mut row)?.is_some() {
            for (column, value) in columns.iter_mut().zip(&row) {
                column.push(*value);
            }
            if has_runs {
                runs.push(row[names.len()] as u32);
            }
        }
        let excluded = reader.exclusions().to_string();
        Ok(Self { names, columns, run_names: reader.run_names().to_vec(), runs, excluded })
    }
}

/// Numbers as short as they can be written so that reading gives them back; empty fields where
/// there is none.
fn write(
    context: &Context,
    path: &Path,
    names: &[String],
    columns: &[Vec<f64>],
    runs: Option<&[String]>,
) -> Result<()> {
    let failed = |error: std::io::Error| Error::io(path, &error);
    output::write_whole(path, |file| {
        let mut line = String::new();
        let header = names.iter().map(String::as_str).chain(runs.map(|_| RUN));
        push_fields(&mut line, header.map(quoted));
        file.write_all(line.as_bytes()).map_err(failed)?;
        for row in 0..columns.first().map_or(0, Vec::len) {
            if row.is_multiple_of(4096) {
                context.point();
            }
            line.clear();
            for (place, column) in columns.iter().enumerate() {
                if place > 0 {
                    line.push(',');
                }
                if !column[row].is_nan() {
                    // Writing to a String cannot fail.
                    let _ = write!(line, "{}", column[row]);
                }
            }
            if let Some(runs) = runs {
                line.push(',');
                line.push_str(&quoted(&runs[row]));
            }
            line.push('\n');
            file.write_all(line.as_bytes()).map_err(failed)?;
        }
        Ok(())
    })
}

fn push_fields(line: &mut String, fields: impl Iterator<Item = String>) {
    line.push_str(&fields.collect::<Vec<_>>().join(","));
    line.push('\n');
}

/// As RFC 4180 has it, where it must be.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
