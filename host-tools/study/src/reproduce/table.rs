//! Tables as data: columns with a key, a head and a format, and rows of values. One renderer makes
//! text of them, one JSON; the third, to markup, is the page's.

use std::fmt::{self, Write as _};

use serde_json::{Map, Value, json};

use super::spread::Spread;

/// One table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    /// Its short name: an anchor in the page.
    pub(super) name: &'static str,
    /// What it holds.
    pub(super) title: &'static str,
    /// The columns.
    pub(super) columns: &'static [Column],
    /// The rows.
    pub(super) rows: Vec<Row>,
    /// What a reader has to know.
    pub(super) note: String,
}

/// One column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Column {
    /// Its name in JSON; without one it is not in JSON.
    pub(super) key: &'static str,
    /// Its head, with its unit; without one it is in JSON only.
    pub(super) head: &'static str,
    /// How its values look.
    pub(super) format: Format,
}

/// How values look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    /// Words, set left; all else is set right.
    Words,
    /// As the cell says.
    AsShown,
    /// A number with so many digits.
    Number(usize),
    /// `mean [low, high]` of what may be anything.
    Spread(usize),
    /// The same of what is not below 0: errors, times, rates.
    Error(usize),
    /// The same of what is from 0 to 100 %.
    Share(usize),
    /// The same of what is not above 1.
    R2(usize),
}

/// One value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    /// Words.
    Words(String),
    /// A number.
    Number(f64),
    /// A figure over seeds.
    Over(Spread),
    /// A value, and how it looks.
    Shown(Value, String),
}

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    /// One a column.
    pub(super) cells: Vec<Cell>,
    /// How it is marked.
    pub(super) mark: Mark,
}

/// What stands out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    /// Nothing.
    None,
    /// Ours.
    Ours,
    /// Better than ours, or a goal missed.
    Against,
    /// Somebody else's figures: they are not in JSON.
    Published,
}

/// A column of a table.
pub(super) const fn column(key: &'static str, head: &'static str, format: Format) -> Column {
    Column { key, head, format }
}

impl From<&str> for Cell {
    fn from(words: &str) -> Self {
        Self::Words(words.to_owned())
    }
}

impl From<String> for Cell {
    fn from(words: String) -> Self {
        Self::Words(words)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Spread> for Cell {
    fn from(spread: Spread) -> Self {
        Self::Over(spread)
    }
}

impl Cell {
    /// A value that looks so.
    pub(super) fn shown(value: impl Into<Value>, text: impl Into<String>) -> Self {
        Self::Shown(value.into(), text.into())
    }

    fn json(&self) -> Value {
        match self {
            Self::Words(words) => json!(words),
            Self::Number(value) => json!(value),
            Self::Over(spread) => json!(spread),
            Self::Shown(value, _) => value.clone(),
        }
    }

    fn text(&self, format: Format) -> String {
        match (self, format) {
            (Self::Words(text) | Self::Shown(_, text), _) => text.clone(),
            (Self::Over(spread), format) => spread.text(format),
            (Self::Number(value), Format::Number(digits)) => number(*value, digits),
            (Self::Number(value), _) => value.to_string(),
        }
    }
}

impl Spread {
    /// In this format, within the limits of its figure; a dash for an unknown one.
    pub(super) fn text(&self, format: Format) -> String {
        let (digits, least, most) = match format {
            Format::Error(digits) => (digits, 0.0, f64::INFINITY),
            Format::Share(digits) => (digits, 0.0, 100.0),
            Format::R2(digits) => (digits, f64::NEG_INFINITY, 1.0),
            Format::Spread(digits) | Format::Number(digits) => (digits, f64::NEG_INFINITY, f64::INFINITY),
            Format::Words | Format::AsShown => (3, f64::NEG_INFINITY, f64::INFINITY),
        };
        let mean = number(self.mean, digits);
        if !(self.low.is_finite() && self.high.is_finite()) {
            return mean;
        }
        let [low, high] = [self.low.max(least), self.high.min(most)].map(|end| number(end, digits));
        format!("{mean} [{low}, {high}]")
    }

    /// Of an error in its unit, or of R², which has none.
    pub(super) fn figure(&self, unit: &str, digits: usize) -> String {
        with_unit(self.text(if unit.is_empty() { Format::R2(digits) } else { Format::Error(digits) }), unit)
    }
}

impl Row {
    /// A row of these cells.
    pub(super) fn new(mark: Mark, cells: impl IntoIterator<Item = Cell>) -> Self {
        Self { cells: cells.into_iter().collect(), mark }
    }
}

impl Table {
    /// Heads of the columns that show, and whether they are set right.
    pub(super) fn heads(&self) -> impl Iterator<Item = (&'static str, bool)> {
        self.shown().map(|(_, column)| (column.head, column.format != Format::Words))
    }

    /// What a row shows.
    pub(super) fn texts<'a>(&'a self, row: &'a Row) -> impl Iterator<Item = String> + 'a {
        self.shown().filter_map(|(place, column)| Some(row.cells.get(place)?.text(column.format)))
    }

    fn shown(&self) -> impl Iterator<Item = (usize, &'static Column)> {
        self.columns.iter().enumerate().filter(|(_, column)| !column.head.is_empty())
    }

    /// An object a row.
    pub(super) fn json(&self) -> Value {
        let object = |row: &Row| {
            let cells = self.columns.iter().zip(&row.cells).filter(|(column, _)| !column.key.is_empty());
            Value::Object(
                cells.map(|(column, cell)| (column.key.to_owned(), cell.json())).collect::<Map<_, _>>(),
            )
        };
        self.rows.iter().filter(|row| row.mark != Mark::Published).map(object).collect()
    }
}

/// As text: columns as wide as their widest cell.
impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        let heads: Vec<_> = self.heads().collect();
        let head = heads.iter().map(|(head, _)| (*head).to_owned()).collect();
        let mut lines: Vec<(char, Vec<String>)> = vec![(' ', head)];
        lines.extend(self.rows.iter().map(|row| {
            let mark = match row.mark {
                Mark::None | Mark::Published => ' ',
                Mark::Ours => '*',
                Mark::Against => '!',
            };
            (mark, self.texts(row).collect())
        }));
        let letters = |text: &String| text.chars().count();
        let width = |place: usize| lines.iter().filter_map(|(_, cells)| cells.get(place)).map(letters).max();
        let widths: Vec<usize> = (0..heads.len()).map(|place| width(place).unwrap_or(0)).collect();
        if self.rows.is_empty() {
            writeln!(f, "  none")?;
            lines.clear();
        }
        for (mark, cells) in &lines {
            let mut text = String::new();
            for ((cell, width), (_, right)) in cells.iter().zip(&widths).zip(&heads) {
                let padding = " ".repeat(width - letters(cell));
                if *right { write!(text, "  {padding}{cell}")? } else { write!(text, "  {cell}{padding}")? }
            }
            writeln!(f, "{mark}{}", text.trim_end().strip_prefix(' ').unwrap_or(""))?;
        }
        if self.note.is_empty() { Ok(()) } else { writeln!(f, "  ({})", self.note) }
    }
}

