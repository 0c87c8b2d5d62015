//! One state of knowledge about some runs: how far a column, or an added effect, explains what is left.

pub mod fit;
pub mod lag;
pub mod open;
pub mod panel;
pub mod solve;
mod times;

use self::panel::{Fixed, Panel};
use self::solve::Prior;
use super::noise::Noise;
use super::thresholds::problem::{LEAST_SHARE, RIDGE};
use super::twin::{State, Twin};
use crate::effects::Regressor;
use crate::gap::noise::whiten::Signal;
use model_core::torque::TorqueModel;
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

/// The runs in question, and what is known of base and noise.
#[derive(Debug)]
pub struct Problem<'a, const N: usize> {
    /// Model and runs.
    pub twin: Twin<'a, N>,
    /// The base as its own fit left it.
    pub centre: TorqueModel<f64>,
    /// How many parameters it has.
    pub base: usize,
    /// How far it may be off.
    pub prior: Prior,
    /// The noise.
    pub noise: Noise,
    /// What the base gets wrong on clean runs too.
    pub discrepancy: Fixed,
    /// Cholesky factor of its products over all runs.
    pub factor: Option<Cholesky<f64, Dyn>>,
    /// Smooth functions in the runs in question, whitened; 0 in clean runs.
    pub smooth: Vec<Signal>,
}

/// What a column says about the residual when base and effects may move along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Its coefficient.
    pub value: f64,
    /// Its standard error, by the scatter of what is left.
    pub std_err: f64,
    /// Its coefficient per standard error.
    pub z: f64,
    /// Share of the column that base and effects leave.
    pub share: f64,
    /// 1 where what is left scatters along the column as noise does, more where it scatters more: there a gain in χ² means less.
    pub variance_inflation: f64,
}

impl<const N: usize> Problem<'_, N> {
    /// How far a state's base is from where its own fit left it.
    pub fn offset(&self, state: &State) -> DVector<f64> {
        let (now, then) = (state.torque.to_array(), self.centre.to_array());
        DVector::from_fn(self.base, |i, _| now[i] - then[i])
    }

    /// The base as its own fit left it.
    pub fn start(&self) -> State {
        State { torque: self.centre, effects: Vec::new() }
    }

    /// Columns that always move along with the base: the discrepancy, and the effects of a state.
    pub fn active(&self, state: &State) -> Vec<usize> {
        (self.base..self.first_further(state)).collect()
    }

    /// The first column behind base, discrepancy and effects.
    pub fn first_further(&self, state: &State) -> usize {
        self.base + self.discrepancy.len() + state.effects.len()
    }

    /// The problem about a state: columns of the base, its effects, further regressors, and smooth functions if wanted.
    pub fn panel(&self, state: &State, further: &[Regressor], smooth: bool) -> Panel<'_> {
        self.panel_with(state, further, if smooth { &self.smooth } else { &[] })
    }

    /// As [`panel`](Self::panel) with any whitened signals behind the regressors.
    pub fn panel_with(&self, state: &State, further: &[Regressor], signals: &[Signal]) -> Panel<'_> {
        let mut regressors: Vec<Regressor> =
            state.effects.iter().map(|(regressor, _)| regressor.clone()).collect();
        regressors.extend_from_slice(further);
        Panel::new(&self.twin, state, &self.noise, self.base, &self.discrepancy, &regressors, signals)
    }

    /// The score of a column of a panel, base and the columns in `active` moving along.
    pub fn score(
        &self,
        panel: &Panel,
        total: &DMatrix<f64>,
        state: &State,
        active: &[usize],
        column: usize,
    ) -> Option<Score> {
        let places: Vec<usize> = (0..self.base).chain(active.iter().copied()).collect();
        let residual = total.ncols() - 1;
        let offset = self.offset(state);
        let pull = &self.prior.precision * &offset;
        let size = places.len();
        let mut matrix = DMatrix::from_fn(size, size, |i, j| total[(places[i], places[j])]);
        for i in 0..self.base {
            for j in 0..self.base {
                matrix[(i, j)] += self.prior.precision[(i, j)];
            }
        }
        let scale = DVector::from_fn(size, |i, _| 1.0 / matrix[(i, i)].max(1e-300).sqrt());
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            matrix[(i, j)] * scale[i] * scale[j] + if i == j { RIDGE } else { 0.0 }
        });
        let along = DVector::from_fn(size, |i, _| total[(places[i], column)] * scale[i]);
        let by = scaled.cholesky()?.solve(&along).component_mul(&scale);
        let mut score = total[(column, residual)];
        let mut variance = total[(column, column)];
        for (index, &place) in places.iter().enumerate() {
            let pulled = if index < self.base { pull[index] } else { 0.0 };
            score -= by[index] * (total[(place, residual)] - pulled);
            variance -= by[index] * total[(place, column)];
        }
        let own = total[(column, column)];
        if own <= 0.0 || variance <= LEAST_SHARE * own {
            return None;
        }
        let scattered =
            self.noise.score_variance(self.twin.runs.period_s, &panel.projected(column, &places, &by));
        let inflated = variance.max(scattered);
        let (value, std_err) = (score / variance, inflated.sqrt() / variance);
        Some(Score {
            value,
            std_err,
            z: score / inflated.sqrt(),
            share: variance / own,
            variance_inflation: inflated / variance,
        })
    }

    /// The greatest [`Score::variance_inflation`] of regressors that may be added to a state; 1 where there is none.
    pub fn variance_inflation(&self, state: &State, regressors: &[Regressor]) -> f64 {
        let panel = self.panel(state, regressors, false);
        let total = panel.products().total(None);
        let first = self.first_further(state);
        let active = self.active(state);
        (first..first + regressors.len())
            .filter_map(|column| self.score(&panel, &total, state, &active, column))
            .map(|score| score.variance_inflation)
            .fold(1.0, f64::max)
    }
}
