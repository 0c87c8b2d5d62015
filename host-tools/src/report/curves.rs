//! Curves over any axis, with bands and single points: errors against window length.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::page::{Drawn, axes, decades, legend, legend_room, range};
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

/// Points that stand alone: what somebody else has published.
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

/// Half the size of a mark, pixels.
const MARK: i32 = 5;

impl Curves {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let scaled = |value: f64| match self.log {
            true if value > 0.0 => value.log10(),
            true => f64::NAN,
            false => value,
        };
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let marks = || self.marks.iter().flat_map(|marks| &marks.points);
        let x = range(all().map(|point| point.0).chain(marks().map(|point| point.0)), 0.03);
        let values = all().flat_map(|point| [point.1, point.2, point.3]).chain(marks().map(|point| point.1));
        let (low, high) = range(values.map(scaled), 0.06);
        let low = match self.from.map(scaled) {
            Some(from) if from < high => from,
            _ => low,
        };
        // Above all values: curves may rise towards the legend as well as fall.
        let (_, height) = area.dim_in_pixel();
        let room = legend_room(self.curves.len() + self.marks.len(), height);
        let y = (low, high + room * (high - low));
        let [x_label, y_label] = &self.labels;
        let labels = [x_label.as_str(), y_label.as_str()];
        let mut chart = if self.log {
            decades(area, &self.title, labels, x.0..x.1, y.0..y.1)?
        } else {
            axes(area, &self.title, labels, x.0..x.1, y.0..y.1)?
        };
        for Curve { colour, points, .. } in &self.curves {
            let fill = colour.mix(0.18).filled();
            let within = |value: f64| scaled(value).clamp(y.0, y.1);
            for piece in points.split(|point| !(within(point.2).is_finite() && within(point.3).is_finite())) {
                let upper = piece.iter().map(|point| (point.0, within(point.3)));
                let lower = piece.iter().rev().map(|point| (point.0, within(point.2)));
                if piece.len() > 1 {
                    chart.draw_series([Polygon::new(upper.chain(lower).collect::<Vec<_>>(), fill)])?;
                }
            }
        }
        for Curve { name, colour, points } in &self.curves {
            let at: Vec<(f64, f64)> = points.iter().map(|point| (point.0, scaled(point.1))).collect();
            let stroke = colour.stroke_width(2);
            for piece in at.split(|point| !point.1.is_finite()) {
                chart.draw_series(LineSeries::new(piece.iter().copied(), stroke))?;
            }
            let colour = *colour;
            let known = at.into_iter().filter(|point| point.1.is_finite());
            chart.draw_series(known.map(|point| Circle::new(point, 3, colour.filled())))?.label(name).legend(
                move |at| {
                    EmptyElement::at(at)
                        + PathElement::new(vec![(0, 0), (22, 0)], colour.stroke_width(2))
                        + Circle::new((11, 0), 3, colour.filled())
                },
            );
        }
        for Marks { name, colour, points } in &self.marks {
            let cross = colour.stroke_width(3);
            let drawn = points.iter().map(|point| (point.0, scaled(point.1)));
            let drawn = drawn.filter(|point| point.1.is_finite());
            chart
                .draw_series(drawn.map(|point| Cross::new(point, MARK, cross)))?
                .label(name)
                .legend(move |at| EmptyElement::at(at) + Cross::new((11, 0), MARK, cross));
        }
        legend(&mut chart, SeriesLabelPosition::UpperRight, self.curves.len() + self.marks.len())
    }
}
