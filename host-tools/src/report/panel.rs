//! What a page can be made of.

use super::{Bars, Binned, Cells, Curves, Heat, Histogram, TimeSeries, Validation};

/// One figure of a page.
pub enum Panel {
    /// Curves over time.
    TimeSeries(TimeSeries),
    /// Predicted against measured, binned.
    Binned(Binned),
    /// Histogram with Gaussians.
    Histogram(Histogram),
    /// Bars with names.
    Bars(Bars),
    /// Means over cells of an axis.
    Cells(Cells),
    /// Squares over two axes.
    Heat(Heat),
    /// Curves over any axis.
    Curves(Curves),
    /// Predicted over measured, and residuals.
    Validation(Validation),
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

impl From<Bars> for Panel {
    fn from(panel: Bars) -> Self {
        Self::Bars(panel)
    }
}

impl From<Cells> for Panel {
    fn from(panel: Cells) -> Self {
        Self::Cells(panel)
    }
}

impl From<Heat> for Panel {
    fn from(panel: Heat) -> Self {
        Self::Heat(panel)
    }
}

impl From<Curves> for Panel {
    fn from(panel: Curves) -> Self {
        Self::Curves(panel)
    }
}

impl From<Validation> for Panel {
    fn from(panel: Validation) -> Self {
        Self::Validation(panel)
    }
}
