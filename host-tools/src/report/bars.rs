//! Bars with names: scores of candidates, gaps of runs.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::page::{Drawn, bare_axes, legend, range, tick};
use super::style::{Colour, FONT, INK, LABEL_SIZE};

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

/// Pixels that the names of rows get.
const NAMES: u32 = 300;

/// Letters that fit there.
const LETTERS: usize = 40;

impl Bars {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let most = self.most.unwrap_or(f64::INFINITY);
        let values = self.rows.iter().flat_map(|(_, bars)| bars.iter().map(|bar| bar.1.min(most)));
        let values = values.chain(self.line.iter().map(|line| line.1)).chain([0.0]);
        let (low, high) = range(values, 0.05);
        let low = if low < 0.0 && high > 0.0 && low > -0.06 * high { 0.0 } else { low };
        let count = self.rows.len().max(1) as f64;
        let mut chart =
            bare_axes(area, &self.title, [&self.x_label, ""], low..high, 0.0..count, NAMES, [true, false])?;
        for (row, (name, bars)) in self.rows.iter().enumerate() {
            let middle = count - row as f64 - 0.5;
            let height = FILLED / bars.len().max(1) as f64;
            for (place, &(series, value)) in bars.iter().enumerate() {
                let top = middle + 0.5 * FILLED - place as f64 * height;
                let colour = self.series.get(series).map_or(INK, |series| series.1);
                if value.is_finite() {
                    let end = value.min(most);
                    let bar = Rectangle::new([(0.0, top - height), (end, top)], colour.filled());
                    chart.draw_series([bar])?;
                    if value > most {
                        let style = (FONT, LABEL_SIZE, &INK).into_text_style(area);
                        let style = style.pos(Pos::new(HPos::Right, VPos::Center));
                        let said =
                            Text::new(format!("cut, ends at {} →", tick(&value.round())), (-6, 0), style);
                        chart.draw_series([EmptyElement::at((end, top - 0.5 * height)) + said])?;
                    }
                }
            }
            let style =
                (FONT, LABEL_SIZE, &INK).into_text_style(area).pos(Pos::new(HPos::Right, VPos::Center));
            let label = EmptyElement::at((low, middle)) + Text::new(shortened(name), (-8, 0), style);
            chart.draw_series([label])?;
        }
        for (name, colour) in &self.series {
            let fill = colour.filled();
            chart
                .draw_series(std::iter::empty::<Rectangle<(f64, f64)>>())?
                .label(name)
                .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 22, y + 5)], fill));
        }
        if let Some((name, value)) = &self.line {
            let style = INK.stroke_width(2);
            chart
                .draw_series(DashedLineSeries::new([(*value, 0.0), (*value, count)], 8, 6, style))?
                .label(name)
                .legend(move |at| {
                    EmptyElement::at(at)
                        + PathElement::new(vec![(0, 0), (8, 0)], style)
                        + PathElement::new(vec![(14, 0), (22, 0)], style)
                });
        }
        legend(
            &mut chart,
            SeriesLabelPosition::LowerRight,
            self.series.len() + usize::from(self.line.is_some()),
        )
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
