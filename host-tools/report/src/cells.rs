//! Means of cells of an axis with their bands: where a residual lies.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::Axis;
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::style::{Colour, INK};

/// One set of cells.
#[derive(Debug, Clone)]
pub struct CellSeries {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// From, to, mean, and half of the interval.
    pub cells: Vec<(f64, f64, f64, f64)>,
}

/// Cells of one axis, in several sets.
#[derive(Debug, Clone)]
pub struct Cells {
    /// Title.
    pub title: String,
    /// What the axis shows, with its unit.
    pub x_label: String,
    /// What the means show, with its unit.
    pub y_label: String,
    /// Lower and upper end of the y axis, so that several figures compare.
    pub y_range: Option<(f64, f64)>,
    /// The sets.
    pub series: Vec<CellSeries>,
}

impl Cells {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let cells = || self.series.iter().flat_map(|series| &series.cells);
        let x = Axis::over(cells().flat_map(|cell| [cell.0, cell.1]), 0.0);
        let y = match self.y_range {
            Some((low, high)) => Axis::to_ticks(low, high),
            None => {
                Axis::over(cells().flat_map(|cell| [cell.2 - cell.3, cell.2 + cell.3]).chain([0.0]), 0.08)
            }
        };
        let ends = (x.from, x.to);
        let style = |series: &CellSeries| (series.colour.mix(0.22).filled(), series.colour.stroke_width(3));
        let keys = self.series.iter().map(|series| (series.name.as_str(), Key::Line(style(series).1)));
        let keys = keys.collect();
        let labels = [self.x_label.as_str(), self.y_label.as_str()];
        let mut chart =
            Frame { title: &self.title, labels, x, y, keys, y_area: NUMBERS, grid: true }.draw(area)?;
        chart.line(&[(ends.0, 0.0), (ends.1, 0.0)], INK.stroke_width(1))?;
        for series in &self.series {
            let (fill, stroke) = style(series);
            for &(from, to, mean, band) in &series.cells {
                chart.bar((from, mean - band), (to, mean + band), fill)?;
            }
            for &(from, to, mean, _) in &series.cells {
                chart.line(&[(from, mean), (to, mean)], stroke)?;
            }
        }
        Ok(())
    }
}
