//! Fields of a row, and who takes rows.

use crate::error::Result;

/// A field of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number; NaN where the row has none.
    Number(f64),
    /// A text.
    Text(String),
}

/// Hands out the columns first, then each row.
pub trait Taker {
    /// Gets the columns' names, once.
    ///
    /// # Errors
    /// Its own.
    fn columns(&mut self, columns: &[String]) -> Result<()>;
    /// Gets a row.
    ///
    /// # Errors
    /// Its own.
    fn row(&mut self, row: &[Cell]) -> Result<()>;
}
