//! Which run disagrees with its robot's base more than runs do: the first question of `gmr gap`,
//! from sums.
//!
//! ```text
//! q = (Σ e² − 2 bᵀ Jᵀe + bᵀ JᵀJ b) / rows      b: what the robot differs from the reference by
//! ```
//!
//! ln q of a run is held against all runs of the fleet. That a run disagrees is all that its sums
//! tell: which effect it is needs its rows (`gmr gap`). What lasts for a small part of a run, and
//! what is as large on every run, is not seen here.

use fit::run_gram::RunGram;
use nalgebra::DVector;
use numerics::robust::{median, scale};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::base::{Run, by_robot};
use super::drift::{Drift, FALSE_NAMES};
use super::outlier::{MAD_EFFICIENCY, in_common, unchanged};

/// Fewest runs from which their scatter is known.
const LEAST_RUNS: usize = 20;

/// Fewest runs that make a base: of fewer, a run is mostly its own base.
const LEAST_OF_BASE: usize = 3;

/// A run that its robot's coefficients do not explain as well as others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Disagreement {
    /// Which run.
    pub run: String,
    /// Root mean square of measured less predicted power, W, with the robot's own coefficients.
    pub rmse_w: f64,
    /// The same of the middle run of the fleet, W.
    pub usual_w: f64,
    /// How far it is from it, in standard deviations of ln RMSE over runs.
    pub deviations: f64,
}

impl Disagreement {
    /// One sentence.
    pub fn sentence(&self) -> String {
        format!(
            "{}: {:.4} W from its robot's coefficients where {:.4} W is usual ({:.1} standard deviations)",
            self.run, self.rmse_w, self.usual_w, self.deviations
        )
    }
}

/// What was asked, and what came of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Disagreements {
    /// Runs beyond chance, in their order.
    #[serde(rename = "found")]
    pub runs: Vec<Disagreement>,
    /// Runs that were asked.
    pub asked: usize,
    /// What ln RMSE must be above its median, in standard deviations.
    pub threshold: Option<f64>,
    /// Why nothing is said.
    pub silent: Option<String>,
}

/// Holds every run against its robot's base, and what is left against what is left of other runs.
pub(super) fn disagreements(runs: &[&RunGram], drift: &Drift) -> Disagreements {
    let robots = unchanged(runs, drift);
    let common = in_common(&robots);
    let base_of = |name: &str| {
        let robot = robots.iter().find(|robot| robot.name == name);
        robot
            .filter(|robot| robot.runs.len() >= LEAST_OF_BASE)
            .map_or_else(|| common.clone(), |robot| robot.base())
    };
    let mut each: Vec<(&str, f64)> = Vec::new();
    for (name, runs) in by_robot(runs) {
        let base = base_of(name);
        each.extend(runs.iter().filter_map(|run| Some((run.name, rmse(run, &base)?))));
    }
    each.sort_by(|a, b| a.0.cmp(b.0));
    let mut answer = Disagreements { asked: each.len(), ..Disagreements::default() };
    if each.len() < LEAST_RUNS {
        answer.silent = Some(format!("{} runs; {LEAST_RUNS} tell how much runs disagree", each.len()));
        return answer;
    }
    let logs: Vec<f64> = each.iter().map(|(_, rmse)| rmse.ln()).collect();
    let (Some(middle), Some(spread)) = (median(&mut logs.clone()), scale(&logs)) else { return answer };
    let Ok(student) = StudentsT::new(0.0, 1.0, MAD_EFFICIENCY * (each.len() - 1) as f64) else {
        return answer;
    };
    let threshold = -student.inverse_cdf(FALSE_NAMES / each.len() as f64);
    answer.threshold = Some(threshold);
    answer.runs = each
        .iter()
        .zip(logs)
        .map(|((run, rmse), log)| Disagreement {
            run: (*run).to_owned(),
            rmse_w: *rmse,
            usual_w: middle.exp(),
            deviations: (log - middle) / spread,
        })
        .filter(|one| one.deviations > threshold)
        .collect();
    answer
}

/// Root mean square of what a base leaves of a run, W; none where there is nothing.
fn rmse(run: &Run<'_>, base: &DVector<f64>) -> Option<f64> {
    let squares = run.squares - 2.0 * base.dot(&run.score) + base.dot(&(&run.normal * base));
    // Within the rounding of its sums it is nothing.
    (squares > f64::EPSILON * run.squares).then(|| (squares / run.rows as f64).sqrt())
}
