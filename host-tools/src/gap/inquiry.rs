//! One state of knowledge about some runs: how far a column, or an added effect, explains what is left.

use super::joint::{Prior, Products, solve};
use super::noise::Noise;
use super::panel::{Fixed, Panel, residual};
use super::twin::{State, Twin};
use super::whiten::Signal;
use crate::effects::{Candidate, Regressor, Switched};
use model_core::torque::TorqueModel;
use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

/// Columns of which base and effects leave less than this share are no columns of their own.
pub const LEAST_SHARE: f64 = 1e-3;

/// Steps in which times are looked for, s. They are long at first: the time at which a step explains most of a single run is drawn
/// towards that of the others' while these have none.
const TIME_STEPS: [f64; 7] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.12];

/// Rounds over the runs: the time of one depends on those of the others.
const TIME_ROUNDS: usize = 3;

/// A round that gains less, in χ², was the last.
const LEAST_ROUND: f64 = 1.0;

/// The runs under inquiry, and what is known of base and noise.
#[derive(Debug)]
pub struct Inquiry<'a, const N: usize> {
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
    /// Smooth functions in the runs under inquiry, whitened; 0 in clean runs.
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
    /// 1 where what is left scatters along the column as noise does, less where it scatters more: there a gain in χ² means less.
    pub caution: f64,
}

/// A state fitted with all its effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Base and effects.
    pub state: State,
    /// Sum of squares, the prior's charge included.
    pub loss: f64,
    /// Sum of squares of each run, without the charge.
    pub run_losses: Vec<f64>,
    /// About this state; columns of base, discrepancy, then effects.
    pub products: Products,
    /// Of base, discrepancy, then effects.
    pub covariance: DMatrix<f64>,
}

