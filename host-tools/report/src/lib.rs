//! Figures and pages: SVG, PNG and HTML from one drawing.
//!
//! A [`Page`] is a stack of [`Panel`]s; [`Page::save`] draws it in the format that the file's
//! extension names. What a panel shows is a value; its frame, its axes and what is cut at them are
//! the same for all. [`html`] and [`zoom`] put drawings into documents.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod axis;
mod bars;
mod binned;
mod cells;
mod chart;
mod clip;
mod curves;
mod decimate;
mod heat;
mod histogram;
pub mod html;
mod mark;
mod page;
mod panel;
mod raster;
mod series;
mod style;
mod validation;
pub mod zoom;

pub use bars::Bars;
pub use binned::Binned;
pub use cells::{CellSeries, Cells};
pub use curves::{Curve, Curves, Marks};
pub use heat::{Heat, HeatSquare};
pub use histogram::{Gaussian, Histogram};
pub use page::{Inline, Page, check_extension};
pub use panel::Panel;
pub use series::{Band, Line, Stroke, TimeSeries};
pub use style::{Colour, palette};
pub use validation::{Validated, Validation};
