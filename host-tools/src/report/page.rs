//! A page of panels, and the file it goes to.

use std::path::Path;

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::Panel;
use super::style::{self, FONT, GRID, INK, LABEL_SIZE, TITLE_SIZE};
use crate::error::{Error, Result};
use crate::output;

/// What a backend may report.
pub(super) type Drawn<DB> = std::result::Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

/// A chart over two linear axes.
pub(super) type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Panels below each other.
pub struct Page {
    panels: Vec<Panel>,
    panel: (u32, u32),
}

/// A drawing to stand in a page of text: what is inside its `<svg>`, which is the page's to open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Inline {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Elements; texts are escaped.
    pub content: String,
}

const WIDTH: u32 = 1000;
const PANEL_HEIGHT: u32 = 420;

impl Page {
    /// A page of panels, the first one on top.
    pub fn new(panels: impl IntoIterator<Item = Panel>) -> Self {
        Self { panels: panels.into_iter().collect(), panel: (WIDTH, PANEL_HEIGHT) }
    }

    /// The same with panels of another width and height, pixels.
    #[must_use]
    pub fn with_panels_of(self, width: u32, height: u32) -> Self {
        Self { panel: (width, height), ..self }
    }

    /// Draws the page to stand in a page of text.
    ///
    /// # Errors
    /// plotters cannot draw it.
    pub fn inline(&self) -> Result<Inline> {
        let text = self.svg().map_err(|error| Error::failed(undrawn(&error)))?;
        // plotters opens `<svg …>` first and closes it last.
        let content = text.split_once('>').and_then(|(_, inside)| inside.rsplit_once("</svg>"));
        let content = content.map_or(String::new(), |(content, _)| content.to_owned());
        Ok(Inline { size: self.size(), content })
    }

    fn size(&self) -> (u32, u32) {
        (self.panel.0, self.panel.1 * self.panels.len().max(1) as u32)
    }

    fn svg(&self) -> std::result::Result<String, String> {
        style::register();
        let mut text = String::new();
        self.draw(&SVGBackend::with_string(&mut text, self.size()).into_drawing_area())
            .map_err(|error| error.to_string())?;
        Ok(text)
    }

    /// Draws the page into `file`: SVG or PNG, as the extension says. The file is written whole or not at all.
    ///
    /// # Errors
    /// Another extension (wrong usage), or the file cannot be written.
    pub fn save(&self, file: &Path) -> Result<()> {
        let format = check_extension(file)?;
        let failed = |error: String| Error::failed(undrawn(&error)).in_file(file);
        let bytes = match format {
            Format::Svg => self.svg().map_err(failed)?.into_bytes(),
            Format::Png => {
                style::register();
                // plotters encodes into a path only.
                let drawn = tempfile::Builder::new()
                    .suffix(".png")
                    .tempfile()
                    .map_err(|error| failed(error.to_string()))?;
                self.draw(&BitMapBackend::new(drawn.path(), self.size()).into_drawing_area())
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
                Panel::Bars(panel) => panel.draw(area)?,
                Panel::Cells(panel) => panel.draw(area)?,
                Panel::Heat(panel) => panel.draw(area)?,
                Panel::Curves(panel) => panel.draw(area)?,
                Panel::Validation(panel) => panel.draw(area)?,
            }
        }
        root.present()
    }
}

fn undrawn(error: &str) -> String {
    format!("the figure could not be drawn: {error}")
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

/// Pixels that a legend takes: its frame, and its names.
const LEGEND: u32 = 24;
const LEGEND_NAME: u32 = 20;

/// Pixels of a panel's height that are title, axis and margins.
const AROUND: u32 = 84;

/// By what share of the span of its values an axis has to be longer, so that a legend of so many names stands above all of them in a
/// panel of this height, pixels.
pub(crate) fn legend_room(names: usize, panel_height: u32) -> f64 {
    let plot = f64::from(panel_height.saturating_sub(AROUND).max(1));
    let share = f64::from(LEGEND + LEGEND_NAME * names as u32) / plot;
    let share = share.min(MOST_LEGEND);
    share / (1.0 - share)
}

/// A legend that would take more of a plot than this may cover values.
const MOST_LEGEND: f64 = 0.6;

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
    labels: [&str; 2],
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
) -> std::result::Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
    let mut chart = start(area, title, 64, x, y)?;
    mesh(&mut chart, labels).draw()?;
    Ok(chart)
}

/// As [`axes`], with the powers of ten that the values of y are.
pub(super) fn decades<'a, DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    title: &str,
    labels: [&str; 2],
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
) -> std::result::Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
    let ticks = (y.end.floor() - y.start.ceil()).max(1.0) as usize + 1;
    let mut chart = start(area, title, 64, x, y)?;
    let power = |exponent: &f64| format!("{:e}", (10_f64.powf(*exponent) * 1e9).round() / 1e9);
    mesh(&mut chart, labels).y_labels(ticks).y_label_formatter(&power).draw()?;
    Ok(chart)
}

/// As [`axes`], with so many pixels for what stands left of the y axis, and with grid lines at x and y, or without: without any at
/// y its numbers are left out where there is no label.
pub(super) fn bare_axes<'a, DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    title: &str,
    labels: [&str; 2],
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
    left: u32,
    grid: [bool; 2],
) -> std::result::Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
    let mut chart = start(area, title, left, x, y)?;
    let mut mesh = mesh(&mut chart, labels);
    if !grid[0] {
        mesh.disable_x_mesh();
    }
    if !grid[1] {
        mesh.disable_y_mesh();
    }
    if labels[1].is_empty() {
        mesh.y_labels(0);
    }
    mesh.draw()?;
    Ok(chart)
}

fn start<'a, DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    title: &str,
    left: u32,
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
) -> std::result::Result<Chart<'a, DB>, DrawingAreaErrorKind<DB::ErrorType>> {
    ChartBuilder::on(area)
        .caption(title, (FONT, TITLE_SIZE, &INK))
        .margin(12)
        .margin_right(24)
        .x_label_area_size(44)
        .y_label_area_size(left)
        .build_cartesian_2d(x, y)
}

fn mesh<'a, 'b, DB: DrawingBackend>(
    chart: &'b mut Chart<'a, DB>,
    [x_label, y_label]: [&str; 2],
) -> MeshStyle<'a, 'b, RangedCoordf64, RangedCoordf64, DB> {
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(x_label)
        .y_desc(y_label)
        .label_style((FONT, LABEL_SIZE, &INK))
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .axis_style(INK)
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT);
    mesh
}
