//! Nonlinear least squares within a box: Levenberg (1944) and Marquardt (1963), with a typed
//! ending.
//!
//! Each step solves (JᵀJ + λ D) δ = −Jᵀr, D the greatest diagonal of JᵀJ so far (Moré 1978), over
//! the parameters that are free: those at a bound towards which the gradient pushes stay there; one
//! that a step would take beyond a bound ends at it, and the step of the others is solved again. A
//! step that does not lower the cost, that ends at a cost which is not a number, or whose matrix
//! cannot be factored is taken back and λ raised.

mod problem;
#[cfg(test)]
mod tests;

use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DVector, DefaultAllocator, Dim, OMatrix, OVector};
use serde::Serialize;
use support::job;

pub use self::problem::{FromResiduals, LeastSquares};

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// Steps have become too small to matter beside the parameters.
    ConvergedByStep,
    /// Within the bounds the residual is orthogonal to every free column.
    ConvergedByGradient,
    /// The last step gained too little, and the model of the cost promised no more.
    ConvergedByCost,
    /// The matrix could not be factored however much it was damped: it is no JᵀJ.
    NotPositiveDefinite,
    /// The cost at the start, a derivative, or the cost at every step that was tried is not a
    /// number.
    NotFinite,
    /// Steps were still being found when their number was used up.
    OutOfSteps,
    /// Steps were still being found, but many of them together gained next to nothing: a valley
    /// without a lowest point, as data make it that no such model made.
    Stalled,
}

impl Ending {
    /// The parameters are a minimum, as far as the tolerances tell.
    pub fn has_converged(self) -> bool {
        matches!(self, Self::ConvergedByStep | Self::ConvergedByGradient | Self::ConvergedByCost)
    }
}

/// When to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Most steps, those that were taken back included.
    pub steps: u32,
    /// Gain of a step, as a share of the cost left,
    pub cost_share: f64,
    /// and as an amount, in units of the cost: below either a step gained too little.
    pub cost: f64,
    /// Length of a step as a share of the parameters', each in units of its own column's length.
    pub step: f64,
    /// Cosine of the angle between residual and column.
    pub gradient: f64,
    /// When to give up.
    pub patience: Patience,
}

/// So many steps that together gain less than this share of the cost are no way down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    /// Steps, those that were taken back included.
    pub steps: u32,
    /// Share of the cost.
    pub share: f64,
}

impl Patience {
    /// As long as steps are found.
    pub const ENDLESS: Self = Self { steps: u32::MAX, share: 0.0 };
}

impl Default for Tolerances {
    /// Some hundred roundings wide.
    fn default() -> Self {
        Self {
            steps: 1000,
            cost_share: 1e-14,
            cost: 0.0,
            step: 1e-12,
            gradient: 1e-10,
            patience: Patience::ENDLESS,
        }
    }
}

/// A box: lower and upper bound of each parameter, infinite where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds<D: Dim>
where
    DefaultAllocator: Allocator<D>,
{
    /// Least values.
    pub lower: OVector<f64, D>,
    /// Greatest values.
    pub upper: OVector<f64, D>,
}

