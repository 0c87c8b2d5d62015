//! A page of panels, and the file it goes to.

use std::path::Path;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::style::{self, FONT, GRID, INK, LABEL_SIZE, TITLE_SIZE};
use super::{Binned, Histogram, TimeSeries};
use crate::error::{Error, Result};
use crate::output;

/// What a backend may report.
pub(super) type Drawn<DB> = std::result::Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// A chart over two linear axes.
pub(super) type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// One figure of a page.
pub enum Panel {
    /// Curves over time.
    TimeSeries(TimeSeries),
    /// Predicted against measured, binned.
    Binned(Binned),
    /// Histogram with Gaussians.
    Histogram(Histogram),
}

impl From<TimeSeries> for Panel {
    fn from(panel: TimeSeries) -> Self {
        Self::TimeSeries(panel)
    }
}

impl From<Binned> for Panel {
    fn from(panel: Binned) -> Self {
        Self::Binned(panel)
    }
}

impl From<Histogram> for Panel {
    fn from(panel: Histogram) -> Self {
        Self::Histogram(panel)
    }
}

/// Panels below each other.
pub struct Page {
    panels: Vec<Panel>,
}

const WIDTH: u32 = 1000;
const PANEL_HEIGHT: u32 = 420;

impl Page {
    /// A page of panels, the first one on top.
    pub fn new(panels: impl IntoIterator<Item = Panel>) -> Self {
        Self { panels: panels.into_iter().collect() }
    }

    /// Draws the page into `file`: SVG or PNG, as the extension says. The file is written whole or not at all.
    ///
    /// # Errors
    /// Another extension (wrong usage), or the file cannot be written.
    pub fn save(&self, file: &Path) -> Result<()> {
        let format = check_extension(file)?;
        style::register();
        let size = (WIDTH, PANEL_HEIGHT * self.panels.len().max(1) as u32);
        let failed =
            |error: String| Error::failed(format!("the figure could not be drawn: {error}")).in_file(file);
        let bytes = match format {
            Format::Svg => {
                let mut text = String::new();
                self.draw(&SVGBackend::with_string(&mut text, size).into_drawing_area())
                    .map_err(|error| failed(error.to_string()))?;
                text.into_bytes()
            }
            Format::Png => {
                // plotters encodes into a path only.
                let drawn = tempfile::Builder::new()
                    .suffix(".png")
                    .tempfile()
                    .map_err(|error| failed(error.to_string()))?;
                self.draw(&BitMapBackend::new(drawn.path(), size).into_drawing_area())
                    .map_err(|error| failed(error.to_string()))?;
                std::fs::read(drawn.path()).map_err(|error| Error::io(drawn.path(), &error))?
            }
        };
        output::write_whole(file, |write| write.write_all(&bytes).map_err(|error| Error::io(file, &error)))
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        root.fill(&WHITE)?;
        let areas = root.split_evenly((self.panels.len().max(1), 1));
        for (panel, area) in self.panels.iter().zip(&areas) {
            match panel {
                Panel::TimeSeries(panel) => panel.draw(area)?,
                Panel::Binned(panel) => panel.draw(area)?,
                Panel::Histogram(panel) => panel.draw(area)?,
            }
        }
        root.present()
    }
}

/// File formats of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Scalable vector graphics.
    Svg,
    /// Portable network graphics.
    Png,
}

/// The format that a file's extension names; commands ask before they start long work.
///
/// # Errors
/// Neither `.svg` nor `.png` (wrong usage).
pub fn check_extension(file: &Path) -> Result<Format> {
    match file.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("svg") => Ok(Format::Svg),
        Some("png") => Ok(Format::Png),
        _ => Err(Error::usage("figures are written as .svg or .png").in_file(file)),
    }
}

/// The legend of a chart, if it names anything.
pub(super) fn legend<'a, DB: DrawingBackend + 'a>(
    chart: &mut ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
    position: SeriesLabelPosition,
    names: usize,
) -> Drawn<DB> {
    if names == 0 {
        return Ok(());
    }
    chart
        .configure_series_labels()
        .position(position)
        .legend_area_size(34)
        .background_style(WHITE.mix(0.85))
        .border_style(GRID)
        .label_font((FONT, LABEL_SIZE, &INK))
        .draw()
}

/// A number at an axis, without zeros at its end.
pub(super) fn tick(value: &f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The finite range of some values, widened by `margin` of itself on both sides; never empty.
pub(super) fn range(values: impl IntoIterator<Item = f64>, margin: f64) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    let span = if high > low { high - low } else { high.abs().max(1.0) };
    (low - margin * span, high + margin * span)
}

/// A chart with the axes that all figures have: title, what x and y show, and their ranges.
pub(super) fn axes<'a, DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    title: &str,
    [x_label, y_label]: [&str; 2],
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
) -> std::result::Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, TITLE_SIZE, &INK))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(x_label)
        .y_desc(y_label)
        .label_style((FONT, LABEL_SIZE, &INK))
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .axis_style(INK)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .draw()?;
    Ok(chart)
}
