//! The figure of a comparison: predicted against measured power, binned as in the paper's Fig. 15.

use report::{Binned, Page};

use super::comparison::Comparison;
use super::entry::MassSource;

/// Bins of the figure over the range of the measured power.
const BINS: f64 = 30.0;

/// Most curves in a figure: as many as there are colours that everybody distinguishes.
const MOST_CURVES: usize = 7;

impl Comparison {
    /// Predicted against measured power; with `choose`, of the best models and ours only.
    pub fn figure(&self, choose: bool) -> Page {
        let highest = self.pairs.iter().flatten().map(|(measured, _)| *measured).fold(0.0, f64::max);
        let mut drawn: Vec<usize> = (0..self.entries.len())
            .filter(|&index| {
                let entry = &self.entries[index];
                entry.mass == MassSource::Estimated || !entry.name.contains("mass given")
            })
            .collect();
        let all = drawn.len();
        let mut title = "Predicted against measured power".to_owned();
        if choose && all > MOST_CURVES {
            // The default model first, whatever its place.
            let place = |&index: &usize| (index > 0, self.entries[index].rmse_w);
            drawn.sort_by(|a, b| {
                let ((late, error), (other_late, other_error)) = (place(a), place(b));
                late.cmp(&other_late).then(error.total_cmp(&other_error))
            });
            drawn.truncate(MOST_CURVES);
            title = format!("{title}: the best {MOST_CURVES} of {all} models");
        }
        let mut figure = Binned::new(title, nice(highest / BINS));
        for index in drawn {
            for (measured, predicted) in &self.pairs[index] {
                figure.add(&self.entries[index].name, *measured, *predicted);
            }
        }
        Page::new([figure.into()])
    }
}

/// The next of 1, 2, 5 times a power of ten.
fn nice(width: f64) -> f64 {
    let decade = 10_f64.powf(width.max(1e-6).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * decade).find(|step| *step >= width).unwrap_or(width)
}
