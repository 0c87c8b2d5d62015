//! Known dynamics of the robot and its DC motors: one model, of which each source uses some terms.
//!
//! A wheel's torque τ is a sum of [`Term`]s, its motor's current i = τ/(n Kt) with the gear ratio
//! n, its voltage V = R i + Ke n w, and the power P = Σ V i over the wheels (Kim and Kim 2012,
//! Morales and Mendoza 2018). With Ke = Kt, as energy asks for, that is
//!
//! ```text
//! P = Σ τ w + κ τ²,   κ = R/(n Kt)²
//! ```
//!
//! The sources read κ and the constants of τ from data sheets. A log has none, so they are fitted
//! by least squares to the training points, each at least 0; they include losses of gears and
//! drives. A source without a payload treats the mass as a constant: it is fitted with the others,
//! and a point's mass is not used. The inductance is left out: its time constant is a millisecond,
//! far below the filter of the logs.

mod term;
#[cfg(test)]
mod tests;

use fit::gram::Gram;
use fit::nnls;
use nalgebra::{Const, SMatrix, SVector};
use numerics::levenberg_marquardt::{self, Bounds, LeastSquares, Tolerances};
use support::error::{Error, Result};

pub use self::term::Term;
use super::baseline::{Baseline, Parameter, named};
use super::point::Point;
use super::training;

/// Most constants: κ, then those of the terms.
const MOST: usize = 6;

type Constants = SVector<f64, MOST>;
type Descent = levenberg_marquardt::Descent<Const<MOST>>;

/// More training points than these are thinned evenly: time grows with them, and filtered
/// neighbours repeat each other.
const MOST_POINTS: usize = 20_000;
/// From these the starts are tried.
const TRIAL_POINTS: usize = 1_000;
const MOST_STEPS: u32 = 300;
/// A step that lowers the cost by less than this share of Σ P² is the last.
const SMALLEST_GAIN: f64 = 1e-12;

/// So is one that lowers it by less than this share of it. Where a log's power does not grow with
/// the speed, the winding loss takes all of it: κ grows and the torques shrink without end, but the
/// model's power stays.
const SMALLEST_SHARE: f64 = 1e-5;

/// Shares of the power that are mechanical, from which the search for κ starts.
const MECHANICAL_SHARES: [f64; 5] = [1.0, 0.7, 0.4, 0.1, 0.01];

/// Where the power of a braking wheel goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Braking {
    /// Back to the battery: it counts, with its sign.
    Regenerates,
    /// It is lost: no wheel's power is below 0.
    Dissipates,
}

/// The model with the terms of one source.
pub struct Dynamics {
    name: &'static str,
    terms: &'static [Term],
    braking: Braking,
    constants: Option<Constants>,
}

impl Dynamics {
    /// Not fitted.
    ///
    /// # Panics
    /// With more terms than the constants have places for.
    pub fn new(name: &'static str, terms: &'static [Term], braking: Braking) -> Self {
        assert!(terms.len() < MOST, "{name} has too many terms");
        Self { name, terms, braking, constants: None }
    }

    /// Power of a point, W; `each` receives the torque of every wheel that draws or returns power.
    fn power(&self, constants: &Constants, point: &Point, mut each: impl FnMut(&Torque)) -> f64 {
        let mut sum = 0.0;
        for wheel in point.wheels.iter() {
            let mut torque = Torque { speed: wheel.speed, ..Torque::default() };
            for ((term, per_unit), constant) in
                self.terms.iter().zip(&mut torque.per_unit).zip(constants.iter().skip(1))
            {
                *per_unit = term.torque(wheel, point);
                torque.sum += constant * *per_unit;
            }
            let power = torque.sum * torque.speed + constants[0] * torque.sum * torque.sum;
            if power < 0.0 && self.braking == Braking::Dissipates {
                continue;
            }
            each(&torque);
            sum += power;
        }
        sum
    }
}

/// One wheel's torque, N m.
#[derive(Default)]
struct Torque {
    /// Of each term, for a constant of 1.
    per_unit: [f64; MOST - 1],
    sum: f64,
    /// Of the wheel, rad/s.
    speed: f64,
}

