//! Errors as Python's exceptions.

use board::flasher::NotForBoards;
use pyo3::prelude::*;
use support::error::Error;

/// `wheelwatt.Error`, or `wheelwatt.NotForBoards`: the message, and where.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let class = if error.cause::<NotForBoards>().is_some() { "NotForBoards" } else { "Error" };
    let made = || {
        let file = error.file().map(|file| file.display().to_string());
        let place = (error.message(), file, error.line(), error.column(), error.exit_code());
        py.import("wheelwatt._error")?.getattr(class)?.call1(place)
    };
    made().map_or_else(|failed| failed, PyErr::from_value)
}
