//! Batches of rows to and from whoever speaks Arrow, by its PyCapsule interface: without a copy,
//! and without a library of theirs.

use arrow_array::cast::AsArray as _;
use arrow_array::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow_array::types::Float64Type;
use arrow_array::{Array as _, RecordBatch, RecordBatchIterator, RecordBatchReader as _};
use logs::{TIME, Table};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use support::error::{Error, Result};

/// As the interface calls a stream of batches.
const STREAM: &std::ffi::CStr = c"arrow_array_stream";

/// Somebody's batches, not read yet.
pub(crate) struct Batches(RecordBatchStreamReader);

impl<'py> FromPyObject<'_, 'py> for Batches {
    type Error = PyErr;

    #[expect(unsafe_code, reason = "Arrow's C interface hands over a pointer")]
    fn extract(of: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let capsule = of.call_method0("__arrow_c_stream__")?.cast_into::<PyCapsule>()?;
        let stream = capsule.pointer_checked(Some(STREAM))?.cast();
        // SAFETY: a capsule of this name holds a stream, which is taken out of it; the
        // interpreter's lock is held, so that nobody else does.
        let batches = unsafe { RecordBatchStreamReader::from_raw(stream.as_ptr()) };
        batches.map(Self).map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

impl Batches {
    /// All rows, by their time.
    pub(crate) fn table(self) -> Result<Table> {
        let names: Vec<String> = self.0.schema().fields().iter().map(|field| field.name().clone()).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for batch in self.0 {
            let batch = batch.map_err(|error| Error::failed(error.to_string()))?;
            for ((column, of), name) in columns.iter_mut().zip(batch.columns()).zip(&names) {
                let Some(numbers) = of.as_primitive_opt::<Float64Type>() else {
                    let message = format!("is of type {}; expected float64", of.data_type());
                    return Err(Error::failed(message).in_column(name));
                };
                if numbers.null_count() == 0 {
                    column.extend_from_slice(numbers.values());
                } else {
                    column.extend(numbers.iter().map(|number| number.unwrap_or(f64::NAN)));
                }
            }
        }
        if let Some(time) = names.iter().position(|name| name == TIME) {
            sort(&mut columns, time);
        }
        Table::new(names, columns)
    }
}

/// By the numbers of one column; engines bring rows together in any order.
fn sort(columns: &mut [Vec<f64>], by: usize) {
    let key = &columns[by];
    if key.is_sorted() {
        return;
    }
    let mut order: Vec<usize> = (0..key.len()).collect();
    order.sort_by(|one, other| key[*one].total_cmp(&key[*other]));
    for column in columns {
        *column = order.iter().map(|row| column[*row]).collect();
    }
}

/// A batch of ours.
#[pyclass(frozen)]
pub(crate) struct Batch(pub(crate) RecordBatch);

#[pymethods]
impl Batch {
    /// The schema asked for is a wish, and columns are what they are.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let batches = RecordBatchIterator::new([Ok(self.0.clone())], self.0.schema());
        PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(batches)), STREAM)
    }
}
