//! Sums of columns in memory, and sums as columns: what an engine of many machines needs.

use std::path::PathBuf;

use fit::run_gram::{Flat, Merge, TEXTS, names, write_all};
use host_tools::cli;
use logs::Table;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use support::context::Context;
use support::error::Result;

use crate::command::stoppable;
use crate::table::numbers;

/// Columns of sums: those of text, then those of numbers with what becomes of each when runs are
/// added up (`sum`, `min`, `max`).
#[pyfunction]
pub(crate) fn gram_columns() -> (Vec<String>, Vec<(String, String)>) {
    let merge = |merge: Merge| match merge {
        Merge::Sum => "sum",
        Merge::Min => "min",
        Merge::Max => "max",
    };
    let numbers = names().iter().map(|column| (column.name.clone(), merge(column.merge).to_owned()));
    (TEXTS.map(str::to_owned).to_vec(), numbers.collect())
}

/// The sums of columns, as `gmr gram` with these arguments would make them of a log: a row a run,
/// its texts and numbers.
#[pyfunction]
pub(crate) fn gram_of_columns(
    py: Python<'_>,
    arguments: Vec<String>,
    column_names: Vec<String>,
    columns: Vec<Vec<u8>>,
    runs: Option<Vec<String>>,
) -> PyResult<Vec<(Vec<String>, Vec<f64>)>> {
    let columns: Vec<Vec<f64>> = columns.iter().map(|bytes| numbers(bytes)).collect();
    let work = move |context: &Context| {
        let table = Table::new(column_names, columns, runs)?;
        let rows = cli::gram_of_table(context, &arguments, table)?;
        rows.iter().map(|run| Flat::of(run).map(|flat| (flat.texts.to_vec(), flat.numbers))).collect()
    };
    stoppable(py, work).map(|(rows, _)| rows)
}

/// Writes rows of sums as a file for `gmr fit --grams`.
#[pyfunction]
pub(crate) fn write_grams(py: Python<'_>, path: PathBuf, rows: Vec<(Vec<String>, Vec<f64>)>) -> PyResult<()> {
    let flat = |(texts, numbers): (Vec<String>, Vec<f64>)| match (<[String; 4]>::try_from(texts), numbers) {
        (Ok(texts), numbers) if numbers.len() == names().len() => Ok(Flat { texts, numbers }),
        _ => {
            Err(PyValueError::new_err("rows of another number of columns; expected those of gram_columns()"))
        }
    };
    let rows = rows.into_iter().map(flat).collect::<PyResult<Vec<Flat>>>()?;
    let work = move |_: &Context| {
        let grams = rows.iter().map(Flat::gram).collect::<Result<Vec<_>>>()?;
        write_all(&path, &grams)
    };
    stoppable(py, work).map(|_| ())
}
