//! Prediction validation (Figs. 7 and 14 of the paper): predicted over measured, and residuals over
//! predicted.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axis::Axis;
use super::chart::{Drawn, Frame, Key, NUMBERS};
use super::style::{Colour, INK};

/// One method's samples.
#[derive(Debug, Clone)]
pub struct Validated {
    /// Name in the legend.
    pub name: String,
    /// Colour.
    pub colour: Colour,
    /// Measured and predicted, in one unit; pairs that are not finite are left out.
    pub pairs: Vec<(f64, f64)>,
}

/// Two plots side by side over the same samples.
#[derive(Debug, Clone, Default)]
pub struct Validation {
    /// What is predicted, with its unit.
    pub quantity: String,
    /// The methods, the last one on top.
    pub methods: Vec<Validated>,
}

/// Points that a method gets: more would hide each other, and fill the page.
const MOST_POINTS: usize = 1200;

impl Validation {
    pub(super) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Drawn<DB> {
        let halves = area.split_evenly((1, 2));
        let thinned: Vec<_> = self.methods.iter().map(|method| (method, thinned(&method.pairs))).collect();
        let pairs = || thinned.iter().flat_map(|(_, pairs)| pairs.iter().copied());
        let [Some(left), Some(right)] = [halves.first(), halves.get(1)] else { return Ok(()) };

        let measured = Axis::over(pairs().map(|pair| pair.0), 0.02);
        let predicted = Axis::over(pairs().map(|pair| pair.1), 0.02);
        let residual = Axis::over(pairs().map(|pair| pair.0 - pair.1).chain([0.0]), 0.02);
        let labels = ["measured", "predicted", "residual"].map(|what| format!("{what} {}", self.quantity));
        let grey = INK.mix(0.6).stroke_width(2);
        let names =
            || thinned.iter().map(|(method, _)| (method.name.as_str(), Key::Dot(method.colour.filled())));
        let ends = (measured.from.max(predicted.from), measured.to.min(predicted.to));
        let mut chart = Frame {
            title: "Predicted over measured",
            labels: [&labels[0], &labels[1]],
            x: measured,
            y: predicted.clone(),
            keys: names().chain([("perfect", Key::Dashes(grey))]).collect(),
            y_area: NUMBERS,
            grid: true,
        }
        .draw(left)?;
        for (method, pairs) in &thinned {
            chart.dots(pairs.iter().copied(), DOT, method.colour.mix(0.4).filled())?;
        }
        chart.dashes(&[(ends.0, ends.0), (ends.1, ends.1)], grey)?;

        let ends = (predicted.from, predicted.to);
        let mut chart = Frame {
            title: "Residuals over predicted",
            labels: [&labels[1], &labels[2]],
            x: predicted,
            y: residual,
            keys: names().collect(),
            y_area: NUMBERS,
            grid: true,
        }
        .draw(right)?;
        for (method, pairs) in &thinned {
            chart.dots(
                pairs.iter().map(|pair| (pair.1, pair.0 - pair.1)),
                DOT,
                method.colour.mix(0.4).filled(),
            )?;
        }
        chart.line(&[(ends.0, 0.0), (ends.1, 0.0)], grey)
    }
}

/// Radius of a sample, pixels.
const DOT: i32 = 2;

/// Evenly spaced pairs that are finite, at most [`MOST_POINTS`].
fn thinned(pairs: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let finite: Vec<_> = pairs.iter().copied().filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let step = finite.len().div_ceil(MOST_POINTS).max(1);
    finite.into_iter().step_by(step).collect()
}

#[cfg(test)]
mod tests {
    use super::{MOST_POINTS, thinned};

    #[test]
    fn thinning_keeps_what_is_finite_and_bounds_the_rest() {
        let pairs: Vec<_> = (0..10_001).map(|k| (f64::from(k), f64::from(k))).collect();
        let kept = thinned(&pairs);
        assert!(kept.len() <= MOST_POINTS && kept.len() > MOST_POINTS / 2, "{}", kept.len());
        assert_eq!(thinned(&[(1.0, f64::NAN), (f64::INFINITY, 1.0), (2.0, 3.0)]), [(2.0, 3.0)]);
    }
}
