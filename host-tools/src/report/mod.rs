//! Figures for users: SVG and PNG from one drawing.
//!
//! A [`Page`] is a stack of panels; [`Page::save`] draws it into the file format that the extension names.

mod bars;
mod binned;
mod cells;
mod decimate;
mod heat;
mod histogram;
mod page;
mod series;
mod style;

pub use bars::Bars;
pub use binned::Binned;
pub use cells::{CellSeries, Cells};
pub use heat::{Heat, HeatSquare};
pub use histogram::{Gaussian, Histogram};
pub use page::{Inline, Page, Panel, check_extension};
pub use series::{Band, Line, Stroke, TimeSeries};
pub use style::{Colour, palette};
