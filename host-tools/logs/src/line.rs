//! The numbers of a line of text.

use super::reader::Role;
use super::run_numbers::{MOST_RUNS, Runs};
use super::scan;

/// What is taken of a line.
#[derive(Clone)]
pub(super) struct Layout {
    /// One entry a column, up to the last one that is wanted.
    pub wanted: Vec<Option<Wanted>>,
    /// The slot of each column, if all are wanted and hold numbers: rows of plain numbers are then
    /// read in one go.
    pub plain: Option<Vec<usize>>,
    /// Columns of the log.
    pub columns: usize,
    /// Numbers of a row.
    pub width: usize,
    pub run_slot: Option<usize>,
}

/// What to do with the field at one position of a line.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    pub slot: usize,
    pub role: Role,
}

/// Why a line is no row.
pub(super) enum Fault {
    Text { field: usize },
    FieldCount,
    Runs,
}

/// Reads a line of plain numbers into the slots of its columns; its length with the line feed.
/// `None` for any other line, faulty or not: [`parse_row`] knows what to do with it.
#[inline]
pub(super) fn plain_row(text: &[u8], slots: &[usize], values: &mut [f64]) -> Option<usize> {
    let mut rest = text;
    let (last, others) = slots.split_last()?;
    for (slot, end) in others.iter().map(|slot| (slot, b',')).chain([(last, b'\n')]) {
        let (value, length) = scan::plain_number(rest)?;
        if rest.get(length) != Some(&end) {
            return None;
        }
        values[*slot] = value;
        rest = &rest[length + 1..];
    }
    Some(text.len() - rest.len())
}

/// Parses the wanted fields of a line; whether all that are needed are finite.
#[inline]
pub(super) fn parse_row(
    line: &[u8],
    wanted: &[Option<Wanted>],
    columns: usize,
    runs: &mut Runs,
    values: &mut [f64],
) -> Result<bool, Fault> {
    let mut finite = true;
    let mut rest = line;
    for (field, wanted) in wanted.iter().enumerate() {
        let length = match wanted {
            None => scan::field_length(rest),
            Some(Wanted { slot, role: Role::Run }) => {
                let length = scan::field_length(rest);
                let run = runs.id(&scan::unquote(rest[..length].trim_ascii()));
                if run >= MOST_RUNS {
                    return Err(Fault::Runs);
                }
                values[*slot] = run as f64;
                length
            }
            Some(Wanted { slot, role }) => {
                let (value, length) = match scan::plain_field(rest) {
                    Some(number) => number,
                    None => {
                        let length = scan::field_length(rest);
                        let value = scan::number_in_field(&rest[..length]).ok_or(Fault::Text { field })?;
                        (value, length)
                    }
                };
                finite &= value.is_finite() || *role == Role::MaybeNumber;
                values[*slot] = value;
                length
            }
        };
        if length == rest.len() {
            return if field + 1 == columns { Ok(finite) } else { Err(Fault::FieldCount) };
        }
        rest = &rest[length + 1..];
    }
    let unread = columns - wanted.len();
    if unread > 0 && scan::Fields::new(rest).count() == unread { Ok(finite) } else { Err(Fault::FieldCount) }
}
