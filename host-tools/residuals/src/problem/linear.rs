//! The problem made linear about a state: how further columns explain the residual.

use logs::runs::Runs;
use nalgebra::DMatrix;
use numerics::least_squares::{Factored, FurtherColumn};

use super::panel::Panel;
use crate::noise::Noise;
use crate::thresholds::problem::LEAST_SHARE;

/// How a column explains the residual when base and effects may adapt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Its coefficient.
    pub value: f64,
    /// Its standard error, by the scatter of the residual.
    pub std_err: f64,
    /// Its coefficient per standard error.
    pub(crate) z: f64,
    /// Share of the column that base and effects leave.
    pub(crate) share: f64,
    /// Variance of the residual along the column, relative to noise; at least 1. A greater one
    /// makes a gain in χ² mean less.
    pub(crate) variance_inflation: f64,
}

/// The problem about a state, base, discrepancy and effects moving along with whatever is scored.
pub struct Linear<'a> {
    pub(super) noise: &'a Noise,
    pub(super) runs: &'a Runs,
    /// The first column after base, discrepancy and effects.
    pub(super) first: usize,
    pub(super) panel: Panel<'a>,
    /// Of all columns of the panel, over all runs.
    pub(crate) products: DMatrix<f64>,
    /// The equations of base, discrepancy and effects.
    pub(crate) factored: Factored,
}

impl Linear<'_> {
    /// Columns after base, discrepancy and effects: further regressors, then signals.
    pub(crate) fn further(&self) -> usize {
        self.products.ncols() - 1 - self.first
    }

    /// Place of a further column in the panel.
    pub(crate) fn place(&self, further: usize) -> usize {
        self.first + further
    }

    /// The score of a further column. Its variance is that of the residual along it, and at least
    /// that of white noise.
    pub fn score(&self, further: usize) -> Option<Score> {
        let (places, column): (Vec<usize>, usize) = ((0..self.first).collect(), self.place(further));
        let products = FurtherColumn::from_products(&self.products, &places, column);
        let score = self.factored.score(&products, LEAST_SHARE)?;
        let projected = self.panel.projected(column, &places, &score.by);
        let inflated = score.variance.max(self.noise.score_variance(self.runs.period_s, &projected));
        Some(Score {
            value: score.value(),
            std_err: inflated.sqrt() / score.variance,
            z: score.score / inflated.sqrt(),
            share: score.share,
            variance_inflation: inflated / score.variance,
        })
    }
}

#[cfg(test)]
mod tests {
    use model::effects::Regressor;
    use model_core::effects::Term;
    use model_core::torque::{Drive, TorqueModel};
    use nalgebra::{DMatrix, DVector};

    use super::super::example::{STD_W, bare, runs};
    use crate::predictor::{Predictor, State};

    /// The regression of the residual on base and effect at once, β = (XᵀX)⁻¹ Xᵀr, has z_j = β_j /
    /// (σ √((XᵀX)⁻¹)_jj); the score, which takes the base out of the column first, has to be the
    /// same number (Frisch, Waugh and Lovell). Tolerance: the ridge on the scaled diagonal is 1e-10
    /// and the scaled matrix's condition some 1e3.
    #[test]
    fn a_score_is_the_z_of_the_regression_coefficient() {
        const BASE: usize = 4;
        let runs = runs([0.4, 0.9]);
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let predictor = Predictor::new(&runs, Drive::Regenerative);
        let start = State { torque, effects: Vec::new() };
        let problem = bare(predictor, torque, BASE);
        for effect in [Regressor::Term(Term::Stribeck(1.0)), Regressor::Delay, Regressor::Term(Term::Offset)]
        {
            let score = problem.linear(&start, std::slice::from_ref(&effect), &[]).unwrap().score(0).unwrap();
            let of_runs: Vec<_> = (0..2)
                .map(|place| predictor.columns(place, &start, BASE, std::slice::from_ref(&effect)))
                .collect();
            let column = |index: usize| of_runs.iter().flat_map(move |run| run[index].iter().copied());
            let columns: Vec<DVector<f64>> = (0..BASE + 2)
                .map(|index| DVector::from_iterator(column(index).count(), column(index)))
                .collect();
            let design = DMatrix::from_columns(&columns[..=BASE]);
            let inverse = design.tr_mul(&design).try_inverse().unwrap();
            let beta = &inverse * design.tr_mul(&columns[BASE + 1]);
            let std_err = STD_W * inverse[(BASE, BASE)].sqrt();
            let near = |value: f64, expected: f64| (value / expected - 1.0).abs() < 1e-6;
            assert!(near(score.value, beta[BASE]), "{effect:?}: {} {}", score.value, beta[BASE]);
            assert!(near(score.std_err, std_err), "{effect:?}: {} {std_err}", score.std_err);
            assert!(near(score.z, beta[BASE] / std_err), "{effect:?}: {}", score.z);
        }
    }
}
