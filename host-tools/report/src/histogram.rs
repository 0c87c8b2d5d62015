//! Histogram of power with Gaussians over it (Fig. 9b of the paper).

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::{Axis, range};
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::clip::Window;
use super::style::Colour;

/// One bell over the histogram.
#[derive(Debug, Clone)]
pub struct Gaussian {
    /// Name in the legend.
    pub name: String,
    /// Mean, in the unit of the values.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Area, as a share of all values.
    pub share: f64,
    /// Colour.
    pub colour: Colour,
}

/// Density of values with Gaussians over it.
#[derive(Debug, Clone)]
pub struct Histogram {
    title: String,
    x_label: String,
    low: f64,
    width: f64,
    density: Vec<f64>,
    gaussians: Vec<Gaussian>,
}

const MOST_BINS: usize = 160;

impl Histogram {
    /// Bins `values` (Freedman and Diaconis's width) between their 0.1 % and 99.9 % quantiles.
    pub fn new(
        title: impl Into<String>,
        x_label: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        gaussians: Vec<Gaussian>,
    ) -> Self {
        let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let index = (share * values.len().saturating_sub(1) as f64).round() as usize;
            values.get(index).copied().unwrap_or(0.0)
        };
        let (low, high) = range([quantile(0.001), quantile(0.999)], 0.02);
        let ideal = 2.0 * (quantile(0.75) - quantile(0.25)) / (values.len().max(1) as f64).cbrt();
        let bins =
            if ideal > 0.0 { ((high - low) / ideal).ceil().clamp(10.0, MOST_BINS as f64) } else { 40.0 };
        let width = (high - low) / bins;
        let mut density = vec![0.0; bins as usize];
        let unit = 1.0 / (values.len().max(1) as f64 * width);
        for value in &values {
            if let Some(bin) = density.get_mut(((value - low) / width).floor() as usize)
                && *value >= low
            {
                *bin += unit;
            }
        }
        Self { title: title.into(), x_label: x_label.into(), low, width, density, gaussians }
    }

    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let high = self.low + self.width * self.density.len() as f64;
        let bell = |gaussian: &Gaussian, x: f64| {
            let z = (x - gaussian.mean) / gaussian.std;
            gaussian.share * (-0.5 * z * z).exp() / (gaussian.std * std::f64::consts::TAU.sqrt())
        };
        // A state that hardly varies would leave everything else flat.
        let highest_bin = self.density.iter().copied().fold(0.0, f64::max);
        let peaks = self.gaussians.iter().map(|gaussian| bell(gaussian, gaussian.mean));
        let top = 1.08 * peaks.fold(highest_bin, f64::max).min(1.6 * highest_bin).max(f64::MIN_POSITIVE);

        let stroke = |gaussian: &Gaussian| gaussian.colour.stroke_width(3);
        let keys = self.gaussians.iter().map(|one| (one.name.as_str(), Key::Line(stroke(one)))).collect();
        let (x, y) = (Axis::to_ticks(self.low, high), Axis::to_ticks(0.0, top));
        let labels = [self.x_label.as_str(), "density (1/W)"];
        let mut chart =
            Frame { title: &self.title, labels, x, y, keys, y_area: NUMBERS, grid: true }.draw(area)?;
        for (bin, &density) in self.density.iter().enumerate() {
            let from = self.low + bin as f64 * self.width;
            chart.bar((from, 0.0), (from + self.width, density), RGBColor(190, 190, 190).filled())?;
        }
        let Window { x, .. } = chart.window();
        for gaussian in &self.gaussians {
            let (from, to) = (gaussian.mean - 5.0 * gaussian.std, gaussian.mean + 5.0 * gaussian.std);
            let (from, to) = (from.max(x.0), to.min(x.1));
            let steps = 200;
            let curve = (0..=steps).map(|step| {
                let x = from + (to - from) * f64::from(step) / f64::from(steps);
                (x, bell(gaussian, x))
            });
            chart.line(&curve.collect::<Vec<_>>(), stroke(gaussian))?;
        }
        Ok(())
    }
}
