//! Curves over any axis, with bands and single points: errors against window length.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::{Axis, range};
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::style::Colour;

/// One curve with a mark at every point.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// x, y, and the ends of an interval of y; NaN ends mean none.
    pub points: Vec<(f64, f64, f64, f64)>,
}

/// Single points: published figures of others.
#[derive(Debug, Clone)]
pub struct Marks {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// x and y.
    pub points: Vec<(f64, f64)>,
}

/// Curves with marks, bands about them, and single points.
#[derive(Debug, Clone, Default)]
pub struct Curves {
    /// Title.
    pub title: String,
    /// What the axes show, with their units.
    pub labels: [String; 2],
    /// The y axis goes by powers of ten; values that are not above 0 are left out.
    pub log: bool,
    /// Lower end of the y axis, where it is to be this one.
    pub from: Option<f64>,
    /// The curves, drawn in order.
    pub curves: Vec<Curve>,
    /// Drawn over them.
    pub marks: Vec<Marks>,
}

impl Curves {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let scaled = |value: f64| match self.log {
            true if value > 0.0 => value.log10(),
            true => f64::NAN,
            false => value,
        };
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let marks = || self.marks.iter().flat_map(|marks| &marks.points);
        let x = Axis::over(all().map(|point| point.0).chain(marks().map(|point| point.0)), 0.0);
        let values = all().flat_map(|point| [point.1, point.2, point.3]).chain(marks().map(|point| point.1));
        let values = values.map(scaled);
        let y = match self.from {
            _ if self.log => Axis::decades(values),
            Some(from) => Axis::to_ticks(from, range(values, 0.06).1.max(from + f64::MIN_POSITIVE.sqrt())),
            None => Axis::over(values, 0.06),
        };
        let curves = self.curves.iter().map(|curve| (curve.name.as_str(), Key::Marked(curve.colour)));
        let cross = |marks: &Marks| marks.colour.stroke_width(3);
        let alone = self.marks.iter().map(|marks| (marks.name.as_str(), Key::Cross(cross(marks))));
        let keys = curves.chain(alone).collect();
        let labels = self.labels.each_ref().map(String::as_str);
        let mut chart =
            Frame { title: &self.title, labels, x, y, keys, y_area: NUMBERS, grid: true }.draw(area)?;
        for Curve { colour, points, .. } in &self.curves {
            let ends: Vec<_> =
                points.iter().map(|point| (point.0, scaled(point.2), scaled(point.3))).collect();
            chart.band(&ends, colour.mix(0.18).filled())?;
        }
        for Curve { colour, points, .. } in &self.curves {
            let points: Vec<_> = points.iter().map(|point| (point.0, scaled(point.1))).collect();
            chart.line(&points, colour.stroke_width(2))?;
            chart.marks(points, *colour)?;
        }
        for marks in &self.marks {
            chart.crosses(marks.points.iter().map(|point| (point.0, scaled(point.1))), cross(marks))?;
        }
        Ok(())
    }
}
