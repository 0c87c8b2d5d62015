//! Colours, font and sizes that all figures share.

use std::sync::Once;

use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// A colour, red, green and blue.
pub type Colour = RGBColor;

/// Name that the embedded font is registered under; in SVG the viewer's own font of this name is
/// used.
pub(super) const FONT: &str = "sans-serif";
pub(super) const TITLE_SIZE: u32 = 20;
pub(super) const LABEL_SIZE: u32 = 15;
pub(super) const GRID: Colour = RGBColor(225, 225, 225);
pub(super) const INK: Colour = RGBColor(40, 40, 40);

/// Colour `index` of the palette of Okabe and Ito, which colour-blind readers can distinguish; it
/// repeats after seven.
pub fn palette(index: usize) -> Colour {
    const COLOURS: [Colour; 7] = [
        RGBColor(0, 114, 178),
        RGBColor(213, 94, 0),
        RGBColor(0, 158, 115),
        RGBColor(204, 121, 167),
        RGBColor(230, 159, 0),
        RGBColor(86, 180, 233),
        RGBColor(0, 0, 0),
    ];
    COLOURS[index % COLOURS.len()]
}

/// Registers the embedded font: without one, plotters fails (SVG) or panics (PNG).
pub(super) fn register() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails on broken font data only, which `every_panel_is_drawn_in_both_formats` would show.
        let _ = register_font(FONT, FontStyle::Normal, include_bytes!("../../assets/DejaVuSans-subset.ttf"));
    });
}
