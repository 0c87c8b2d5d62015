//! A table as text: columns as wide as their widest cell.

use std::fmt::{self, Write as _};

use super::{Mark, Table};

pub(super) fn render(table: &Table, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(f, "{}", table.title)?;
    if table.rows.is_empty() {
        writeln!(f, "  none")?;
    } else {
        let columns: Vec<_> = table.columns().collect();
        let widths: Vec<usize> = columns
            .iter()
            .enumerate()
            .map(|(place, (name, _))| {
                let cells = table.rows.iter().filter_map(|row| row.cells.get(place));
                cells.map(|cell| letters(cell)).chain([letters(name)]).max().unwrap_or(0)
            })
            .collect();
        let mut line = |cells: &mut dyn Iterator<Item = &str>, mark: char| {
            let mut text = String::new();
            for ((cell, width), (_, right)) in cells.zip(&widths).zip(&columns) {
                let padding = " ".repeat(width.saturating_sub(letters(cell)));
                if *right { write!(text, "  {padding}{cell}")? } else { write!(text, "  {cell}{padding}")? }
            }
            writeln!(f, "{mark}{}", text.trim_end().strip_prefix(' ').unwrap_or(""))
        };
        line(&mut columns.iter().map(|(name, _)| *name), ' ')?;
        for row in &table.rows {
            let mark = match row.mark {
                Mark::None => ' ',
                Mark::Ours => '*',
                Mark::Against => '!',
            };
            line(&mut row.cells.iter().map(String::as_str), mark)?;
        }
    }
    if !table.note.is_empty() {
        writeln!(f, "  ({})", table.note)?;
    }
    Ok(())
}

fn letters(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::super::{Mark, Row, Table};

    #[test]
    fn columns_line_up_whatever_the_letters() {
        let row = |a: &str, b: &str, mark| Row { cells: vec![a.to_owned(), b.to_owned()], mark };
        let table = Table {
            name: "t",
            title: "Title".to_owned(),
            head: vec!["name", "#R²"],
            rows: vec![row("é", "1.00", Mark::Ours), row("longer", "–", Mark::Against)],
            note: "why".to_owned(),
        };
        assert_eq!(table.to_string(), "Title\n  name      R²\n* é       1.00\n! longer     –\n  (why)\n");
        assert_eq!(Table { rows: Vec::new(), note: String::new(), ..table }.to_string(), "Title\n  none\n");
    }
}
