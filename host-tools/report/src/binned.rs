//! Predicted against measured power, binned by what was measured (Fig. 15 of the paper).

use std::collections::BTreeMap;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::Axis;
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::style::{Colour, INK, palette};

/// Mean prediction and its spread for every bin of measured power, one curve a model; the diagonal
/// is the truth. Holds one sum a bin, however many samples are added.
#[derive(Debug, Clone)]
pub struct Binned {
    title: String,
    bin_w: f64,
    models: Vec<Model>,
}

#[derive(Debug, Clone)]
struct Model {
    name: String,
    colour: Colour,
    bins: BTreeMap<i64, Bin>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Bin {
    /// Welford's update.
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let step = value - self.mean;
        self.mean += step / self.count;
        self.squares += step * (value - self.mean);
    }

    fn std(self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Bins with fewer samples say nothing about a mean.
const FEWEST: f64 = 5.0;

impl Binned {
    /// An empty figure with bins `bin_w` W wide; the paper's are 0.5 W.
    ///
    /// # Panics
    /// If `bin_w` is not above 0.
    pub fn new(title: impl Into<String>, bin_w: f64) -> Self {
        assert!(bin_w > 0.0, "a bin has a width");
        Self { title: title.into(), bin_w, models: Vec::new() }
    }

    /// A model in this colour, at its place in the legend. Models without a colour get the
    /// palette's, in order of first use.
    #[must_use]
    pub fn with_model(mut self, name: impl Into<String>, colour: Colour) -> Self {
        self.models.push(Model { name: name.into(), colour, bins: BTreeMap::new() });
        self
    }

    /// Adds one sample of the model `model`.
    pub fn add(&mut self, model: &str, measured_w: f64, predicted_w: f64) {
        if !measured_w.is_finite() || !predicted_w.is_finite() {
            return;
        }
        let index = match self.models.iter().position(|known| known.name == model) {
            Some(index) => index,
            None => {
                let colour = palette(self.models.len());
                self.models.push(Model { name: model.to_owned(), colour, bins: BTreeMap::new() });
                self.models.len() - 1
            }
        };
        let bin = (measured_w / self.bin_w).round() as i64;
        self.models[index].bins.entry(bin).or_default().add(predicted_w);
    }

    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let filled = |bins: &BTreeMap<i64, Bin>| -> Vec<(f64, Bin)> {
            let filled = bins.iter().filter(|(_, bin)| bin.count >= FEWEST);
            filled.map(|(&bin, sums)| (bin as f64 * self.bin_w, *sums)).collect()
        };
        let curves: Vec<_> =
            self.models.iter().map(|model| (&model.name, model.colour, filled(&model.bins))).collect();
        let points = || curves.iter().flat_map(|(_, _, curve)| curve.iter());
        let x = Axis::over(points().map(|point| point.0), 0.06);
        let ends = |point: &(f64, Bin)| [point.1.mean - point.1.std(), point.1.mean + point.1.std(), point.0];
        let y = Axis::over(points().flat_map(ends), 0.06);
        let (low, high) = (x.from.max(y.from), x.to.min(y.to));
        let grey = INK.mix(0.6).stroke_width(2);
        let keys = curves.iter().map(|(name, colour, _)| (name.as_str(), Key::Marked(*colour)));
        let x_label = format!("measured power (W), bins of {} W", self.bin_w);
        let mut chart = Frame {
            title: &self.title,
            labels: [&x_label, "predicted power (W): mean ± standard deviation"],
            x,
            y,
            keys: std::iter::once(("perfect", Key::Dashes(grey))).chain(keys).collect(),
            y_area: NUMBERS,
            grid: true,
        }
        .draw(area)?;

        chart.dashes(&[(low, low), (high, high)], grey)?;
        for (index, (_, colour, curve)) in curves.iter().enumerate() {
            // Side by side, so that the bars of several models do not hide each other.
            let shift = (index as f64 - (curves.len() as f64 - 1.0) / 2.0) * self.bin_w * 0.12;
            for (x, bin) in curve {
                let (x, std) = (x + shift, bin.std());
                chart.line(&[(x, bin.mean - std), (x, bin.mean + std)], colour.mix(0.6).stroke_width(1))?;
            }
            let means: Vec<_> = curve.iter().map(|(x, bin)| (x + shift, bin.mean)).collect();
            // No line over bins that are empty.
            for stretch in means.chunk_by(|a, b| b.0 - a.0 < 1.5 * self.bin_w) {
                chart.line(stretch, colour.stroke_width(2))?;
            }
            chart.marks(means, *colour)?;
        }
        Ok(())
    }
}