impl Baseline for Dynamics {
    /// The best end of a search from several shares of winding loss.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.constants = None;
        training::check(self.name, training)?;
        let trial = Problem { model: self, points: training::thin(training, TRIAL_POINTS) };
        let ends = trial.starts().into_iter().map(|start| trial.descend(start));
        let best = ends.min_by(|a, b| a.cost.total_cmp(&b.cost)).map(|end| end.parameters);
        let all = Problem { model: self, points: training::thin(training, MOST_POINTS) };
        let end = all.descend(best.unwrap_or_default());
        if !end.ending.has_converged() {
            return Err(Error::failed(format!(
                "{}: the search for its constants had not ended after {MOST_STEPS} steps",
                self.name
            )));
        }
        self.constants = Some(end.parameters);
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let unfitted = || Error::failed(format!("{}: not fitted", self.name));
        let constants = self.constants.ok_or_else(unfitted)?;
        Ok(points.iter().map(|point| self.power(&constants, point, |_| ())).collect())
    }

    /// κ, then the constants of the terms.
    fn parameters(&self) -> Vec<Parameter> {
        let Some(constants) = &self.constants else { return Vec::new() };
        let symbols = std::iter::once(("κ", "W/(N m)²")).chain(self.terms.iter().map(|term| term.symbol()));
        named(symbols, constants.as_slice())
    }
}

/// The squared residuals of training points.
struct Problem<'a> {
    model: &'a Dynamics,
    points: Vec<Point>,
}

impl Problem<'_> {
    fn descend(&self, start: Constants) -> Descent {
        let squares: f64 = self.points.iter().map(|point| point.power.powi(2)).sum();
        let tolerances = Tolerances {
            steps: MOST_STEPS,
            cost: SMALLEST_GAIN * squares,
            cost_share: SMALLEST_SHARE,
            ..Tolerances::default()
        };
        levenberg_marquardt::descend(self, &start, &Bounds::non_negative(&start), &tolerances)
    }

    /// Without winding loss the power is linear in the constants; with it they are smaller, and κ
    /// carries the rest.
    fn starts(&self) -> Vec<Constants> {
        let mut gram = Gram::<MOST>::default();
        gram.extend(self.points.iter().map(|point| {
            let mut row = [0.0; MOST];
            self.model.power(&Constants::zeros(), point, |torque| {
                for (x, per_unit) in row.iter_mut().skip(1).zip(torque.per_unit) {
                    *x += per_unit * torque.speed;
                }
            });
            (row, point.power)
        }));
        let problem = gram.scaled();
        let linear = problem.unscale(&nnls::solve(&problem).beta);
        let (mut power, mut squares) = (0.0, 0.0);
        for point in &self.points {
            power += self.model.power(&linear, point, |torque| squares += torque.sum * torque.sum);
        }
        let start = |share: f64| {
            let mut start = share * linear;
            if squares > 0.0 {
                start[0] = training::positive_part((1.0 - share) * power / (share * share * squares));
            }
            start
        };
        MECHANICAL_SHARES.map(start).to_vec()
    }
}

impl LeastSquares<Const<MOST>> for Problem<'_> {
    fn cost(&self, constants: &Constants) -> f64 {
        let residual = |point: &Point| point.power - self.model.power(constants, point, |_| ());
        self.points.iter().map(|point| residual(point).powi(2)).sum()
    }

    fn derivatives(&self, constants: &Constants) -> (Constants, SMatrix<f64, MOST, MOST>) {
        let mut gradient = Constants::zeros();
        let mut hessian = SMatrix::<f64, MOST, MOST>::zeros();
        for point in &self.points {
            let mut slope = Constants::zeros();
            let power = self.model.power(constants, point, |torque| {
                slope[0] += torque.sum * torque.sum;
                let per_torque = torque.speed + 2.0 * constants[0] * torque.sum;
                for (slope, per_unit) in slope.iter_mut().skip(1).zip(torque.per_unit) {
                    *slope += per_torque * per_unit;
                }
            });
            gradient.axpy(power - point.power, &slope, 1.0);
            hessian.ger(1.0, &slope, &slope, 1.0);
        }
        (gradient, hessian)
    }
}
