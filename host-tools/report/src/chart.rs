//! The frame that all figures share (title, legend, axes), and what may be drawn within it.
//!
//! The legend stands between title and plot, so that it never lies on a curve, whatever the values
//! are.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::clip::{At, Window};
use super::style::{Colour, FONT, GRID, INK, LABEL_SIZE, TITLE_SIZE};

/// What a backend may report.
pub(super) type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// What a name in the legend stands for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Key {
    Line(ShapeStyle),
    Dashes(ShapeStyle),
    Patch(ShapeStyle),
    Dot(ShapeStyle),
    /// A line with a mark at every point.
    Marked(Colour),
    Cross(ShapeStyle),
}

/// Title, labels and axes of a chart.
pub(super) struct Frame<'a> {
    pub(super) title: &'a str,
    /// What x and y show, with their units.
    pub(super) labels: [&'a str; 2],
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// The legend; names that are empty are left out.
    pub(super) keys: Vec<(&'a str, Key)>,
    /// Pixels for what stands left of the y axis.
    pub(super) y_area: u32,
    /// Grid lines at the ticks.
    pub(super) grid: bool,
}

/// Pixels left of the y axis where its numbers stand.
pub(super) const NUMBERS: u32 = 64;

const MARGIN: i32 = 12;
const LINE_HEIGHT: i32 = 20;
/// Width of the sample before a name, of the gap after it, and of the gap between two names.
const SAMPLE: i32 = 22;
const GAP: i32 = 8;
const BETWEEN: i32 = 20;

type Spec = Cartesian2d<Axis, Axis>;

/// A plot between its axes. What is drawn ends there.
pub(super) struct Chart<'a, DB: DrawingBackend> {
    context: ChartContext<'a, DB, Spec>,
    window: Window,
}

impl Frame<'_> {
    /// Draws it; what the figure shows comes then.
    pub(super) fn draw<'a, DB: DrawingBackend>(
        self,
        area: &DrawingArea<DB, Shift>,
    ) -> Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
        let area = self.legend(&self.titled(area)?)?;
        let Self { labels, x, y, y_area, grid, .. } = self;
        let window = Window { x: (x.from, x.to), y: (y.from, y.to) };
        let mut context = ChartBuilder::on(&area)
            .margin(MARGIN)
            .margin_top(4)
            .margin_right(2 * MARGIN)
            .x_label_area_size(44)
            .y_label_area_size(y_area)
            .build_cartesian_2d(x, y)?;
        let mut mesh = context.configure_mesh();
        mesh.x_desc(labels[0])
            .y_desc(labels[1])
            .label_style((FONT, LABEL_SIZE, &INK))
            .axis_style(INK)
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT);
        if !grid {
            mesh.disable_mesh();
        }
        mesh.draw()?;
        Ok(Chart { context, window })
    }

    fn titled<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
    ) -> Result<DrawingArea<DB, Shift>, DrawingAreaErrorKind<DB::ErrorType>> {
        let (top, below) = area.split_vertically(MARGIN + if self.title.is_empty() { 0 } else { 24 });
        // Where the plot is wider than a phone, its title is there all the same.
        let style = (FONT, TITLE_SIZE, &INK).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        let middle = (top.dim_in_pixel().1 as i32 + MARGIN) / 2;
        top.draw_text(self.title, &style, (MARGIN, middle))?;
        Ok(below)
    }

    /// Names beside each other, in as many lines as they need; what is left below them.
    fn legend<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
    ) -> Result<DrawingArea<DB, Shift>, DrawingAreaErrorKind<DB::ErrorType>> {
        let style = (FONT, LABEL_SIZE, &INK).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
        let start = self.y_area as i32 + MARGIN;
        let end = area.dim_in_pixel().0 as i32 - 2 * MARGIN;
        let (mut x, mut y) = (start, LINE_HEIGHT / 2);
        let mut placed = Vec::new();
        for (name, key) in self.keys.iter().filter(|(name, _)| !name.is_empty()) {
            let wide = SAMPLE + GAP + area.estimate_text_size(name, &style)?.0 as i32;
            if x > start && x + wide > end {
                (x, y) = (start, y + LINE_HEIGHT);
            }
            placed.push((name, key, (x, y)));
            x += wide + BETWEEN;
        }
        let lines = if placed.is_empty() { 0 } else { y + LINE_HEIGHT / 2 };
        let (top, below) = area.split_vertically(lines);
        for (name, key, (x, y)) in placed {
            key.draw(&top, (x, y))?;
            top.draw_text(name, &style, (x + SAMPLE + GAP, y))?;
        }
        Ok(below)
    }
}

