//! A value over two axes, as coloured squares.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::axis::{Axis, range};
use super::chart::{Drawn, Frame, NUMBERS};
use super::style::{Colour, palette};

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

/// Squares, coloured from one colour through white at 0 to a second one.
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
pub(super) const NUMBER_SIZE: u32 = 14;

/// Columns whose numbers stand beside each other.
const MOST_NUMBERS: f64 = 13.0;

impl Heat {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let x = range(self.squares.iter().flat_map(|square| [square.x.0, square.x.1]), 0.0);
        let y = range(self.squares.iter().flat_map(|square| [square.y.0, square.y.1]), 0.0);
        let mut chart = Frame {
            title: &self.title,
            labels: self.labels.each_ref().map(String::as_str),
            x: Axis::exact(x.0, x.1),
            y: Axis::exact(y.0, y.1),
            keys: Vec::new(),
            y_area: NUMBERS,
            grid: false,
        }
        .draw(area)?;
        for square in &self.squares {
            let colour = self.colour(square.value).filled();
            chart.bar((square.x.0, square.y.0), (square.x.1, square.y.1), colour)?;
        }
        // Where squares are narrower than their numbers, colours have to do.
        let narrowest = self.squares.iter().map(|s| s.x.1 - s.x.0).fold(f64::INFINITY, f64::min);
        let numbers = (x.1 - x.0) / narrowest <= MOST_NUMBERS;
        let digits = if self.most < 1.0 { 2 } else { usize::from(self.most < 10.0) };
        for square in self.squares.iter().filter(|_| numbers) {
            let middle = (0.5 * (square.x.0 + square.x.1), 0.5 * (square.y.0 + square.y.1));
            // What rounds to zero has no sign.
            let is_zero = (square.value * 10_f64.powi(digits as i32)).round() == 0.0;
            let number = if is_zero { "0".to_owned() } else { format!("{:+.digits$}", square.value) };
            chart.text(middle, 0, HPos::Center, NUMBER_SIZE, number)?;
        }
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
