//! Algorithm 1: projected gradient descent with RMSProp, on the Gram matrix.
//!
//! g_k = ∇f(β_k), m_k = g_k, V_k = (1 − c) Σ c^(k−i) g_i², α_k = α / √k, β_(k+1) = P_Ω(β_k − α_k
//! m_k / √V_k). Columns are scaled to unit root mean square first, so one learning rate can serve
//! all coefficients. An iteration costs a 15 × 15 product, whatever the number of samples in the
//! matrix.

use model_core::eq18::REGRESSORS;

use super::gram;

/// The problem of Eq. 18.
type Scaled = gram::Scaled<REGRESSORS>;
/// Its coefficients.
pub type Vector = gram::Vector<REGRESSORS>;

/// Settings of Algorithm 1, for the scaled problem.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// α, one a coefficient.
    pub learning_rate: Vector,
    /// c, 0.9 ≤ c ≤ 0.99 in the paper.
    pub momentum: f64,
    /// l_i and u_i of Eq. 22.
    pub lower: Vector,
    /// l_i and u_i of Eq. 22.
    pub upper: Vector,
    /// Stop where no component of the projected gradient is above this.
    pub tolerance: f64,
    /// Stop after this many iterations.
    pub most_iterations: u64,
}

impl Default for Settings {
    /// α = 0.001 and c = 0.9, as in the paper's simulation.
    fn default() -> Self {
        Self {
            learning_rate: Vector::repeat(0.001),
            momentum: 0.9,
            lower: Vector::zeros(),
            upper: Vector::repeat(f64::INFINITY),
            tolerance: 1e-9,
            most_iterations: 2_000_000,
        }
    }
}

/// How the descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The projected gradient is below the tolerance.
    Converged,
    /// Steps have become smaller than rounding.
    Stalled,
    /// The iterations allowed were used up.
    IterationLimit,
    /// The cost is no longer a number.
    Diverged,
}

/// Where the descent ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Coefficients, scaled as the problem was.
    pub beta: Vector,
    /// How it ended.
    pub ending: Ending,
    /// Iterations taken.
    pub iterations: u64,
}

/// Runs Algorithm 1 from `start`.
pub fn solve(problem: &Scaled, start: Vector, settings: &Settings) -> Solution {
    let mut beta = project(start, settings);
    let mut mean_square = Vector::zeros();
    // The best iterate so far: near the optimum RMSProp circles it with the size of its step.
    let mut best = (f64::INFINITY, beta);
    for iteration in 1..=settings.most_iterations {
        let gradient = problem.gradient(&beta);
        // ½ βᵀXβ − βᵀp, from the product that the gradient already holds.
        let cost = beta.dot(&(gradient - problem.xp)) / 2.0;
        if !cost.is_finite() {
            return Solution { beta: best.1, ending: Ending::Diverged, iterations: iteration };
        }
        if cost < best.0 {
            best = (cost, beta);
        }
        if projected_gradient(&beta, &gradient, settings) <= settings.tolerance {
            return Solution { beta, ending: Ending::Converged, iterations: iteration - 1 };
        }
        mean_square =
            settings.momentum * mean_square + (1.0 - settings.momentum) * gradient.component_mul(&gradient);
        let decay = 1.0 / (iteration as f64).sqrt();
        let step = Vector::from_fn(|i, _| {
            if gradient[i] == 0.0 {
                0.0
            } else {
                settings.learning_rate[i] * decay * gradient[i] / mean_square[i].sqrt()
            }
        });
        let next = project(beta - step, settings);
        if next == beta {
            return Solution { beta, ending: Ending::Stalled, iterations: iteration };
        }
        beta = next;
    }
    Solution { beta: best.1, ending: Ending::IterationLimit, iterations: settings.most_iterations }
}

/// P_Ω of Eq. 23 for a box.
fn project(beta: Vector, settings: &Settings) -> Vector {
    beta.zip_zip_map(&settings.lower, &settings.upper, |value, low, high| value.max(low).min(high))
}

/// Largest component of the gradient that a step within the box could follow.
fn projected_gradient(beta: &Vector, gradient: &Vector, settings: &Settings) -> f64 {
    beta.iter()
        .zip(gradient)
        .zip(settings.lower.iter().zip(&settings.upper))
        .filter(|((value, slope), (low, high))| {
            !(**slope > 0.0 && *value <= low || **slope < 0.0 && *value >= high)
        })
        .map(|((_, slope), _)| slope.abs())
        .fold(0.0, f64::max)
}
