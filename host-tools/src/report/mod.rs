//! Figures for users: SVG and PNG from one drawing.
//!
//! A [`Page`] is a stack of panels; [`Page::save`] draws it into the file format that the extension names.

mod binned;
mod decimate;
mod histogram;
mod page;
mod series;
mod style;

pub use binned::Binned;
pub use histogram::{Gaussian, Histogram};
pub use page::{Page, Panel, check_extension};
pub use series::{Band, Line, Stroke, TimeSeries};
pub use style::{Colour, palette};
