//! Fields of a row, rows of a column, and who takes rows.

use crate::error::Result;

/// A field of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number; NaN where the row has none.
    Number(f64),
    /// A text.
    Text(String),
}

impl Cell {
    /// Whether the row has it.
    pub(crate) fn is_there(&self) -> bool {
        !matches!(self, Self::Number(number) if number.is_nan())
    }

    /// As a number; NaN for what is none.
    pub(crate) fn number(&self) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Text(text) => text.trim().parse().unwrap_or(f64::NAN),
        }
    }

    /// As a text.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

/// Some rows of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// NaN where a row has none.
    Numbers(Vec<f64>),
    /// None where a row has none.
    Texts(Vec<Option<String>>),
    /// Nobody asked for it.
    Unread,
}

impl Values {
    #[cfg(feature = "every-format")]
    pub(crate) fn len(&self) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Texts(texts) => Some(texts.len()),
            Self::Unread => None,
        }
    }
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
