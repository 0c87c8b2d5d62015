//! Means of cells of an axis with their bands: where a residual lies.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::page::{Drawn, axes, legend, range};
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
        let x = range(cells().flat_map(|cell| [cell.0, cell.1]), 0.0);
        let y = self.y_range.unwrap_or_else(|| {
            range(cells().flat_map(|cell| [cell.2 - cell.3, cell.2 + cell.3]).chain([0.0]), 0.08)
        });
        let mut chart = axes(area, &self.title, [&self.x_label, &self.y_label], x.0..x.1, y.0..y.1)?;
        let nought = PathElement::new(vec![(x.0, 0.0), (x.1, 0.0)], INK.stroke_width(1));
        chart.draw_series([nought])?;
        let within = |value: f64| value.clamp(y.0, y.1);
        for series in &self.series {
            let (fill, stroke) = (series.colour.mix(0.22).filled(), series.colour.stroke_width(3));
            let band = |&(from, to, mean, band): &(f64, f64, f64, f64)| {
                Rectangle::new([(from, within(mean - band)), (to, within(mean + band))], fill)
            };
            chart.draw_series(series.cells.iter().map(band))?;
            let mean = |&(from, to, mean, _): &(f64, f64, f64, f64)| {
                PathElement::new(vec![(from, within(mean)), (to, within(mean))], stroke)
            };
            chart.draw_series(series.cells.iter().map(mean))?.label(&series.name).legend(move |(x, y)| {
                EmptyElement::at((x, y))
                    + Rectangle::new([(0, -5), (22, 5)], fill)
                    + PathElement::new(vec![(0, 0), (22, 0)], stroke)
            });
        }
        legend(&mut chart, SeriesLabelPosition::UpperLeft, self.series.len())
    }
}
