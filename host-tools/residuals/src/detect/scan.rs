//! Effects that live in single runs, or begin at a time that is unknown.

use std::sync::Arc;

use model::effects::{
    Candidate, Detail, HALF_SLIP, PAYLOAD_MISLABEL, Regressor, Runs, STATIC_STEP, SURFACE_SWITCH, Switched,
};
use nalgebra::DVector;
use numerics::least_squares::{Factored, FurtherColumn};

use crate::predictor::State;
use crate::problem::Problem;
use crate::problem::panel::Panel;
use crate::problem::times::cost_of_a_time;
use crate::thresholds::detect::{
    MOST_ROLLING, MOST_TIMES, NO_DIFFERENCE, NOTHING_LEFT, RUN_ENDS, TIME_GRID_S,
};
use crate::thresholds::problem::{LEAST_SHARE, ONE_MASS};

/// The best time of a step in each run, and in all runs together.
struct Times {
    /// Per run: time and score.
    runs: Vec<Option<(f64, f64)>>,
    /// Of all runs.
    common: Option<(f64, f64)>,
    /// How many times were tried in a run.
    looks: usize,
}

/// Candidates for steps and for masses that were noted wrongly, as far as they are beyond noise, with
/// the |z| that is as rare as theirs where nothing is searched for.
pub(super) fn candidates(problem: &Problem<'_>, state: &State) -> Vec<(Candidate, f64)> {
    let mut scored = Vec::new();
    let Some(in_run) = InRun::new(problem, state) else { return scored };
    let runs = problem.predictor.runs.runs.len();

    let rows: usize = problem.predictor.runs.runs.iter().map(|run| run.rows.len()).sum();
    let chance = (rows as f64).ln();

    let field: Vec<usize> = (0..runs).filter(|&run| !problem.predictor.runs.runs[run].clean).collect();
    let open = field.len();
    let scores: Vec<(usize, f64)> =
        field.iter().filter_map(|&run| Some((run, mass_score(problem, state, &in_run, run)?))).collect();
    for wrong in wrong_masses(&scores, [NO_DIFFERENCE, problem.inflated(NO_DIFFERENCE)], open) {
        let names = wrong.iter().map(|(run, _)| problem.predictor.runs.runs[*run].name.clone()).collect();
        let detail = Detail::InRuns { runs: Runs::Named(names), at_s: None };
        let regressors = wrong.iter().map(|(run, _)| Regressor::Mass(*run)).collect();
        let z: Vec<f64> = wrong.iter().map(|(_, z)| *z).collect();
        let search = chance * wrong.len() as f64;
        scored.push((mislabelled(problem, regressors, detail, search), together(&z, open)));
    }

    let mut kinds = vec![(&STATIC_STEP, Switched::Static), (&SURFACE_SWITCH, Switched::Rolling)];
    if !problem.predictor.runs.robot.conditioning().slip.is_off() {
        kinds.push((&SURFACE_SWITCH, Switched::HalfSlip));
    }
    for (entry, what) in kinds {
        let times = times(&in_run, state, what);
        let range = match what {
            Switched::Static => (f64::NEG_INFINITY, f64::INFINITY),
            Switched::Rolling => {
                let limit = MOST_ROLLING * problem.centre.supplied_rolling().max(1e-3);
                (-limit, limit)
            }
            Switched::HalfSlip => HALF_SLIP,
        };
        // Of the best time the scatter of the runs counts, too.
        if let Some((at, z)) = times.common
            && together(&[z], times.looks) > NOTHING_LEFT
            && let Some(term) = what.from(at)
            && let Some(score) =
                problem.linear(state, &[Regressor::Term(term)], &[]).and_then(|at| at.score(0))
            && let z = together(&[score.z], times.looks)
            && z > NOTHING_LEFT
        {
            let detail = Detail::At { at_s: at };
            scored.push((entry.candidate(vec![Regressor::Term(term)], range, detail, cost_of_a_time(1)), z));
        }
        if let Some((at, sum)) = one_size(&times)
            && sum > NOTHING_LEFT
        {
            let detail = Detail::InRuns { runs: Runs::All, at_s: Some(at.clone()) };
            let search = cost_of_a_time(open) * at.iter().flatten().count() as f64;
            let at: Arc<[f64]> = at.iter().map(|at| at.unwrap_or(f64::INFINITY)).collect();
            let mut candidate = entry.candidate(vec![Regressor::Switch(what, at)], range, detail, search);
            if what == Switched::HalfSlip {
                candidate.unit = "1".to_owned();
            }
            scored.push((candidate, sum));
        }
        // The best of all times in all runs.
        let alone = |z: f64| together(&[z], times.looks * open);
        let shown = times.runs.iter().enumerate().filter_map(|(run, best)| Some((run, (*best)?)));
        let single: Vec<(usize, f64, f64)> =
            shown.map(|(run, (at, z))| (run, at, alone(z))).filter(|(_, _, z)| *z > NOTHING_LEFT).collect();
        let of_one = |(run, at, _): &(usize, f64, f64)| Some(Regressor::InRun(*run, what.from(*at)?));
        let regressors: Vec<Regressor> = single.iter().filter_map(of_one).collect();
        if !regressors.is_empty() {
            let names =
                single.iter().map(|(run, ..)| problem.predictor.runs.runs[*run].name.clone()).collect();
            let at = single.iter().map(|(_, at, _)| Some(*at)).collect();
            let detail = Detail::InRuns { runs: Runs::Named(names), at_s: Some(at) };
            let search = (cost_of_a_time(1) + chance) * regressors.len() as f64;
            let most = single.iter().map(|(.., z)| *z).fold(0.0, f64::max);
            scored.push((entry.candidate(regressors, range, detail, search), most));
        }
    }
    scored
}

