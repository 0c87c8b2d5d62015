//! The recorder's lines as rows, for what takes rows.

use log_formats::table::Cell;

/// Columns that a header names.
pub(super) fn names(header: &str) -> Vec<String> {
    header.split(',').map(str::to_owned).collect()
}

/// Numbers of a line. What is not known is empty.
pub(super) fn cells(line: &str) -> Vec<Cell> {
    line.split(',').map(|field| Cell::Number(field.parse().unwrap_or(f64::NAN))).collect()
}
