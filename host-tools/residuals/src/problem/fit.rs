//! A state fitted with all its effects, the model made linear again at each step (Gauss and
//! Newton).

use model::effects::Regressor;
use nalgebra::{DMatrix, DVector};

use super::Problem;
use super::panel::Products;
use crate::noise::whiten::Signal;
use crate::predictor::State;
use crate::thresholds::problem::{HALVINGS, LEAST_STEP_GAIN, SHORTER};

/// A state fitted with all its effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Base and effects.
    pub state: State,
    /// Sum of squares, the prior's penalty included.
    pub loss: f64,
    /// Sum of squares of each run, without it.
    pub run_losses: Vec<f64>,
    /// About this state; columns of base, discrepancy, then effects.
    pub products: Products,
    /// Of base, discrepancy, then effects.
    pub covariance: DMatrix<f64>,
}

impl Problem<'_> {
    /// Adds regressors to a state and fits all that is in it, the model made linear again at each
    /// step.
    pub fn fit(&self, state: &State, regressors: &[(Regressor, f64)], steps: usize) -> Option<Fitted> {
        let mut state = state.clone();
        state.effects.extend_from_slice(regressors);
        let mut best = self.losses(&state);
        let mut solved = None;
        for _ in 0..steps {
            let products = self.panel(&state, &[], &[]).products();
            let step = self.factored(&products.total(None), &state, self.active(&state))?;
            let values = step.solution();
            let mut share = 1.0;
            let mut moved = None;
            for _ in 0..HALVINGS {
                let next = self.step(&state, &values, share);
                let losses = self.losses(&next);
                if losses.0 <= best.0 {
                    moved = Some((next, losses));
                    break;
                }
                share *= SHORTER;
            }
            solved = Some(step);
            let Some((next, losses)) = moved else { break };
            let gained = best.0 - losses.0;
            state = next;
            best = losses;
            if gained < LEAST_STEP_GAIN {
                break;
            }
        }
        let products = self.panel(&state, &[], &[]).products();
        Some(Fitted { state, loss: best.0, run_losses: best.1, products, covariance: solved?.covariance() })
    }

    /// Start for the fit of a regressor: the coefficient with the least loss; `None` where the loss
    /// is less without it.
    pub(crate) fn best_start(
        &self,
        state: &State,
        regressor: &Regressor,
        starts: impl Iterator<Item = f64>,
    ) -> Option<f64> {
        let loss = |coefficient: f64| {
            let mut tried = state.clone();
            tried.effects.push((regressor.clone(), coefficient));
            self.losses(&tried).0
        };
        let (start, least) = starts.map(|start| (start, loss(start))).min_by(|a, b| a.1.total_cmp(&b.1))?;
        (least < self.losses(state).0).then_some(start)
    }

    fn step(&self, state: &State, values: &DVector<f64>, share: f64) -> State {
        let mut base = state.torque.to_array();
        for (value, step) in base.iter_mut().zip(values.iter()).take(self.base) {
            *value = (*value + share * step).max(0.0);
        }
        let mut next = State { torque: state.torque.with_array(base), ..state.clone() };
        for ((_, coefficient), step) in
            next.effects.iter_mut().zip(values.iter().skip(self.base + self.discrepancy.len()))
        {
            *coefficient += share * step;
        }
        next
    }

    /// The whitened residual of a state without discrepancy and weights.
    pub fn plain(&self, state: &State) -> Signal {
        self.noise.unweighted(self.residual(state).iter().map(DVector::as_slice))
    }

    /// Sum of squares with the prior's penalty, and that of each run without it.
    pub(super) fn losses(&self, state: &State) -> (f64, Vec<f64>) {
        let runs: Vec<f64> = self.residual(state).iter().map(DVector::norm_squared).collect();
        let offset = self.offset(state);
        let penalty = offset.dot(&(&self.precision * &offset));
        let total = runs.iter().sum::<f64>() + penalty;
        (if total.is_finite() { total } else { f64::INFINITY }, runs)
    }

    /// The whitened, weighted residual of a state without discrepancy.
    fn residual(&self, state: &State) -> Vec<DVector<f64>> {
        let residual = self.predictor.residual(state);
        let mut white: Vec<DVector<f64>> = residual
            .iter()
            .enumerate()
            .map(|(place, residual)| {
                DVector::from_vec(self.noise.whiten(self.predictor.runs, place, residual))
            })
            .collect();
        if let Some(factor) = &self.factor {
            let mut right = DVector::zeros(self.discrepancy.len());
            for (signals, white) in self.discrepancy.runs.iter().zip(&white) {
                right += signals.tr_mul(white);
            }
            let right = factor.solve(&right);
            for (signals, white) in self.discrepancy.runs.iter().zip(&mut white) {
                white.gemv(-1.0, signals, &right, 1.0);
            }
        }
        white
    }

    /// Covariance of base and effects. For each coefficient the greater variance counts: that of
    /// the equations, or the jackknife's (Quenouille and Tukey), field and clean runs separately.
    pub fn covariance(&self, fitted: &Fitted) -> DMatrix<f64> {
        let wanted: Vec<usize> =
            (0..self.base).chain(self.base + self.discrepancy.len()..fitted.covariance.nrows()).collect();
        let size = wanted.len();
        let mut variances = DVector::<f64>::zeros(size);
        for clean in [false, true] {
            let runs =
                (0..fitted.products.runs.len()).filter(|&run| self.predictor.runs.runs[run].clean == clean);
            let moves: Vec<DVector<f64>> = runs
                .filter_map(|run| {
                    let (state, without) = (&fitted.state, fitted.products.total(Some(run)));
                    let solved = self.factored(&without, state, self.active(state))?.solution();
                    Some(DVector::from_fn(size, |i, _| solved[wanted[i]]))
                })
                .collect();
            let count = moves.len() as f64;
            if moves.len() > 1 {
                let mean = moves.iter().sum::<DVector<f64>>() / count;
                let squares = moves.iter().map(|moved| (moved - &mean).map(|x| x * x)).sum::<DVector<f64>>();
                variances += squares * ((count - 1.0) / count);
            }
        }
        let formal = |i: usize, j: usize| fitted.covariance[(wanted[i], wanted[j])];
        let inflation =
            DVector::from_fn(size, |i, _| (variances[i] / formal(i, i).max(1e-300)).max(1.0).sqrt());
        DMatrix::from_fn(size, size, |i, j| formal(i, j) * inflation[i] * inflation[j])
    }

    /// Greatest ratio of the jackknife's variance to the equations' among the last `count`
    /// coefficients; at least 1.
    pub(crate) fn disagreement(&self, fitted: &Fitted, count: usize) -> f64 {
        let (jackknife, formal) = (self.covariance(fitted).diagonal(), fitted.covariance.diagonal());
        let pairs = jackknife.iter().rev().zip(formal.iter().rev()).take(count);
        pairs.map(|(jackknife, formal)| jackknife / formal.max(1e-300)).fold(1.0, f64::max)
    }
}