impl Key {
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, (x, y): (i32, i32)) -> Drawn<DB> {
        let line =
            |from: i32, to: i32, style| area.draw(&PathElement::new(vec![(x + from, y), (x + to, y)], style));
        match *self {
            Self::Line(style) => line(0, SAMPLE, style),
            Self::Dashes(style) => line(0, 9, style).and_then(|()| line(13, SAMPLE, style)),
            Self::Patch(style) => area.draw(&Rectangle::new([(x, y - 5), (x + SAMPLE, y + 5)], style)),
            Self::Dot(style) => area.draw(&Circle::new((x + SAMPLE / 2, y), 4, style)),
            Self::Marked(colour) => line(0, SAMPLE, colour.stroke_width(2))
                .and_then(|()| area.draw(&Circle::new((x + SAMPLE / 2, y), MARK, colour.filled()))),
            Self::Cross(style) => area.draw(&Cross::new((x + SAMPLE / 2, y), CROSS, style)),
        }
    }
}

/// Radius of the mark at a point of a curve, and half the size of one that stands alone, pixels.
const MARK: i32 = 3;
const CROSS: i32 = 5;

impl<DB: DrawingBackend> Chart<'_, DB> {
    /// Ends of both axes.
    pub(super) fn window(&self) -> Window {
        self.window
    }

    /// Width of the plot, pixels.
    pub(super) fn width(&self) -> u32 {
        self.context.plotting_area().dim_in_pixel().0
    }

    /// A line through points; one that is not finite is a hole.
    pub(super) fn line(&mut self, points: &[At], style: impl Into<ShapeStyle>) -> Drawn<DB> {
        let style = style.into();
        for piece in self.window.line(points) {
            self.context.draw_series([PathElement::new(piece, style)])?;
        }
        Ok(())
    }

    /// As [`Self::line`], in dashes.
    pub(super) fn dashes(&mut self, points: &[At], style: impl Into<ShapeStyle>) -> Drawn<DB> {
        let style = style.into();
        for piece in self.window.line(points) {
            self.context.draw_series(DashedLineSeries::new(piece, 8, 6, style))?;
        }
        Ok(())
    }

    /// A filled area.
    pub(super) fn area(&mut self, corners: Vec<At>, style: impl Into<ShapeStyle>) -> Drawn<DB> {
        let corners = self.window.area(corners);
        if corners.len() < 3 {
            return Ok(());
        }
        self.context.draw_series([Polygon::new(corners, style)]).map(|_| ())
    }

    /// The area between two ends at each x; holes split it.
    pub(super) fn band(&mut self, points: &[(f64, f64, f64)], style: impl Into<ShapeStyle>) -> Drawn<DB> {
        let style = style.into();
        for piece in points.split(|(x, low, high)| !(x.is_finite() && low.is_finite() && high.is_finite())) {
            let upper = piece.iter().map(|&(x, _, high)| (x, high));
            let lower = piece.iter().rev().map(|&(x, low, _)| (x, low));
            if piece.len() > 1 {
                self.area(upper.chain(lower).collect(), style)?;
            }
        }
        Ok(())
    }

    /// A filled rectangle.
    pub(super) fn bar(&mut self, from: At, to: At, style: impl Into<ShapeStyle>) -> Drawn<DB> {
        let Window { x, y } = self.window;
        let within = |at: At| (at.0.clamp(x.0, x.1), at.1.clamp(y.0, y.1));
        self.context.draw_series([Rectangle::new([within(from), within(to)], style)]).map(|_| ())
    }

    /// Circles of this radius, pixels.
    pub(super) fn dots(
        &mut self,
        points: impl IntoIterator<Item = At>,
        size: i32,
        colour: impl Into<ShapeStyle>,
    ) -> Drawn<DB> {
        let (window, style) = (self.window, colour.into());
        let shown = points.into_iter().filter(|at| window.holds(*at));
        self.context.draw_series(shown.map(|at| Circle::new(at, size, style))).map(|_| ())
    }

    /// The marks at the points of a curve.
    pub(super) fn marks(&mut self, points: impl IntoIterator<Item = At>, colour: Colour) -> Drawn<DB> {
        self.dots(points, MARK, colour.filled())
    }

    /// Points that stand alone.
    pub(super) fn crosses(&mut self, points: impl IntoIterator<Item = At>, style: ShapeStyle) -> Drawn<DB> {
        let window = self.window;
        let shown = points.into_iter().filter(|at| window.holds(*at));
        self.context.draw_series(shown.map(|at| Cross::new(at, CROSS, style))).map(|_| ())
    }

    /// A text `right` pixels right of a point, aligned by `place`; it may lie outside of the axes.
    pub(super) fn text(&mut self, at: At, right: i32, place: HPos, size: u32, text: String) -> Drawn<DB> {
        let style = (FONT, size, &INK).into_text_style(self.context.plotting_area());
        let style = style.pos(Pos::new(place, VPos::Center));
        self.context.draw_series([EmptyElement::at(at) + Text::new(text, (right, 0), style)]).map(|_| ())
    }
}
