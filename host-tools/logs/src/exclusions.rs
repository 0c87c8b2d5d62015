//! What was left out of a log, and why: stated, never silent.

use std::fmt;

/// Rows left out so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Exclusions {
    /// 1 if the last line has no line end: the file was cut there, so even its whole fields may be
    /// short.
    pub cut_line: u64,
    /// Rows with an empty, NaN or infinite value in a column that was needed.
    pub non_finite: u64,
    /// Line of the first such row.
    pub first_non_finite_line: Option<u64>,
}

impl Exclusions {
    /// Rows left out in all.
    pub fn total(&self) -> u64 {
        self.cut_line + self.non_finite
    }

    pub fn add_non_finite(&mut self, line: u64) {
        self.non_finite += 1;
        self.first_non_finite_line.get_or_insert(line);
    }
}

/// One line for people, for example
/// `excluded 3 rows with NaN, inf or no value (first: line 17) and 1 cut last line`.
impl fmt::Display for Exclusions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.total() == 0 {
            return write!(f, "nothing excluded");
        }
        write!(f, "excluded ")?;
        if let Some(line) = self.first_non_finite_line {
            let rows = if self.non_finite == 1 { "row" } else { "rows" };
            write!(f, "{} {rows} with NaN, inf or no value (first: line {line})", self.non_finite)?;
        }
        if self.cut_line > 0 {
            let and = if self.non_finite > 0 { " and " } else { "" };
            write!(f, "{and}1 last line without a line end (the file was cut there)")?;
        }
        Ok(())
    }
}
