//! Prediction validation (Figs. 7 and 14 of the paper): predicted over measured, and residuals over predicted.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::page::{Drawn, axes, legend, range};
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

        let x = range(pairs().map(|pair| pair.0), 0.04);
        let y = range(pairs().map(|pair| pair.1), 0.04);
        let labels = [format!("measured {}", self.quantity), format!("predicted {}", self.quantity)];
        let mut chart =
            axes(left, "Predicted over measured", labels.each_ref().map(String::as_str), x.0..x.1, y.0..y.1)?;
        let (low, high) = (x.0.max(y.0), x.1.min(y.1));
        let grey = INK.mix(0.6).stroke_width(2);
        for (Validated { name, colour, .. }, pairs) in &thinned {
            let (dot, key) = (colour.mix(0.4).filled(), colour.filled());
            let points = pairs.iter().map(|pair| Circle::new(*pair, 2, dot));
            chart
                .draw_series(points)?
                .label(name)
                .legend(move |at| EmptyElement::at(at) + Circle::new((11, 0), 4, key));
        }
        chart
            .draw_series(DashedLineSeries::new([(low, low), (high, high)], 8, 6, grey))?
            .label("perfect")
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 22, y)], grey));
        legend(&mut chart, SeriesLabelPosition::UpperLeft, thinned.len() + 1)?;

        let residuals = range(pairs().map(|pair| pair.0 - pair.1).chain([0.0]), 0.06);
        let labels = [format!("predicted {}", self.quantity), format!("residual {}", self.quantity)];
        let labels = labels.each_ref().map(String::as_str);
        let mut chart = axes(right, "Residuals over predicted", labels, y.0..y.1, residuals.0..residuals.1)?;
        for (Validated { colour, .. }, pairs) in &thinned {
            let dot = colour.mix(0.4).filled();
            let points = pairs.iter().map(|pair| Circle::new((pair.1, pair.0 - pair.1), 2, dot));
            chart.draw_series(points)?;
        }
        chart.draw_series([PathElement::new(vec![(y.0, 0.0), (y.1, 0.0)], grey)])?;
        Ok(())
    }
}

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
