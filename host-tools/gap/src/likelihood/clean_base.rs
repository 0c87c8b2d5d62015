//! The base anew, by clean runs.
//!
//! Coefficients are fitted to a model of filtered speeds. Here the model is asked before the filter
//! ([`logs::runs::Rows::Before`]), and some of what those coefficients made up for is not there: the
//! base is fitted once more, from where it was.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::priors::{BASE_HELD, BASE_SETTLED, BASE_STEPS};
use model_core::torque::TorqueModel;
use residuals::predictor::{Predictor, State};

/// The torque model to which clean runs are nearest (Levenberg and Marquardt); as it was, where
/// there are none.
pub fn fitted(predictor: &Predictor<'_>, start: TorqueModel<f64>, parameters: usize) -> TorqueModel<f64> {
    let clean: Vec<usize> =
        (0..predictor.runs.runs.len()).filter(|&run| predictor.runs.runs[run].clean).collect();
    let problem = Problem { predictor, clean, parameters };
    let (mut torque, mut held) = (start, BASE_HELD);
    let mut squares = problem.squares(&torque);
    for _ in 0..BASE_STEPS {
        let Some((gram, along)) = problem.sums(&torque) else { break };
        let lower = std::iter::successors(Some(held), |held| Some(10.0 * held))
            .take_while(|held| *held < BASE_HELD.recip())
            .find_map(|held| {
                let next = stepped(&torque, &gram, &along, held)?;
                let squares_there = problem.squares(&next);
                (squares_there < squares).then_some((next, squares_there, held))
            });
        let Some((next, squares_there, by)) = lower else { break };
        let has_settled = squares - squares_there < BASE_SETTLED * squares;
        (torque, squares, held) = (next, squares_there, 0.1 * by);
        if has_settled {
            break;
        }
    }
    torque
}

struct Problem<'a> {
    predictor: &'a Predictor<'a>,
    clean: Vec<usize>,
    parameters: usize,
}

impl Problem<'_> {
    fn residual(&self, run: usize, at: &[f64]) -> DVector<f64> {
        let rows = self.predictor.runs.runs[run].rows.iter().zip(at);
        DVector::from_iterator(at.len(), rows.map(|(row, at)| row.power - at))
    }

    fn squares(&self, torque: &TorqueModel<f64>) -> f64 {
        let state = State { torque: *torque, effects: Vec::new() };
        let of = |&run: &usize| self.residual(run, &self.predictor.predict(run, &state)).norm_squared();
        self.clean.par_iter().map(of).sum()
    }

    /// Products of slopes, and of slopes with what is left; `None` without clean runs.
    fn sums(&self, torque: &TorqueModel<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let state = State { torque: *torque, effects: Vec::new() };
        let of = |&run: &usize| {
            let at = self.predictor.predict(run, &state);
            let slopes = self.predictor.base_slopes(run, &state, &at, self.parameters);
            let slopes = DMatrix::from_fn(at.len(), slopes.len(), |row, column| slopes[column][row]);
            (slopes.tr_mul(&slopes), slopes.tr_mul(&self.residual(run, &at)))
        };
        self.clean.par_iter().map(of).reduce_with(|a, b| (a.0 + b.0, a.1 + b.1))
    }
}

/// A step whose equations are held back by a share of their diagonal.
fn stepped(
    torque: &TorqueModel<f64>,
    gram: &DMatrix<f64>,
    along: &DVector<f64>,
    held: f64,
) -> Option<TorqueModel<f64>> {
    let scales = gram.diagonal().map(|x| x.max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, j| {
        gram[(i, j)] * scales[i] * scales[j] + if i == j { held } else { 0.0 }
    });
    let step = Cholesky::new(scaled)?.solve(&along.component_mul(&scales)).component_mul(&scales);
    let mut values = torque.to_array();
    values.iter_mut().zip(step.iter()).for_each(|(value, step)| *value += step);
    Some(torque.with_array(values))
}
