//! A page of panels, and the file it goes to.

use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;
use support::error::{Error, Result};
use support::output;

use super::Panel;
use super::chart::Drawn;
use super::raster::Raster;
use super::{mark, style};

/// Panels below each other.
#[derive(Debug, Clone)]
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

    /// The same with panels of this width and height, pixels.
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

    /// Draws the page into `file`: SVG or PNG, as the extension says. The file is written whole or
    /// not at all.
    ///
    /// # Errors
    /// Another extension (wrong usage), or the file cannot be written.
    pub fn save(&self, file: &Path) -> Result<()> {
        let format = check_extension(file)?;
        let failed = |error: String| Error::failed(undrawn(&error)).in_file(file);
        let bytes = match format {
            Format::Svg => mark::svg(self.svg().map_err(failed)?).into_bytes(),
            Format::Png => {
                style::register();
                // plotters encodes into a path only.
                let drawn = tempfile::Builder::new()
                    .suffix(".png")
                    .tempfile()
                    .map_err(|error| failed(error.to_string()))?;
                let backend = Raster(BitMapBackend::new(drawn.path(), self.size()));
                self.draw(&backend.into_drawing_area()).map_err(|error| failed(error.to_string()))?;
                mark::png(std::fs::read(drawn.path()).map_err(|error| Error::io(drawn.path(), &error))?)
            }
        };
        output::write_content(file, &bytes)
    }

    fn draw<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        root.fill(&WHITE)?;
        let areas = root.split_evenly((self.panels.len().max(1), 1));
        for (panel, area) in self.panels.iter().zip(&areas) {
            panel.draw(area)?;
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