/// Each value once, in order of appearance.
pub(super) fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut known, value| {
        if !known.contains(&value) {
            known.push(value);
        }
        known
    })
}

/// A number with so many digits; a dash where it is none.
pub(super) fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{value:.digits$}");
    // Rounded to zero from below.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// A number with its unit.
pub(super) fn with_unit(text: String, unit: &str) -> String {
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two values: ± 12.7062 · half their distance. 1 and 2: −4.85 … 7.85; 60 and 100: −174 … 334;
    /// 0.9 and 1.0: 0.315 … 1.585.
    #[test]
    fn an_interval_is_shown_as_far_as_its_figure_can_be() {
        let text = |values: &[f64], format| Spread::over(values).text(format);
        assert_eq!(text(&[1.0, 2.0], Format::Error(2)), "1.50 [0.00, 7.85]");
        assert_eq!(text(&[60.0, 100.0], Format::Share(0)), "80 [0, 100]");
        assert_eq!(text(&[0.9, 1.0], Format::R2(3)), "0.950 [0.315, 1.000]");
        assert_eq!(text(&[-1.0, -2.0], Format::R2(2)), "-1.50 [-7.85, 1.00]");
        assert_eq!(text(&[1.0], Format::Error(1)), "1.0", "one seed has no interval");
        assert_eq!(text(&[1.0], Format::R2(1)), "1.0", "one seed has no interval");
        assert_eq!(text(&[1.0], Format::Spread(1)), "1.0");
        // Mean 1.5, s = 0.7071, t₀.₉₇₅(1) = 12.7062: ± 12.7062 · 0.5.
        assert_eq!(text(&[1.0, 2.0], Format::Spread(2)), "1.50 [-4.85, 7.85]");
    }

    #[test]
    fn numbers_have_fixed_digits_and_no_negative_zero() {
        assert_eq!(number(-0.001, 2), "0.00");
        assert_eq!(number(-0.005_1, 2), "-0.01");
        assert_eq!(number(f64::NAN, 2), "–");
    }

    const COLUMNS: [Column; 3] = [
        column("name", "name", Format::Words),
        column("", "R²", Format::Number(2)),
        column("r2", "", Format::Number(0)),
    ];

    fn table() -> Table {
        let row = |name: &str, r2: f64, mark| Row::new(mark, [name.into(), r2.into(), r2.into()]);
        let rows = vec![row("é", 1.0, Mark::Ours), row("longer", f64::NAN, Mark::Against)];
        Table { name: "t", title: "Title", columns: &COLUMNS, rows, note: "why".to_owned() }
    }

    #[test]
    fn columns_line_up_whatever_the_letters() {
        assert_eq!(table().to_string(), "Title\n  name      R²\n* é       1.00\n! longer     –\n  (why)\n");
        let empty = Table { rows: Vec::new(), note: String::new(), ..table() };
        assert_eq!(empty.to_string(), "Title\n  none\n");
    }

    #[test]
    fn json_has_the_keys_and_no_figures_of_others() {
        let mut table = table();
        table.rows.push(Row::new(Mark::Published, ["theirs".into(), 0.5.into(), 0.5.into()]));
        assert_eq!(table.json(), json!([{ "name": "é", "r2": 1.0 }, { "name": "longer", "r2": null }]));
        assert!(table.to_string().contains("theirs"));
    }
}