/// Times of steps of one sign, the likelier one, in runs that show any, and their scores
/// [`together`].
fn one_size(times: &Times) -> Option<(Vec<Option<f64>>, f64)> {
    let all: Vec<(f64, f64)> = times.runs.iter().flatten().copied().collect();
    let sign = all.iter().map(|(_, z)| z * z.abs()).sum::<f64>().signum();
    let of_sign =
        |best: &Option<(f64, f64)>| best.filter(|(_, z)| z * sign > NO_DIFFERENCE).map(|(at, _)| at);
    let at: Vec<Option<f64>> = times.runs.iter().map(of_sign).collect();
    let scores: Vec<f64> = all.iter().map(|(_, z)| z * sign).filter(|z| *z > NO_DIFFERENCE).collect();
    let count = at.iter().flatten().count();
    (count >= 2).then(|| (at, together(&scores, times.looks)))
}

/// The |z| that is as rare as several scores, each the greatest of `looks`. Of one it is √(z² − 2
/// ln N): the tail of the greatest of N is N times that of one. What several have beyond 2 ln N is
/// exponential, of mean 2; the tail of their sum is bounded as that of χ² (Laurent and Massart
/// 2000, lemma 1).
fn together(scores: &[f64], looks: usize) -> f64 {
    let chance = 2.0 * (looks as f64).max(1.0).ln();
    let beyond: Vec<f64> = scores.iter().map(|z| z * z - chance).filter(|beyond| *beyond > 0.0).collect();
    let further = beyond.len().saturating_sub(1) as f64;
    let sum: f64 = beyond.iter().sum();
    ((sum - further).max(0.0).sqrt() - further.sqrt()).max(0.0)
}

/// Runs whose masses may be wrong, by their scores: those above noise, and those above what clean
/// runs show of each other if these are fewer. A mass that is wrong in every run is no slip of the
/// pen.
fn wrong_masses(scores: &[(usize, f64)], least: [f64; 2], open: usize) -> Vec<Vec<(usize, f64)>> {
    let above = |least| scores.iter().copied().filter(|(_, z)| z.abs() > least).collect();
    let mut sets: Vec<Vec<(usize, f64)>> = least.map(above).into();
    sets.retain(|wrong| !wrong.is_empty() && wrong.len() < open);
    sets.dedup_by_key(|wrong| wrong.len());
    sets
}

/// Masses of single runs: at least that of the empty robot, and changed by at most the greatest
/// noted.
fn mislabelled(problem: &Problem<'_>, wrong: Vec<Regressor>, detail: Detail, search: f64) -> Candidate {
    let masses = |run: usize| problem.predictor.runs.runs[run].rows.iter().map(|row| row.mass);
    let heaviest = (0..problem.predictor.runs.runs.len()).flat_map(masses).fold(0.0, f64::max);
    let empty = (1.0 - ONE_MASS) * problem.predictor.runs.robot.range().no_load();
    let least: Vec<f64> = wrong
        .iter()
        .filter_map(Regressor::run)
        .map(|run| -(masses(run).fold(f64::INFINITY, f64::min) - empty).max(0.0))
        .collect();
    Candidate { least, ..PAYLOAD_MISLABEL.candidate(wrong, (-heaviest, heaviest), detail, search) }
}

/// z of one run's mass.
fn mass_score(problem: &Problem<'_>, state: &State, in_run: &InRun<'_>, run: usize) -> Option<f64> {
    let raw = problem.predictor.columns(run, state, 0, &[Regressor::Mass(run)]);
    let column = problem.noise.whiten(problem.predictor.runs, run, &raw[0]);
    in_run.z(run, &column, &in_run.products(run, &column))
}

/// Base and effects moving along with columns that live in one run.
struct InRun<'a> {
    problem: &'a Problem<'a>,
    panel: Panel<'a>,
    /// The equations of base and effects, over all runs.
    factored: Factored,
    size: usize,
}

impl<'a> InRun<'a> {
    fn new(problem: &'a Problem<'a>, state: &State) -> Option<Self> {
        let panel = problem.panel(state, &[], &[]);
        let factored = problem.factored(&panel.products().total(None), state, problem.active(state))?;
        Some(Self { problem, panel, factored, size: problem.first_further(state) })
    }

