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

#[cfg(test)]
mod tests {
    use model_core::effects::Term;
    use model_core::estimator::Sample;
    use model_core::torque::{Drive, TorqueModel};
    use nalgebra::{DMatrix, DVector};

    use super::super::panel::Fixed;
    use super::*;
    use crate::effects::Regressor;
    use crate::gap::noise::whiten::Whitener;
    use crate::gap::problem::Problem;
    use crate::gap::twin::{State, Twin};
    use crate::log::runs::RawRun;
    use crate::robot::Robot;

    const STD_W: f64 = 0.07;

    /// Two runs of different masses; the power is what nobody's model says.
    fn runs() -> Runs<2> {
        let core = Robot::load("burger").unwrap().core::<2>(2.0).unwrap();
        let raw = [(1.0, 0.4), (4.0, 0.9)].map(|(mass, pace)| {
            let rows = (0..500).map(|i| {
                let time = 0.05 * f64::from(i);
                let speed = [5.0 * (pace * time).sin(), 4.0 * (0.7 * pace * time).cos()];
                let power = 0.5 + 0.2 * mass * (1.3 * time).sin() + 0.1 * (11.0 * time * time).sin();
                (time, Sample { wheel_speed: speed, wheel_acceleration: None, power }, mass, Vec::new())
            });
            RawRun { name: "run".to_owned(), rows: rows.collect(), columns: Vec::new(), period_s: 0.05 }
        });
        Runs::condition(&core, raw.into()).unwrap()
    }

    /// Noise of a known standard deviation that has no memory, and of which nothing says that it scatters more along any column.
    fn white(runs: &Runs<2>) -> Noise {
        let all = |value: f64| runs.runs.iter().map(|run| vec![value; run.rows.len()]).collect();
        Noise {
            whitener: Whitener { coefficients: Vec::new() },
            std_w: STD_W,
            weights: all(1.0),
            left: all(0.0),
            left_w: all(0.0),
            floor_w2: 0.0,
        }
    }

    /// The regression of the residual on base and effect at once, β = (XᵀX)⁻¹ Xᵀr, has z_j = β_j / (σ √((XᵀX)⁻¹)_jj); the score, which
    /// takes the base out of the column first, has to be the same number (Frisch, Waugh and Lovell). Tolerance: the ridge on the
    /// scaled diagonal is 1e-10 and the scaled matrix's condition some 1e3.
    #[test]
    fn a_score_is_the_z_of_the_regression_coefficient() {
        const BASE: usize = 4;
        let runs = runs();
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let twin = Twin { runs: &runs, drive: Drive::Regenerative, lag: 0.0 };
        let start = State { torque, effects: Vec::new() };
        let problem = Problem {
            twin,
            centre: torque,
            base: BASE,
            precision: DMatrix::zeros(BASE, BASE),
            noise: white(&runs),
            discrepancy: Fixed::default(),
            factor: None,
            smooth: Vec::new(),
        };
        for effect in [Regressor::Term(Term::Stribeck(1.0)), Regressor::Delay, Regressor::Term(Term::Offset)]
        {
            let score = problem.linear(&start, std::slice::from_ref(&effect), &[]).unwrap().score(0).unwrap();
            let parts: Vec<_> = (0..2)
                .map(|place| twin.columns(place, &start, BASE, std::slice::from_ref(&effect)))
                .collect();
            let column = |index: usize| parts.iter().flat_map(move |part| part[index].iter().copied());
            let columns: Vec<DVector<f64>> = (0..BASE + 2)
                .map(|index| DVector::from_iterator(column(index).count(), column(index)))
                .collect();
            let design = DMatrix::from_columns(&columns[..=BASE]);
            let inverse = design.tr_mul(&design).try_inverse().unwrap();
            let beta = &inverse * design.tr_mul(&columns[BASE + 1]);
            let std_err = STD_W * inverse[(BASE, BASE)].sqrt();
            let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-6;
            assert!(near(score.value, beta[BASE]), "{effect:?}: {} {}", score.value, beta[BASE]);
            assert!(near(score.std_err, std_err), "{effect:?}: {} {std_err}", score.std_err);
            assert!(near(score.z, beta[BASE] / std_err), "{effect:?}: {}", score.z);
        }
    }
}
