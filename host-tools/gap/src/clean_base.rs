//! The base anew, by clean runs.
//!
//! Coefficients are fitted to a model of filtered speeds. Here the model is asked before the filter
//! ([`logs::runs::Rows::Before`]), and some of what those coefficients made up for is not there: the
//! base is fitted once more, from where it was.

use logs::runs::Runs;
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector, Dyn};
use numerics::levenberg_marquardt::{Bounds, LeastSquares, Tolerances, descend};
use rayon::prelude::*;
use residuals::predictor::{Predictor, State};
use residuals::problem::clean_delay;
use residuals::types::Base;

/// Steps, at most. Chosen: Gauss and Newton settle in a few, and some are taken back.
const STEPS: u32 = 40;
/// A step that lowers the squares by less than this share is the last. Derived: some 7,000 rows tell
/// of less than a hundredth of a standard error then.
const SETTLED: f64 = 1e-6;

/// The torque model to which clean runs are nearest.
pub fn fitted(clean: &Runs, base: &Base) -> TorqueModel<f64> {
    let clean_delay = clean_delay::estimate(clean, base);
    let predictor = Predictor { clean_delay, ..Predictor::new(clean, base.drive) };
    let start = base.torque.to_array();
    let parameters = start.len() - usize::from(!clean.robot.scrubs());
    let start = DVector::from_column_slice(&start[..parameters]);
    let problem = Problem { predictor, start: base.torque };
    let tolerances = Tolerances { steps: STEPS, cost_share: SETTLED, ..Tolerances::default() };
    problem.torque(&descend(&problem, &start, &Bounds::non_negative(&start), &tolerances).parameters)
}

struct Problem<'a> {
    predictor: Predictor<'a>,
    start: TorqueModel<f64>,
}

impl Problem<'_> {
    fn torque(&self, parameters: &DVector<f64>) -> TorqueModel<f64> {
        let mut values = self.start.to_array();
        values[..parameters.len()].copy_from_slice(parameters.as_slice());
        self.start.with_array(values)
    }

    fn state(&self, parameters: &DVector<f64>) -> State {
        State { torque: self.torque(parameters), effects: Vec::new() }
    }

    /// In the order of the runs, that sums are the same each time.
    fn of_each_run<T: Send>(&self, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
        (0..self.predictor.runs.runs.len()).into_par_iter().map(of).collect()
    }

    /// Power of a run that is predicted beyond the measured one, a row each.
    fn excess(&self, run: usize, predicted: &[f64]) -> DVector<f64> {
        let rows = self.predictor.runs.runs[run].rows.iter().zip(predicted);
        DVector::from_iterator(predicted.len(), rows.map(|(row, predicted)| predicted - row.power))
    }
}

impl LeastSquares<Dyn> for Problem<'_> {
    fn cost(&self, parameters: &DVector<f64>) -> f64 {
        let state = self.state(parameters);
        let of = |run| self.excess(run, &self.predictor.predict(run, &state)).norm_squared();
        self.of_each_run(of).into_iter().sum()
    }

    fn derivatives(&self, parameters: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let state = self.state(parameters);
        let size = parameters.len();
        let of = |run| {
            let predicted = self.predictor.predict(run, &state);
            let slopes = self.predictor.base_slopes(run, &state, &predicted, size);
            let slopes = DMatrix::from_fn(predicted.len(), size, |row, column| slopes[column][row]);
            (slopes.tr_mul(&self.excess(run, &predicted)), slopes.tr_mul(&slopes))
        };
        let none = (DVector::zeros(size), DMatrix::zeros(size, size));
        self.of_each_run(of).into_iter().fold(none, |a, b| (a.0 + b.0, a.1 + b.1))
    }
}
