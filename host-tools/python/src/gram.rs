//! Sums of logs and of rows in memory, and sums as columns: what an engine of many machines needs.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use fit::run_gram::{Flat, Merge, RunGram, TEXTS, names, write_all};
use host_tools::cli;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use support::context::Context;
use support::error::{Error, Result};

use crate::batches::{Batch, Batches};
use crate::command::{on_one_core, stoppable};

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

/// How `gmr gram` with these arguments sums up, for all logs that a worker is given.
#[pyclass(frozen)]
pub(crate) struct Sums(Arc<cli::Sums>);

#[pymethods]
impl Sums {
    #[new]
    fn new(py: Python<'_>, arguments: Vec<String>) -> PyResult<Self> {
        let (sums, _) = stoppable(py, move |context| cli::sums(context, &arguments))?;
        Ok(Self(Arc::new(sums)))
    }

    /// Of logs, read where they lie: a row a run, grouped by what each log has of these keys.
    fn of_logs(
        &self,
        py: Python<'_>,
        logs: Vec<PathBuf>,
        keys: Vec<String>,
        values: Vec<Vec<String>>,
    ) -> PyResult<Batch> {
        let sums = Arc::clone(&self.0);
        let work = move |context: &Context| {
            let mut runs = Vec::with_capacity(logs.len());
            for (log, values) in logs.iter().zip(values) {
                runs.push((sums.of_log(context, log)?, values));
            }
            rows(&keys, runs)
        };
        on_one_core(py, work).map(|(rows, _)| Batch(rows))
    }

    /// The same of a run's rows in whatever order: a stream of batches, whose columns are all of
    /// float64.
    fn of_rows(
        &self,
        py: Python<'_>,
        name: PathBuf,
        batches: Batches,
        keys: Vec<String>,
        values: Vec<String>,
    ) -> PyResult<Batch> {
        let sums = Arc::clone(&self.0);
        let work = move |context: &Context| {
            rows(&keys, vec![(sums.of_table(context, &name, batches.table()?)?, values)])
        };
        on_one_core(py, work).map(|(rows, _)| Batch(rows))
    }
}

/// Columns of the keys, then those of [`gram_columns`]; of runs by the log, with its keys' values.
fn rows(keys: &[String], logs: Vec<(Vec<RunGram>, Vec<String>)>) -> Result<RecordBatch> {
    let mut rows = Vec::with_capacity(logs.len());
    for (runs, values) in logs {
        for mut run in runs {
            run.keys = keys.iter().cloned().zip(values.iter().cloned()).collect();
            rows.push((Flat::of(&run)?, run.keys));
        }
    }
    let keys = keys.iter().map(|key| {
        let column: StringArray = rows.iter().map(|(_, keys)| keys.get(key)).collect();
        (key.as_str(), Arc::new(column) as ArrayRef)
    });
    let texts = TEXTS.iter().enumerate().map(|(place, name)| {
        let column = StringArray::from_iter_values(rows.iter().map(|(row, _)| &row.texts[place]));
        (*name, Arc::new(column) as ArrayRef)
    });
    let numbers = names().iter().enumerate().map(|(place, column)| {
        let numbers = Float64Array::from_iter_values(rows.iter().map(|(row, _)| row.numbers[place]));
        (column.name.as_str(), Arc::new(numbers) as ArrayRef)
    });
    let columns = keys.chain(texts).chain(numbers).map(|(name, column)| (name, column, true));
    RecordBatch::try_from_iter_with_nullable(columns).map_err(|error| Error::failed(error.to_string()))
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
    on_one_core(py, work).map(|_| ())
}
