//! The problem made linear about a state: what further columns say about what is left.

use nalgebra::DMatrix;

use super::panel::Panel;
use crate::gap::noise::Noise;
use crate::gap::thresholds::problem::LEAST_SHARE;
use crate::log::runs::Runs;
use crate::numerics::least_squares::{Factored, FurtherColumn};

/// What a column says about the residual when base and effects may move along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    /// Its coefficient.
    pub(crate) value: f64,
    /// Its standard error, by the scatter of what is left.
    pub(crate) std_err: f64,
    /// Its coefficient per standard error.
    pub(crate) z: f64,
    /// Share of the column that base and effects leave.
    pub(crate) share: f64,
    /// 1 where what is left scatters along the column as noise does, more where it scatters more: there a gain in χ² means less.
    pub(crate) variance_inflation: f64,
}

/// The problem about a state, base, discrepancy and effects moving along with whatever is scored.
pub(crate) struct Linear<'a, const N: usize> {
    pub(super) noise: &'a Noise,
    pub(super) runs: &'a Runs<N>,
    /// The first column behind base, discrepancy and effects.
    pub(super) first: usize,
    pub(super) panel: Panel<'a>,
    /// Of all columns of the panel, over all runs.
    pub(crate) products: DMatrix<f64>,
    /// The equations of base, discrepancy and effects.
    pub(crate) factored: Factored,
}

impl<const N: usize> Linear<'_, N> {
    /// Columns behind base, discrepancy and effects: further regressors, then signals.
    pub(crate) fn further(&self) -> usize {
        self.products.ncols() - 1 - self.first
    }

    /// Place of a further column in the panel.
    pub(crate) fn place(&self, further: usize) -> usize {
        self.first + further
    }

    /// The score of a further column: its variance is that of what is left along it, and never below that of white noise.
    pub(crate) fn score(&self, further: usize) -> Option<Score> {
        let (places, column): (Vec<usize>, usize) = ((0..self.first).collect(), self.place(further));
        let own = FurtherColumn::from_products(&self.products, &places, column);
        let found = self.factored.score(&own, LEAST_SHARE)?;
        let projected = self.panel.projected(column, &places, &found.by);
        let inflated = found.variance.max(self.noise.score_variance(self.runs.period_s, &projected));
        Some(Score {
            value: found.value(),
            std_err: inflated.sqrt() / found.variance,
            z: found.score / inflated.sqrt(),
            share: found.share,
            variance_inflation: inflated / found.variance,
        })
    }
}
