//! Rows of numbers that a piece of text is.

use super::line::{Fault, Layout, parse_row, plain_row};
use super::run_numbers::{MOST_RUNS, Runs};

/// Rows of a piece of text: of its lines from the first on, one each.
#[derive(Default)]
pub(super) struct Rows {
    numbers: Vec<f64>,
    width: usize,
    /// Whether all that a row needs is finite.
    is_finite: Vec<bool>,
    /// Names of the runs, by the number that the rows have, and what they are called in the whole
    /// log, as far as rows were handed out.
    names: Vec<Vec<u8>>,
    ids: Vec<usize>,
    text: Vec<u8>,
    /// Bytes of the text that are these rows.
    bytes: usize,
}

impl Rows {
    /// Of this text, in the memory of others.
    pub(super) fn of(mut self, text: Vec<u8>, layout: &Layout) -> Self {
        self.numbers.clear();
        self.is_finite.clear();
        self.ids.clear();
        self.width = layout.width;
        let mut runs = Runs::default();
        let mut rest = &text[..];
        while !rest.is_empty() {
            let start = self.numbers.len();
            self.numbers.resize(start + layout.width, f64::NAN);
            let row = &mut self.numbers[start..];
            if let Some(length) = layout.plain.as_ref().and_then(|slots| plain_row(rest, slots, row)) {
                self.is_finite.push(true);
                rest = &rest[length..];
                continue;
            }
            let end = memchr::memchr(b'\n', rest);
            let read = end.and_then(|end| {
                row.fill(f64::NAN);
                let line = rest[..end].strip_suffix(b"\r").unwrap_or(&rest[..end]);
                let finite = parse_row(line, &layout.wanted, layout.columns, &mut runs, row).ok()?;
                Some((finite, end + 1))
            });
            let Some((finite, length)) = read else {
                self.numbers.truncate(start);
                break;
            };
            self.is_finite.push(finite);
            rest = &rest[length..];
        }
        self.bytes = text.len() - rest.len();
        self.text = text;
        self.names = runs.into_written();
        self
    }

    pub(super) fn len(&self) -> usize {
        self.is_finite.len()
    }

    pub(super) fn bytes(&self) -> usize {
        self.bytes
    }

    /// Whether all of its text is rows.
    pub(super) fn is_whole(&self) -> bool {
        self.bytes == self.text.len()
    }

    /// A row; its run by the number that it has in the whole log.
    #[inline]
    pub(super) fn take(
        &mut self,
        place: usize,
        layout: &Layout,
        runs: &mut Runs,
        values: &mut [f64],
    ) -> Result<bool, Fault> {
        let start = place * self.width;
        values[..self.width].copy_from_slice(&self.numbers[start..start + self.width]);
        if let Some(slot) = layout.run_slot {
            let here = values[slot] as usize;
            if here == self.ids.len() {
                self.ids.push(runs.id(&self.names[here]));
            }
            if self.ids[here] >= MOST_RUNS {
                return Err(Fault::Runs);
            }
            values[slot] = self.ids[here] as f64;
        }
        Ok(self.is_finite[place])
    }

    /// The memory of its text.
    pub(super) fn take_text(&mut self) -> Vec<u8> {
        self.bytes = 0;
        std::mem::take(&mut self.text)
    }

    /// What of its text is no row.
    pub(super) fn into_rest(mut self) -> Vec<u8> {
        self.text.split_off(self.bytes)
    }

    /// All of its text.
    pub(super) fn into_text(self) -> Vec<u8> {
        self.text
    }
}
