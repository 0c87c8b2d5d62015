//! What a page can be made of.

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend};

use super::chart::Drawn;
use super::{Bars, Binned, Cells, Curves, Heat, Histogram, TimeSeries, Validation};

/// Each kind of figure, made of its value and drawn by it.
macro_rules! panels {
    ($($(#[$about:meta])* $panel:ident,)*) => {
        /// One figure of a page.
        #[derive(Debug, Clone)]
        pub enum Panel {
            $($(#[$about])* $panel($panel),)*
        }

        impl Panel {
            pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
                match self {
                    $(Self::$panel(panel) => panel.draw(area),)*
                }
            }
        }

        $(impl From<$panel> for Panel {
            fn from(panel: $panel) -> Self {
                Self::$panel(panel)
            }
        })*
    };
}

panels! {
    /// Curves over time.
    TimeSeries,
    /// Predicted against measured, binned.
    Binned,
    /// Histogram with Gaussians.
    Histogram,
    /// Bars with names.
    Bars,
    /// Means over cells of an axis.
    Cells,
    /// Squares over two axes.
    Heat,
    /// Curves over any axis.
    Curves,
    /// Predicted over measured, and residuals.
    Validation,
}
