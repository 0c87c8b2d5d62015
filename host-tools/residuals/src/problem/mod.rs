//! The regression problem of some runs: how much of the residual a column, or an added effect,
//! explains.

pub mod clean_delay;
pub mod delay;
#[cfg(test)]
pub(crate) mod example;
pub mod fit;
pub mod linear;
pub mod open;
pub mod panel;
pub mod times;

use std::ops::Range;

use model::effects::{Candidate, Regressor};
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector};
use numerics::least_squares::{Factored, NormalEquations, Prior};

use self::fit::RunLoss;
use self::linear::Linear;
use self::panel::{Fixed, Panel};
use super::noise::Noise;
use super::noise::whiten::Signal;
use super::predictor::{Predictor, State};
use super::thresholds::problem::RIDGE;
use super::types::penalty;

/// The runs in question, and what is known of base and noise.
#[derive(Debug)]
pub struct Problem<'a> {
    /// Model and runs.
    pub predictor: Predictor<'a>,
    /// The base from its own fit.
    pub centre: TorqueModel<f64>,
    /// How many parameters it has.
    pub base: usize,
    /// Inverse of the covariance of its fit.
    pub precision: DMatrix<f64>,
    /// The noise.
    pub noise: Noise,
    /// What the base gets wrong on clean runs too.
    pub discrepancy: Fixed,
    /// Its equations over all runs.
    pub factor: Option<Factored>,
    /// What each clean run adds to the sum of squares where no state changes that: effects are the
    /// field's, and the base stays.
    pub(crate) still: Vec<Option<RunLoss>>,
    /// Smooth functions in the runs in question, whitened; 0 in clean runs.
    pub smooth: Vec<Signal>,
    /// Variance that clean runs show of each other, relative to noise alone; at least 1.
    pub misfit: f64,
}

impl Problem<'_> {
    /// Difference between a state's base and that of its own fit.
    pub fn offset(&self, state: &State) -> DVector<f64> {
        let (now, then) = (state.torque.to_array(), self.centre.to_array());
        DVector::from_fn(self.base, |i, _| now[i] - then[i])
    }

    /// The base from its own fit.
    pub fn start(&self) -> State {
        State { torque: self.centre, effects: Vec::new() }
    }

    /// The |z| that is as rare with the clean runs' misfit as `z` is with noise alone.
    pub fn inflated(&self, z: f64) -> f64 {
        z * self.misfit.sqrt()
    }

    /// χ² that a candidate's search and its further columns gain by chance; it grows with the
    /// [misfit](Self::misfit) of clean runs.
    pub(crate) fn price(&self, candidate: &Candidate) -> f64 {
        self.misfit * penalty(candidate)
    }

    /// Columns that always move along with the base: the discrepancy, and the effects of a state.
    pub(crate) fn active(&self, state: &State) -> Range<usize> {
        self.base..self.first_further(state)
    }

    /// The first column after base, discrepancy and effects.
    pub fn first_further(&self, state: &State) -> usize {
        self.base + self.discrepancy.len() + state.effects.len()
    }

    /// Columns of the base, the discrepancy, a state's effects, further regressors, and whitened
    /// signals.
    pub(crate) fn panel(&self, state: &State, further: &[Regressor], signals: &[Signal]) -> Panel<'_> {
        let mut regressors: Vec<Regressor> =
            state.effects.iter().map(|(regressor, _)| regressor.clone()).collect();
        regressors.extend_from_slice(further);
        Panel::new(self, state, &regressors, signals)
    }

    /// The prior of a state, from the base's own fit.
    fn prior(&self, state: &State) -> Prior {
        Prior { precision: self.precision.clone(), offset: self.offset(state) }
    }

    /// The equations of the base and some columns of a panel about a state, by the panel's
    /// products.
    pub(crate) fn factored(
        &self,
        products: &DMatrix<f64>,
        state: &State,
        columns: impl IntoIterator<Item = usize>,
    ) -> Option<Factored> {
        let places: Vec<usize> = (0..self.base).chain(columns).collect();
        let mut equations = NormalEquations::from_products(products, &places);
        equations.add_prior(&self.prior(state));
        equations.factor(RIDGE).ok()
    }

    /// The problem made linear about a state, further regressors and whitened signals beside it.
    pub fn linear(&self, state: &State, further: &[Regressor], signals: &[Signal]) -> Option<Linear<'_>> {
        let panel = self.panel(state, further, signals);
        let products = panel.products().total(None);
        let factored = self.factored(&products, state, self.active(state))?;
        Some(Linear {
            noise: &self.noise,
            runs: self.predictor.runs,
            first: self.first_further(state),
            panel,
            products,
            factored,
        })
    }

    /// The greatest [`Score::variance_inflation`](linear::Score) of regressors that were added to a
    /// state and fitted; 1 without any. It is computed from the residual after the fit: before it,
    /// a step at a run's own time would count as noise.
    pub(crate) fn variance_inflation(&self, state: &State, regressors: &[Regressor], fitted: &State) -> f64 {
        let Some(linear) = self.linear(state, regressors, &[]) else { return 1.0 };
        let noise = match self.rough_residual(fitted) {
            Some(residual) => Noise { residual, ..self.noise.clone() },
            None => self.noise.clone(),
        };
        let linear = Linear { noise: &noise, ..linear };
        (0..regressors.len())
            .filter_map(|further| linear.score(further))
            .map(|score| score.variance_inflation)
            .fold(1.0, f64::max)
    }

    /// The whitened residual of a state, less its regression on discrepancy, effects and smooth
    /// functions.
    fn rough_residual(&self, state: &State) -> Option<Signal> {
        let panel = self.panel(state, &[], &self.smooth);
        let products = panel.products().total(None);
        let residual = products.ncols() - 1;
        let factored = self.factored(&products, state, self.base..residual)?;
        let all: Vec<usize> = (0..residual).collect();
        Some(panel.projected(residual, &all, &factored.solution()))
    }
}
