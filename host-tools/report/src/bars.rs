//! Bars with names: scores of candidates, gaps of runs.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::axis::Axis;
use super::chart::{Drawn, Frame, Key};
use super::style::{Colour, INK, LABEL_SIZE};

/// Horizontal bars, the first row on top.
#[derive(Debug, Clone, Default)]
pub struct Bars {
    /// Title.
    pub title: String,
    /// What the bars show, with its unit.
    pub x_label: String,
    /// Names and colours of the series.
    pub series: Vec<(String, Colour)>,
    /// Name of each row, and its bars: place of the series, and value, from 0 on.
    pub rows: Vec<(String, Vec<(usize, f64)>)>,
    /// A value that all rows are held against, with its name.
    pub line: Option<(String, f64)>,
    /// Bars end here at the latest; those that are cut say their value.
    pub most: Option<f64>,
}

/// Share of a row that its bars fill.
const FILLED: f64 = 0.76;

/// Pixels that a letter of a row's name gets, and what stands around the name.
const LETTER: f64 = 7.5;
const AROUND: f64 = 24.0;

/// Letters that fit there.
const LETTERS: usize = 40;

impl Bars {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let most = self.most.unwrap_or(f64::INFINITY);
        let values = self.rows.iter().flat_map(|(_, bars)| bars.iter().map(|bar| bar.1.min(most)));
        let x = Axis::over(values.chain(self.line.iter().map(|line| line.1)).chain([0.0]), 0.0);
        let low = x.from;
        let count = self.rows.len().max(1) as f64;
        let rule = INK.stroke_width(2);
        let line = self.line.iter().map(|(name, _)| (name.as_str(), Key::Dashes(rule)));
        let series = self.series.iter().map(|(name, colour)| (name.as_str(), Key::Patch(colour.filled())));
        let keys = series.chain(line).collect();
        let y = Axis::bare(0.0, count);
        let labels = [self.x_label.as_str(), ""];
        let longest = self.rows.iter().map(|(name, _)| name.chars().count().min(LETTERS)).max();
        let y_area = (AROUND + LETTER * longest.unwrap_or(0) as f64) as u32;
        let mut chart = Frame { title: &self.title, labels, x, y, keys, y_area, grid: true }.draw(area)?;
        for (row, (name, bars)) in self.rows.iter().enumerate() {
            let middle = count - row as f64 - 0.5;
            let height = FILLED / bars.len().max(1) as f64;
            for (place, &(series, value)) in bars.iter().enumerate().filter(|(_, bar)| bar.1.is_finite()) {
                let top = middle + 0.5 * FILLED - place as f64 * height;
                let colour = self.series.get(series).map_or(INK, |series| series.1);
                let end = value.min(most);
                chart.bar((0.0, top - height), (end, top), colour.filled())?;
                if value > most {
                    let said = format!("cut, ends at {} →", value.round());
                    chart.text((end, top - 0.5 * height), -6, HPos::Right, LABEL_SIZE, said)?;
                }
            }
            chart.text((low, middle), -8, HPos::Right, LABEL_SIZE, shortened(name))?;
        }
        match &self.line {
            Some((_, value)) => chart.dashes(&[(*value, 0.0), (*value, count)], rule),
            None => Ok(()),
        }
    }
}

/// The end of a name tells more than its beginning.
fn shortened(name: &str) -> String {
    let letters = name.chars().count();
    if letters <= LETTERS {
        return name.to_owned();
    }
    std::iter::once('…').chain(name.chars().skip(letters - LETTERS + 1)).collect()
}
