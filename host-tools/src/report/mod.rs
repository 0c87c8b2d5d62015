//! Figures for users: SVG and PNG from one drawing.
//!
//! A [`Page`] is a stack of panels; [`Page::save`] draws it into the file format that the extension names. What a panel shows is a
//! value; the frame around it (`chart`), its axes and what is cut at them are the same for all.

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
pub(crate) mod html;
mod mark;
mod page;
mod panel;
mod raster;
mod series;
mod style;
mod validation;
pub(crate) mod zoom;

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