impl<D: Dim> Bounds<D>
where
    DefaultAllocator: Allocator<D>,
{
    /// None, for vectors of this shape.
    pub fn none(like: &OVector<f64, D>) -> Self {
        Self { lower: like.map(|_| f64::NEG_INFINITY), upper: like.map(|_| f64::INFINITY) }
    }

    /// Every parameter is at least 0.
    pub fn non_negative(like: &OVector<f64, D>) -> Self {
        Self { lower: like.map(|_| 0.0), ..Self::none(like) }
    }

    /// The nearest point within.
    pub fn project(&self, parameters: &OVector<f64, D>) -> OVector<f64, D> {
        parameters.zip_zip_map(&self.lower, &self.upper, |value, low, high| value.max(low).min(high))
    }
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Descent<D: Dim>
where
    DefaultAllocator: Allocator<D>,
{
    /// The parameters, within the bounds.
    pub parameters: OVector<f64, D>,
    /// Their cost.
    pub cost: f64,
    /// Steps, those that were taken back included.
    pub steps: u32,
    /// Why it ended.
    pub ending: Ending,
}

/// λ of the first step.
const FIRST_DAMPING: f64 = 1e-3;
/// λ is divided by this after a step that gained at least [`GOOD`] of what was promised,
const EASE: f64 = 5.0;
/// multiplied by this after one that was taken back, or gained less than [`POOR`] of it (Moré
/// 1978),
const STIFFEN: f64 = 4.0;
const GOOD: f64 = 0.75;
const POOR: f64 = 0.25;
/// and stays within these: below rounding it does nothing, and at its most a step is rounding.
const DAMPING: (f64, f64) = (1e-14, 1e20);

/// Goes downhill from `start`, brought within the bounds, until one of the endings holds.
pub fn descend<D: Dim>(
    problem: &impl LeastSquares<D>,
    start: &OVector<f64, D>,
    bounds: &Bounds<D>,
    tolerances: &Tolerances,
) -> Descent<D>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    let parameters = bounds.project(start);
    let cost = problem.cost(&parameters);
    let mut descent = Descent { parameters, cost, steps: 0, ending: Ending::OutOfSteps };
    if !descent.cost.is_finite() {
        descent.ending = Ending::NotFinite;
        return descent;
    }
    let mut damping = FIRST_DAMPING;
    let mut local = Local::at(problem, &descent.parameters, bounds);
    let mut greatest = local.matrix.diagonal();
    // Steps and cost when the patience began.
    let mut since = (0, descent.cost);
    loop {
        if let Some(ending) = local.ending(descent.cost, tolerances) {
            descent.ending = ending;
            return descent;
        }
        // Until a step is taken, or none can be.
        loop {
            if descent.steps >= tolerances.steps {
                return descent;
            }
            let Patience { steps, share } = tolerances.patience;
            if descent.steps - since.0 >= steps {
                if since.1 - descent.cost <= share * since.1 {
                    descent.ending = Ending::Stalled;
                    return descent;
                }
                since = (descent.steps, descent.cost);
            }
            descent.steps += 1;
            job::point();
            let tried = local.step(&descent.parameters, damping, &greatest, bounds);
            let Some((next, length)) = tried else {
                damping *= STIFFEN;
                if damping > DAMPING.1 {
                    descent.ending = Ending::NotPositiveDefinite;
                    return descent;
                }
                continue;
            };
            let small = length <= tolerances.step * local.length(&descent.parameters);
            let promised = local.promise(&(&next - &descent.parameters));
            let cost = problem.cost(&next);
            if cost < descent.cost {
                let enough = tolerances.cost.max(tolerances.cost_share * cost.abs());
                let gained = descent.cost - cost;
                let little = gained <= enough && promised <= enough;
                (descent.parameters, descent.cost) = (next, cost);
                if gained >= GOOD * promised {
                    damping = (damping / EASE).max(DAMPING.0);
                } else if gained < POOR * promised {
                    damping *= STIFFEN;
                }
                if little || small {
                    descent.ending = if little { Ending::ConvergedByCost } else { Ending::ConvergedByStep };
                    return descent;
                }
                break;
            }
            if small || damping > DAMPING.1 {
                descent.ending = if cost.is_finite() { Ending::ConvergedByStep } else { Ending::NotFinite };
                return descent;
            }
            if cost.is_finite() && (0.0..=tolerances.cost).contains(&promised) && damping <= FIRST_DAMPING {
                // Next to undamped, and rounding is all that is left to gain.
                descent.ending = Ending::ConvergedByCost;
                return descent;
            }
            damping *= STIFFEN;
        }
        local = Local::at(problem, &descent.parameters, bounds);
        greatest = greatest.zip_map(&local.matrix.diagonal(), f64::max);
    }
}

/// Most steps of [`polish`].
const POLISHING: u32 = 20;

/// A first step longer than this share of the parameters: the search had not ended at a minimum.
const NEAR: f64 = 1e-3;

/// Undamped steps from the end of a search, each less than half as long as the one before. Near a
/// minimum the rounding of the cost hides steps of 10⁻⁸ of the parameters; that of the gradient
/// hides only 10⁻¹⁶ times the condition.
pub fn polish<D: Dim>(
    problem: &impl LeastSquares<D>,
    ended: &OVector<f64, D>,
    bounds: &Bounds<D>,
) -> OVector<f64, D>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    let (mut parameters, mut before) = (ended.clone(), f64::INFINITY);
    for _ in 0..POLISHING {
        let local = Local::at(problem, &parameters, bounds);
        if !local.is_finite || !local.is_gram {
            break;
        }
        let undamped = local.step(&parameters, 0.0, &local.matrix.diagonal(), bounds);
        let most = (0.5 * before).min(NEAR * local.length(&parameters));
        let Some((next, length)) = undamped.filter(|(_, length)| *length < most) else { break };
        (parameters, before) = (next, length);
    }
    parameters
}