    /// Products of a whitened column of a run with base, effects, residual and itself.
    fn products(&self, run: usize, column: &[f64]) -> FurtherColumn {
        let column = DVector::from_column_slice(column);
        FurtherColumn {
            along: self.panel.head_products(run, self.size, &column),
            residual: self.panel.residual(run).dot(&column),
            square: column.norm_squared(),
        }
    }

    /// z of a column of one run.
    fn z(&self, run: usize, column: &[f64], products: &FurtherColumn) -> Option<f64> {
        let score = self.factored.score(products, LEAST_SHARE)?;
        // Where the noise of the run is greater than elsewhere, a score says less.
        let square: f64 = column.iter().map(|x| x * x).sum();
        let scattered =
            self.problem.noise.run_score_variance(self.problem.predictor.runs.period_s, run, column);
        let variance_inflation = (scattered / square).max(1.0);
        Some(score.z() / variance_inflation.sqrt())
    }
}

/// The times at which a step explains most.
fn times(in_run: &InRun<'_>, state: &State, what: Switched) -> Times {
    let problem = in_run.problem;
    let runs = problem.predictor.runs;
    let longest = runs.runs.iter().filter_map(|run| run.rows.last()).map(|row| row.time).fold(0.0, f64::max);
    let step = TIME_GRID_S.max(longest / MOST_TIMES);
    let count = (longest / step) as usize;
    let none = FurtherColumn { along: DVector::zeros(in_run.size), residual: 0.0, square: 0.0 };
    let mut common = vec![none; count];
    let mut best = Vec::new();
    for (place, run) in runs.runs.iter().enumerate() {
        if run.clean {
            best.push(None);
            continue;
        }
        let whole = match what {
            Switched::Static => vec![1.0; run.rows.len()],
            moving => problem.predictor.columns(place, state, 0, &[moving.throughout()]).swap_remove(0),
        };
        let end = run.rows.last().map_or(0.0, |row| row.time);
        let mut strongest: Option<(f64, f64)> = None;
        for (index, sums) in common.iter_mut().enumerate() {
            let at = index as f64 * step;
            let column: Vec<f64> =
                run.rows.iter().zip(&whole).map(|(row, x)| if row.time >= at { *x } else { 0.0 }).collect();
            let column = problem.noise.whiten(runs, place, &column);
            let products = in_run.products(place, &column);
            let inside = at >= RUN_ENDS * end && at <= (1.0 - RUN_ENDS) * end;
            if inside
                && let Some(z) = in_run.z(place, &column, &products)
                && strongest.is_none_or(|(_, most)| z.abs() > most.abs())
            {
                strongest = Some((at, z));
            }
            sums.along += products.along;
            sums.residual += products.residual;
            sums.square += products.square;
        }
        best.push(strongest);
    }
    let mut all: Option<(f64, f64)> = None;
    for (index, sums) in common.iter().enumerate() {
        let at = index as f64 * step;
        if at >= RUN_ENDS * longest
            && at <= (1.0 - RUN_ENDS) * longest
            && let Some(z) = in_run.factored.score(sums, LEAST_SHARE).map(|score| score.z())
            && all.is_none_or(|(_, most)| z.abs() > most.abs())
        {
            all = Some((at, z));
        }
    }
    Times { runs: best, common: all, looks: count }
}

#[cfg(test)]
mod tests {
    use super::{together, wrong_masses};

    /// Of seven runs all are beyond noise, three beyond what clean runs show: those. Of eight, both
    /// sets are asked about.
    #[test]
    fn wrong_masses_are_those_of_some_runs() {
        let scores: Vec<(usize, f64)> =
            [9.0, -12.0, 4.0, 3.5, 10.0, -4.0, 5.0].into_iter().enumerate().collect();
        let runs = |least: [f64; 2], open: usize| -> Vec<Vec<usize>> {
            let sets = wrong_masses(&scores, least, open);
            sets.into_iter().map(|wrong| wrong.into_iter().map(|(run, _)| run).collect()).collect()
        };
        assert_eq!(runs([3.2, 8.0], 7), [vec![0, 1, 4]]);
        assert_eq!(runs([3.2, 8.0], 8), [vec![0, 1, 2, 3, 4, 5, 6], vec![0, 1, 4]]);
        assert_eq!(runs([8.0, 8.0], 7), [vec![0, 1, 4]]);
        assert!(runs([3.2, 20.0], 7).is_empty());
    }

    /// Of noise alone each z² is 2 ln(looks) at most, about. One of 5, the greatest of 8, is √(25 −
    /// 4.16), three of 4 are √(3 · (16 − 4.16) − 2) − √2 together.
    #[test]
    fn scores_of_several_runs_add_up_beyond_chance() {
        assert!((together(&[4.0, -4.0, 4.0], 8) - 4.376).abs() < 1e-3);
        assert!((together(&[5.0], 8) - 4.565).abs() < 1e-3);
        assert_eq!(together(&[2.0, 1.9, -2.0], 8), 0.0);
        assert_eq!(together(&[], 8), 0.0);
    }
}
