//! Figures for users: SVG and PNG from one drawing.
//!
//! A [`Page`] is a stack of panels; [`Page::save`] draws it into the file format that the extension names.

mod bars;
mod binned;
mod cells;
mod curves;
mod decimate;
mod heat;
mod histogram;
pub(crate) mod html;
mod page;
mod panel;
mod series;
mod style;
mod validation;

pub use bars::Bars;
pub use binned::Binned;
pub use cells::{CellSeries, Cells};
pub use curves::{Curve, Curves, Marks};
pub use heat::{Heat, HeatSquare};
pub use histogram::{Gaussian, Histogram};
pub(crate) use page::legend_room;
pub use page::{Inline, Page, check_extension};
pub use panel::Panel;
pub use series::{Band, Line, Stroke, TimeSeries};
pub use style::{Colour, palette};
pub use validation::{Validated, Validation};
