//! Curves over time: measured and predicted power, mass with its interval, static states.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::decimate;
use super::page::{Drawn, axes, legend, range};
use super::style::Colour;

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Thin, half transparent: measured values with their noise.
    Faint,
    /// Two pixels wide.
    Solid,
    /// Dashes: a truth or a bound.
    Dashed,
}

/// One curve. A point whose y is NaN ends a piece; the next one starts another.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name in the legend; none if empty.
    pub name: String,
    /// Time, s, and value; time does not decrease.
    pub points: Vec<(f64, f64)>,
    /// Colour.
    pub colour: Colour,
    /// Look.
    pub stroke: Stroke,
}

/// An interval over time.
#[derive(Debug, Clone)]
pub struct Band {
    /// Name in the legend; none if empty.
    pub name: String,
    /// Time, s, lower and upper end; time does not decrease.
    pub points: Vec<(f64, f64, f64)>,
    /// Colour.
    pub colour: Colour,
}

/// Curves and bands over time.
#[derive(Debug, Clone, Default)]
pub struct TimeSeries {
    /// Title.
    pub title: String,
    /// What the y axis shows, with its unit.
    pub y_label: String,
    /// Lower and upper end of the y axis, instead of those of the values.
    pub y_range: Option<(f64, f64)>,
    /// Drawn first.
    pub bands: Vec<Band>,
    /// Drawn over the bands, the last one on top.
    pub lines: Vec<Line>,
}

impl TimeSeries {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let times = self.lines.iter().flat_map(|line| line.points.iter().map(|point| point.0));
        let x = range(
            times.chain(self.bands.iter().flat_map(|band| band.points.iter().map(|point| point.0))),
            0.0,
        );
        let x = if x.0 < x.1 { x } else { (x.0, x.0 + 1.0) };
        let values = self.lines.iter().flat_map(|line| line.points.iter().map(|point| point.1));
        let ends = self.bands.iter().flat_map(|band| band.points.iter().flat_map(|point| [point.1, point.2]));
        let y = self.y_range.unwrap_or_else(|| range(values.chain(ends), 0.05));

        let mut chart = axes(area, &self.title, ["time (s)", &self.y_label], x.0..x.1, y.0..y.1)?;

        let (width, _) = chart.plotting_area().dim_in_pixel();
        for band in &self.bands {
            let upper = band.points.iter().map(|&(t, _, high)| (t, high.clamp(y.0, y.1)));
            let lower = band.points.iter().rev().map(|&(t, low, _)| (t, low.clamp(y.0, y.1)));
            let fill = band.colour.mix(0.22).filled();
            for polygon in polygons(upper.collect(), lower.rev().collect()) {
                chart.draw_series(std::iter::once(Polygon::new(polygon, fill)))?;
            }
            if !band.name.is_empty() {
                let patch = move |(x, y)| Rectangle::new([(x, y - 5), (x + 22, y + 5)], fill);
                chart
                    .draw_series(std::iter::empty::<Rectangle<(f64, f64)>>())?
                    .label(&band.name)
                    .legend(patch);
            }
        }
        for line in &self.lines {
            let style = match line.stroke {
                Stroke::Faint => line.colour.mix(0.55).stroke_width(1),
                Stroke::Solid | Stroke::Dashed => line.colour.stroke_width(2),
            };
            for piece in decimate::pieces(&line.points, x, width as usize) {
                match line.stroke {
                    Stroke::Dashed => {
                        chart.draw_series(DashedLineSeries::new(piece, 8, 6, style))?;
                    }
                    Stroke::Faint | Stroke::Solid => {
                        chart.draw_series(LineSeries::new(piece, style))?;
                    }
                }
            }
            if !line.name.is_empty() {
                let dashed = line.stroke == Stroke::Dashed;
                let key = line.colour.stroke_width(2);
                chart.draw_series(std::iter::empty::<Rectangle<(f64, f64)>>())?.label(&line.name).legend(
                    move |at| {
                        let ends = if dashed { (9, 13) } else { (22, 22) };
                        EmptyElement::at(at)
                            + PathElement::new(vec![(0, 0), (ends.0, 0)], key)
                            + PathElement::new(vec![(ends.1, 0), (22, 0)], key)
                    },
                );
            }
        }
        let names = self.lines.iter().map(|line| &line.name).chain(self.bands.iter().map(|band| &band.name));
        legend(&mut chart, SeriesLabelPosition::UpperRight, names.filter(|name| !name.is_empty()).count())
    }
}

/// Polygons between two curves, split where either is not finite.
fn polygons(upper: Vec<(f64, f64)>, lower: Vec<(f64, f64)>) -> Vec<Vec<(f64, f64)>> {
    let pairs: Vec<_> = upper.into_iter().zip(lower).collect();
    pairs
        .split(|(high, low)| !high.1.is_finite() || !low.1.is_finite())
        .filter(|piece| piece.len() > 1)
        .map(|piece| {
            let over = piece.iter().map(|(high, _)| *high);
            over.chain(piece.iter().rev().map(|(_, low)| *low)).collect()
        })
        .collect()
}
