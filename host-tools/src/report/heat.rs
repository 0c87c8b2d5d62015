//! A value over two axes, as coloured squares.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::page::{Drawn, bare_axes, range};
use super::style::{Colour, FONT, INK, palette};

/// One square: ends on both axes, and its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatSquare {
    /// Ends on the first axis.
    pub x: (f64, f64),
    /// On the second.
    pub y: (f64, f64),
    /// Its value; written into it.
    pub value: f64,
}

/// Squares, coloured from one colour through white at 0 to another.
#[derive(Debug, Clone)]
pub struct Heat {
    /// Title.
    pub title: String,
    /// What the axes show, with their units.
    pub labels: [String; 2],
    /// The size that gets the full colour.
    pub most: f64,
    /// The squares.
    pub squares: Vec<HeatSquare>,
}

/// Height of the numbers, pixels.
const NUMBER_SIZE: u32 = 12;

/// Columns whose numbers stand beside each other.
const MOST_NUMBERS: f64 = 13.0;

impl Heat {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let x = range(self.squares.iter().flat_map(|square| [square.x.0, square.x.1]), 0.0);
        let y = range(self.squares.iter().flat_map(|square| [square.y.0, square.y.1]), 0.0);
        let [x_label, y_label] = &self.labels;
        let mut chart =
            bare_axes(area, &self.title, [x_label, y_label], x.0..x.1, y.0..y.1, 64, [false, false])?;
        chart.draw_series(self.squares.iter().map(|square| {
            let ends = [(square.x.0, square.y.0), (square.x.1, square.y.1)];
            Rectangle::new(ends, self.colour(square.value).filled())
        }))?;
        let style = (FONT, NUMBER_SIZE, &INK).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Center));
        // Where squares are narrower than their numbers, colours have to do.
        let narrowest = self.squares.iter().map(|s| s.x.1 - s.x.0).fold(f64::INFINITY, f64::min);
        let numbers = (x.1 - x.0) / narrowest <= MOST_NUMBERS;
        let digits = if self.most < 1.0 { 2 } else { usize::from(self.most < 10.0) };
        chart.draw_series(self.squares.iter().filter(|_| numbers).map(|square| {
            let middle = (0.5 * (square.x.0 + square.x.1), 0.5 * (square.y.0 + square.y.1));
            Text::new(format!("{:+.digits$}", square.value), middle, style.clone())
        }))?;
        Ok(())
    }

    /// Blue below 0, orange above: readers who see no red tell them apart.
    fn colour(&self, value: f64) -> Colour {
        let end = if value < 0.0 { palette(5) } else { palette(4) };
        let share = if self.most > 0.0 { (value.abs() / self.most).min(1.0) } else { 0.0 };
        let mix = |end: u8| (255.0 + share * (f64::from(end) - 255.0)).round() as u8;
        RGBColor(mix(end.0), mix(end.1), mix(end.2))
    }
}