impl<const N: usize> Inquiry<'_, N> {
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
            matrix[(i, j)] * scale[i] * scale[j] + if i == j { 1e-10 } else { 0.0 }
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
        let cautious = variance.max(scattered);
        let (value, std_err) = (score / variance, cautious.sqrt() / variance);
        Some(Score {
            value,
            std_err,
            z: score / cautious.sqrt(),
            share: variance / own,
            caution: variance / cautious,
        })
    }

    /// The least [`Score::caution`] of regressors that may be added to a state; 1 where there is none.
    pub fn caution(&self, state: &State, regressors: &[Regressor]) -> f64 {
        let panel = self.panel(state, regressors, false);
        let total = panel.products().total(None);
        let first = self.first_further(state);
        let active = self.active(state);
        (first..first + regressors.len())
            .filter_map(|column| self.score(&panel, &total, state, &active, column))
            .map(|score| score.caution)
            .fold(1.0, f64::min)
    }

    /// Adds regressors to a state and fits all that is in it, the model made linear anew at each step.
    pub fn fit(&self, state: &State, regressors: &[(Regressor, f64)], steps: usize) -> Option<Fitted> {
        let mut state = state.clone();
        state.effects.extend_from_slice(regressors);
        let mut best = self.losses(&state);
        let mut solved = None;
        for _ in 0..steps {
            let panel = self.panel(&state, &[], false);
            let products = panel.products();
            let active = self.active(&state);
            let step = solve(&products.total(None), self.base, &self.prior, &self.offset(&state), &active)?;
            let mut share = 1.0;
            let mut moved = None;
            for _ in 0..5 {
                let next = self.step(&state, &step.values, share);
                let losses = self.losses(&next);
                if losses.0 <= best.0 {
                    moved = Some((next, losses));
                    break;
                }
                share *= 0.4;
            }
            let covariance = step.covariance;
            solved = Some((products, covariance));
            let Some((next, losses)) = moved else { break };
            let gained = best.0 - losses.0;
            state = next;
            best = losses;
            if gained < 0.1 {
                break;
            }
        }
        let panel = self.panel(&state, &[], false);
        let covariance = solved?.1;
        Some(Fitted { state, loss: best.0, run_losses: best.1, products: panel.products(), covariance })
    }

    fn step(&self, state: &State, values: &DVector<f64>, share: f64) -> State {
        let mut base = state.torque.to_array();
        for (value, step) in base.iter_mut().zip(values.iter()).take(self.base) {
            *value = (*value + share * step).max(0.0);
        }
        let mut next = State { torque: TorqueModel::from_array(base), ..state.clone() };
        for ((_, coefficient), step) in
            next.effects.iter_mut().zip(values.iter().skip(self.base + self.discrepancy.len()))
        {
            *coefficient += share * step;
        }
        next
    }

    /// What is left at a state, whitened, the discrepancy taken out, without the weights.
    pub fn plain(&self, state: &State) -> Signal {
        let runs = self.left(state).into_iter().zip(&self.noise.weights);
        runs.map(|(left, weights)| {
            left.iter().zip(weights).map(|(x, w)| if *w > 0.0 { x / w } else { 0.0 }).collect()
        })
        .collect()
    }

    /// Sum of squares with the prior's charge, and that of each run without it.
    fn losses(&self, state: &State) -> (f64, Vec<f64>) {
        let runs: Vec<f64> = self.left(state).iter().map(DVector::norm_squared).collect();
        let offset = self.offset(state);
        let charge = offset.dot(&(&self.prior.precision * &offset));
        let total = runs.iter().sum::<f64>() + charge;
        (if total.is_finite() { total } else { f64::INFINITY }, runs)
    }

    /// What is left at a state, whitened and weighted, the discrepancy taken out.
    fn left(&self, state: &State) -> Vec<DVector<f64>> {
        let left = residual(&self.twin, state);
        let mut white: Vec<DVector<f64>> = left
            .iter()
            .enumerate()
            .map(|(place, left)| DVector::from_vec(self.noise.whiten(self.twin.runs, place, left)))
            .collect();
        if let Some(factor) = &self.factor {
            let mut right = DVector::zeros(self.discrepancy.len());
            for (signals, white) in self.discrepancy.runs.iter().zip(&white) {
                right += signals.tr_mul(white);
            }
            factor.solve_mut(&mut right);
            for (signals, white) in self.discrepancy.runs.iter().zip(&mut white) {
                white.gemv(-1.0, signals, &right, 1.0);
            }
        }
        white
    }

    /// Looks for the times of the last effect's steps between those that were tried, run by run.
    pub fn sharpen_times(&self, fitted: &mut Fitted) {
        let Some((Regressor::Switch(what, times), _)) = fitted.state.effects.last().cloned() else {
            return;
        };
        let mut times = times.to_vec();
        for _ in 0..TIME_ROUNDS {
            let before = fitted.loss;
            let mut parts: Vec<Part> = (0..times.len())
                .map(|run| self.part(&with_times(&fitted.state, what, &times), run))
                .collect();
            let mut loss = self.joint_loss(&parts);
            let mut moved = false;
            for run in (0..times.len()).filter(|&run| !self.twin.runs.runs[run].clean) {
                let end = self.twin.runs.runs[run].rows.last().map_or(0.0, |row| row.time);
                for by in TIME_STEPS.into_iter().flat_map(|step| [-step, step]) {
                    let at = times[run] + by;
                    if !(0.0..end).contains(&at) {
                        continue;
                    }
                    let kept = std::mem::replace(&mut times[run], at);
                    let part = self.part(&with_times(&fitted.state, what, &times), run);
                    let part = std::mem::replace(&mut parts[run], part);
                    let tried = self.joint_loss(&parts);
                    if tried < loss {
                        (loss, moved) = (tried, true);
                    } else {
                        times[run] = kept;
                        parts[run] = part;
                    }
                }
            }
            if moved && let Some(again) = self.fit(&with_times(&fitted.state, what, &times), &[], 2) {
                *fitted = again;
            }
            if before - fitted.loss < LEAST_ROUND {
                break;
            }
        }
    }

    /// What one run adds to the sum of squares.
    fn part(&self, state: &State, run: usize) -> Part {
        let predicted = self.twin.predict(run, state);
        let rows = &self.twin.runs.runs[run].rows;
        let left: Vec<f64> = rows.iter().zip(predicted).map(|(row, p)| row.power - p).collect();
        let white = DVector::from_vec(self.noise.whiten(self.twin.runs, run, &left));
        let along =
            self.discrepancy.runs.get(run).map_or(DVector::zeros(0), |signals| signals.tr_mul(&white));
        Part { square: white.norm_squared(), along }
    }

    /// Sum of squares of all runs, the discrepancy taken out; without the prior's charge.
    fn joint_loss(&self, parts: &[Part]) -> f64 {
        let square: f64 = parts.iter().map(|part| part.square).sum();
        let Some(factor) = &self.factor else { return square };
        let mut along = DVector::zeros(self.discrepancy.len());
        for part in parts {
            along += &part.along;
        }
        square - along.dot(&factor.solve(&along))
    }

    /// As [`Fitted::loss`] with a run left out, to first order.
    pub fn loss_without(&self, fitted: &Fitted, run: usize) -> f64 {
        let active = self.active(&fitted.state);
        let offset = self.offset(&fitted.state);
        solve(&fitted.products.total(Some(run)), self.base, &self.prior, &offset, &active)
            .map_or(f64::INFINITY, |solved| solved.loss)
    }
}

/// Of one run: its sum of squares, and its products with the discrepancy.
struct Part {
    square: f64,
    along: DVector<f64>,
}

/// The state with other times of its last effect's steps.
fn with_times(state: &State, what: Switched, times: &[f64]) -> State {
    let mut state = state.clone();
    if let Some((regressor, _)) = state.effects.last_mut() {
        *regressor = Regressor::Switch(what, times.into());
    }
    state
}

/// A candidate with its fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    /// What was added.
    pub candidate: Candidate,
    /// The fit with it.
    pub fitted: Fitted,
    /// Loss with what its search costs.
    pub charged: f64,
}

impl Rival {
    /// Coefficients of what was added.
    pub fn coefficients(&self) -> Vec<f64> {
        let effects = &self.fitted.state.effects;
        let from = effects.len() - self.candidate.regressors.len();
        effects[from..].iter().map(|(_, coefficient)| *coefficient).collect()
    }

    /// Whether sign and size of the coefficients are those that the effect can have. Of several columns only the size counts.
    pub fn is_plausible(&self) -> bool {
        let (low, high) = self.candidate.range;
        match self.coefficients()[..] {
            [only] => only >= low && only <= high,
            // Of single runs each is one of its own, of one run its own; the parts of a direction make up one.
            ref several if self.candidate.regressors.iter().all(|regressor| regressor.run().is_some()) => {
                several.iter().all(|c| *c >= low && *c <= high)
            }
            ref several => several.iter().map(|c| c * c).sum::<f64>().sqrt() <= high,
        }
    }
}