/// The quadratic model of the cost about a point.
struct Local<D: Dim>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    gradient: OVector<f64, D>,
    matrix: OMatrix<f64, D, D>,
    /// Parameters that may move.
    free: Vec<usize>,
    is_finite: bool,
    /// No diagonal of a JᵀJ is negative, nor 0 where the gradient is not.
    is_gram: bool,
}

impl<D: Dim> Local<D>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    fn at(problem: &impl LeastSquares<D>, parameters: &OVector<f64, D>, bounds: &Bounds<D>) -> Self {
        let (gradient, matrix) = problem.derivatives(parameters);
        let is_finite = gradient.iter().chain(matrix.iter()).all(|value| value.is_finite());
        let count = parameters.len();
        let is_gram = (0..count).all(|i| matrix[(i, i)] > 0.0 || matrix[(i, i)] == 0.0 && gradient[i] == 0.0);
        let free = (0..count)
            .filter(|&i| {
                let inwards = gradient[i] < 0.0 && parameters[i] < bounds.upper[i]
                    || gradient[i] > 0.0 && parameters[i] > bounds.lower[i]
                    || gradient[i] == 0.0
                        && parameters[i] > bounds.lower[i]
                        && parameters[i] < bounds.upper[i];
                inwards && matrix[(i, i)] > 0.0
            })
            .collect();
        Self { gradient, matrix, free, is_finite, is_gram }
    }

    /// What can be said before a step is tried.
    fn ending(&self, cost: f64, tolerances: &Tolerances) -> Option<Ending> {
        if !self.is_finite {
            return Some(Ending::NotFinite);
        }
        if !self.is_gram {
            return Some(Ending::NotPositiveDefinite);
        }
        let root = cost.max(0.0).sqrt();
        let orthogonal =
            |&i: &usize| self.gradient[i].abs() <= tolerances.gradient * self.matrix[(i, i)].sqrt() * root;
        self.free.iter().all(orthogonal).then_some(Ending::ConvergedByGradient)
    }

    /// The damped step's end within the bounds, and its length in units of each column's length;
    /// `None` where the matrix cannot be factored.
    fn step(
        &self,
        parameters: &OVector<f64, D>,
        damping: f64,
        greatest: &OVector<f64, D>,
        bounds: &Bounds<D>,
    ) -> Option<(OVector<f64, D>, f64)> {
        let mut free = self.free.clone();
        let mut by = parameters.map(|_| 0.0);
        let mut square = 0.0;
        // One parameter at least meets its bound in each round but the last.
        while !free.is_empty() {
            // In units of each column's length, so that damping and Cholesky see no units.
            let scale: Vec<f64> = free.iter().map(|&i| self.matrix[(i, i)].sqrt()).collect();
            let mut matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| {
                self.matrix[(free[i], free[j])] / (scale[i] * scale[j])
            });
            for i in 0..free.len() {
                matrix[(i, i)] += damping * greatest[free[i]] / (scale[i] * scale[i]);
            }
            // What is at its bound already moves the others' minimum.
            let moved = &self.matrix * &by;
            let right =
                DVector::from_fn(free.len(), |i, _| -(self.gradient[free[i]] + moved[free[i]]) / scale[i]);
            let step = matrix.cholesky()?.solve(&right);
            let ends: Vec<f64> = free
                .iter()
                .zip(&step)
                .zip(&scale)
                .map(|((&i, step), scale)| parameters[i] + step / scale)
                .collect();
            let is_outside = |(&i, &end): (&usize, &f64)| end < bounds.lower[i] || end > bounds.upper[i];
            let meets: Vec<bool> = free.iter().zip(&ends).map(is_outside).collect();
            let last = !meets.contains(&true);
            for ((&i, end), meets) in free.iter().zip(&ends).zip(&meets) {
                if *meets || last {
                    by[i] = end.clamp(bounds.lower[i], bounds.upper[i]) - parameters[i];
                    square += self.matrix[(i, i)] * by[i] * by[i];
                }
            }
            free = free.iter().zip(&meets).filter(|(_, meets)| !**meets && !last).map(|(&i, _)| i).collect();
        }
        Some((bounds.project(&(parameters + by)), square.sqrt()))
    }

    /// Length of the free parameters in the same units.
    fn length(&self, parameters: &OVector<f64, D>) -> f64 {
        let square: f64 = self.free.iter().map(|&i| self.matrix[(i, i)] * parameters[i].powi(2)).sum();
        square.sqrt()
    }

    /// By how much the model of the cost falls over a step.
    fn promise(&self, by: &OVector<f64, D>) -> f64 {
        -2.0 * self.gradient.dot(by) - by.dot(&(&self.matrix * by))
    }
}
