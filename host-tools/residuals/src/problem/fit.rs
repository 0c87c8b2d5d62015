//! A state fitted with all its effects, the model made linear again at each step (Gauss and
//! Newton).

use model::effects::Regressor;
use nalgebra::{DMatrix, DVector};

use super::Problem;
use super::panel::Products;
use crate::noise::whiten::Signal;
use crate::predictor::State;
use crate::thresholds::problem::{HALVINGS, LEAST_STEP_GAIN};

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

/// A run's whitened residual, its sum of squares, and its products with the discrepancy.
#[derive(Debug, Clone)]
pub(crate) struct RunLoss {
    pub(super) white: DVector<f64>,
    pub(super) square: f64,
    pub(super) along: DVector<f64>,
}

impl Problem<'_> {
    /// Adds regressors to a state and fits all that is in it, the model made linear again at each
    /// step.
    pub fn fit(&self, state: &State, regressors: &[(Regressor, f64)], steps: usize) -> Option<Fitted> {
        let mut state = state.clone();
        state.effects.extend_from_slice(regressors);
        let mut best = self.losses(&state);
        let linear = |state: &State| {
            let products = self.panel(state, &[], &[]).products();
            let equations = self.factored(&products.total(None), state, self.active(state))?;
            Some((products, equations))
        };
        let (mut products, mut equations) = linear(&state)?;
        for _ in 0..steps {
            if best.0 - equations.loss() < LEAST_STEP_GAIN {
                break;
            }
            let values = equations.solution();
            let shares = (0..HALVINGS as i32).map(|halving| 0.5_f64.powi(halving));
            let mut tried = shares.map(|share| {
                let next = self.step(&state, &values, share);
                let losses = self.losses(&next);
                (next, losses)
            });
            let Some((next, losses)) = tried.find(|(_, losses)| losses.0 <= best.0) else { break };
            let gained = best.0 - losses.0;
            (state, best) = (next, losses);
            (products, equations) = linear(&state)?;
            if gained < LEAST_STEP_GAIN {
                break;
            }
        }
        Some(Fitted { state, loss: best.0, run_losses: best.1, products, covariance: equations.covariance() })
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

    /// Sum of squares with the prior's penalty, and that of each run without it.
    pub(super) fn losses(&self, state: &State) -> (f64, Vec<f64>) {
        let runs: Vec<RunLoss> =
            (0..self.predictor.runs.runs.len()).map(|run| self.run_loss(state, run)).collect();
        let along = self.along(&runs);
        let taken = self.factor.as_ref().map(|factor| factor.solve(&along));
        let losses: Vec<f64> = match &taken {
            None => runs.iter().map(|run| run.square).collect(),
            Some(taken) => {
                let of = |(run, products): (&RunLoss, &DMatrix<f64>)| {
                    run.square - 2.0 * run.along.dot(taken) + taken.dot(&(products * taken))
                };
                runs.iter().zip(&self.discrepancy.products).map(of).collect()
            }
        };
        let offset = self.offset(state);
        let penalty = offset.dot(&(&self.precision * &offset));
        let total = losses.iter().sum::<f64>() + penalty;
        (if total.is_finite() { total } else { f64::INFINITY }, losses)
    }

    /// What one run adds to the sum of squares.
    pub(super) fn run_loss(&self, state: &State, run: usize) -> RunLoss {
        if let Some(Some(known)) = self.still.get(run) {
            return known.clone();
        }
        let white = self.white(run, &self.predictor.predict(run, state));
        let along =
            self.discrepancy.runs.get(run).map_or(DVector::zeros(0), |signals| signals.tr_mul(&white));
        RunLoss { square: white.norm_squared(), white, along }
    }

    /// Sum of squares of all runs, the discrepancy taken out; without the prior's penalty.
    pub(super) fn without_discrepancy(&self, square: f64, along: &DVector<f64>) -> f64 {
        self.factor.as_ref().map_or(square, |factor| square - along.dot(&factor.solve(along)))
    }

    /// Products of all runs with the discrepancy.
    pub(super) fn along(&self, runs: &[RunLoss]) -> DVector<f64> {
        let mut along = DVector::zeros(self.discrepancy.len());
        runs.iter().for_each(|run| along += &run.along);
        along
    }

    /// The whitened, weighted residual of one run from what is predicted.
    pub(super) fn white(&self, run: usize, predicted: &[f64]) -> DVector<f64> {
        let residual = self.predictor.left_by(run, predicted);
        DVector::from_vec(self.noise.whiten(self.predictor.runs, run, &residual))
    }

    /// The whitened residual of a state without discrepancy and weights.
    pub fn plain(&self, state: &State) -> Signal {
        let runs = 0..self.predictor.runs.runs.len();
        let mut white: Vec<DVector<f64>> =
            runs.map(|run| self.white(run, &self.predictor.predict(run, state))).collect();
        if let Some(factor) = &self.factor {
            let signals = || self.discrepancy.runs.iter();
            let along: DVector<f64> =
                signals().zip(&white).map(|(signals, white)| signals.tr_mul(white)).sum();
            let taken = factor.solve(&along);
            for (signals, white) in signals().zip(&mut white) {
                white.gemv(-1.0, signals, &taken, 1.0);
            }
        }
        self.noise.unweighted(white.iter().map(DVector::as_slice))
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

#[cfg(test)]
mod tests {
    use model_core::torque::{Drive, TorqueModel};

    use super::super::example::{bare, runs};
    use super::super::open::factor;
    use super::super::panel::Fixed;
    use crate::predictor::{Predictor, State};

    /// The loss by sums of products is the square of what the regression on a discrepancy leaves.
    #[test]
    fn a_loss_is_the_square_of_what_the_discrepancy_leaves() {
        let runs = runs([0.4, 0.9]);
        let torque = TorqueModel::from_array([0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0]);
        let mut problem = bare(Predictor::new(&runs, Drive::Regenerative), torque, 0);
        let lengths: Vec<usize> = runs.runs.iter().map(|run| run.rows.len()).collect();
        let signal = |of: fn(f64) -> f64| {
            let run = |&rows: &usize| (0..rows).map(|row| of(row as f64 / rows as f64)).collect();
            lengths.iter().map(run).collect()
        };
        problem.discrepancy = Fixed::new(&[signal(|_| 0.05), signal(|t| 0.1 * t * t)], &lengths);
        problem.factor = factor(&problem.discrepancy);
        let state = State { torque, effects: Vec::new() };
        let left = problem.plain(&state);
        let (total, of_runs) = problem.losses(&state);
        for (loss, left) in of_runs.iter().zip(&left) {
            let square: f64 = left.iter().map(|x| x * x).sum();
            assert!((loss / square - 1.0).abs() < 1e-9, "{loss} {square}");
        }
        assert!((total - of_runs.iter().sum::<f64>()).abs() < 1e-9 * total);
        let bare = bare(problem.predictor, torque, 0).losses(&state).0;
        assert!(total < 0.99 * bare, "{total} {bare}");
    }
}
