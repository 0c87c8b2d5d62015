//! Curves over time: measured and predicted power, mass with its interval, static states.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::{Axis, range};
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::decimate;
use super::style::Colour;

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    /// Thin, half transparent: measured values with their noise.
    Faint,
    /// Thin: a prediction over what was measured, which stays visible on both sides.
    Thin,
    /// Two pixels wide.
    Solid,
    /// Dashes: a truth or a bound.
    Dashed,
}

/// One curve. A point whose y is NaN ends a piece; the next one starts a new piece.
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

impl Line {
    /// Through these values at these times, s.
    pub fn over(name: &str, time_s: &[f64], values: &[f64], colour: Colour, stroke: Stroke) -> Self {
        let points = time_s.iter().copied().zip(values.iter().copied()).collect();
        Self { name: name.to_owned(), points, colour, stroke }
    }
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
        let values = self.lines.iter().flat_map(|line| line.points.iter().map(|point| point.1));
        let ends = self.bands.iter().flat_map(|band| band.points.iter().flat_map(|point| [point.1, point.2]));
        let y = match self.y_range {
            Some((low, high)) => Axis::to_ticks(low, high),
            None => Axis::over(values.chain(ends), 0.02),
        };
        let x = if x.0 < x.1 { x } else { (x.0, x.0 + 1.0) };
        let fill = |band: &Band| band.colour.mix(0.22).filled();
        let bands = self.bands.iter().map(|band| (band.name.as_str(), Key::Patch(fill(band))));
        let lines = self.lines.iter().map(|line| {
            let style = line.colour.stroke_width(2);
            (
                line.name.as_str(),
                if line.stroke == Stroke::Dashed { Key::Dashes(style) } else { Key::Line(style) },
            )
        });
        let mut chart = Frame {
            title: &self.title,
            labels: ["time (s)", &self.y_label],
            x: Axis::to_ticks(x.0, x.1),
            y,
            keys: bands.chain(lines).collect(),
            y_area: NUMBERS,
            grid: true,
        }
        .draw(area)?;

        for band in &self.bands {
            chart.band(&band.points, fill(band))?;
        }
        let columns = chart.width() as usize;
        for line in &self.lines {
            let style = match line.stroke {
                Stroke::Faint => line.colour.mix(0.55).stroke_width(1),
                Stroke::Thin => line.colour.stroke_width(1),
                Stroke::Solid | Stroke::Dashed => line.colour.stroke_width(2),
            };
            for piece in decimate::pieces(&line.points, x, columns) {
                match line.stroke {
                    Stroke::Dashed => chart.dashes(&piece, style)?,
                    Stroke::Faint | Stroke::Thin | Stroke::Solid => chart.line(&piece, style)?,
                }
            }
        }
        Ok(())
    }
}
