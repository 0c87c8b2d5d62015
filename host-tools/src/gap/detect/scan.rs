//! Effects that live in single runs, or begin at a time that nobody knows.

use std::sync::Arc;

use model_core::effects::Term;
use nalgebra::{DMatrix, DVector};

use crate::effects::{
    Candidate, Detail, PAYLOAD_MISLABEL, Regressor, Runs, STATIC_STEP, SURFACE_SWITCH, Switched,
};
use crate::gap::problem::Problem;
use crate::gap::problem::panel::Panel;
use crate::gap::problem::solve::Prior;
use crate::gap::thresholds::detect::{
    IN_RUN, LEAST_STEP, MOST_ROLLING, MOST_TIMES, RUN_ENDS, TIME_GRID_S, TIME_PENALTY, WRONG_MASS,
};
use crate::gap::thresholds::problem::{LEAST_SHARE, RIDGE};
use crate::gap::twin::State;

/// The best time of a step in each run, and in all runs together.
struct Times {
    /// Per run: time and score.
    runs: Vec<Option<(f64, f64)>>,
    /// Of all runs.
    common: Option<(f64, f64)>,
    /// How many times were tried in a run.
    looks: usize,
}

/// Candidates for steps and for masses that were noted wrongly, as far as they stand out of the noise.
pub(super) fn candidates<const N: usize>(problem: &Problem<'_, N>, state: &State) -> Vec<(Candidate, f64)> {
    let mut found = Vec::new();
    let panel = problem.panel(state, &[], false);
    let total = panel.products().total(None);
    let size = problem.first_further(state);
    let projector = Projector::new(&total, size, &problem.prior, &problem.offset(state));
    let Some(projector) = projector else { return found };
    let runs = problem.twin.runs.runs.len();

    let rows: usize = problem.twin.runs.runs.iter().map(|run| run.rows.len()).sum();
    let chance = (rows as f64).ln();

    // A wrong mass: one column a run.
    let mut wrong = Vec::new();
    let mut most = 0.0_f64;
    for run in (0..runs).filter(|&run| !problem.twin.runs.runs[run].clean) {
        let raw = problem.twin.columns(run, state, 0, &[Regressor::Mass(run)]);
        let column = problem.noise.whiten(problem.twin.runs, run, &raw[0]);
        let Some(z) = projector.score(&panel, run, &column) else { continue };
        let z = z / projector.variance_inflation(problem, run, &column).sqrt();
        if z.abs() > WRONG_MASS {
            wrong.push(Regressor::Mass(run));
            most = most.max(z.abs());
        }
    }
    let masses = problem.twin.runs.runs.iter().flat_map(|run| &run.rows).map(|row| row.mass);
    let heaviest = masses.fold(0.0, f64::max);
    if !wrong.is_empty() {
        let names = wrong.iter().map(|regressor| run_name(problem, regressor).to_owned()).collect();
        let detail = Detail::InRuns { runs: Runs::Named(names), at_s: None };
        let search = chance * wrong.len() as f64;
        found.push((PAYLOAD_MISLABEL.candidate(wrong, (-heaviest, heaviest), detail, search), most));
    }

    for (entry, what) in [(&STATIC_STEP, Switched::Static), (&SURFACE_SWITCH, Switched::Rolling)] {
        let times = times(problem, state, &panel, &projector, what);
        let limit = match what {
            Switched::Static => f64::INFINITY,
            Switched::Rolling => MOST_ROLLING * problem.centre.rolling.max(1e-3),
        };
        if let Some((at, z)) = times.common
            && z.abs() > IN_RUN
        {
            let detail = Detail::At { at_s: at };
            found.push((
                entry.candidate(vec![Regressor::Term(what.from(at))], (-limit, limit), detail, TIME_PENALTY),
                z.abs(),
            ));
        }
        if let Some((at, sum)) = one_size(&times)
            && sum > IN_RUN
        {
            let detail = Detail::InRuns { runs: Runs::All, at_s: Some(at.clone()) };
            // Which runs have one was chosen, too.
            let search = (TIME_PENALTY + 2.0 * (runs as f64).ln()) * at.iter().flatten().count() as f64;
            let at: Arc<[f64]> = at.iter().map(|at| at.unwrap_or(f64::INFINITY)).collect();
            found.push((
                entry.candidate(vec![Regressor::Switch(what, at)], (-limit, limit), detail, search),
                sum,
            ));
        }
        let single: Vec<(usize, f64)> = times
            .runs
            .iter()
            .enumerate()
            .filter_map(|(run, best)| best.filter(|(_, z)| z.abs() > IN_RUN).map(|(at, _)| (run, at)))
            .collect();
        if !single.is_empty() {
            let names = single.iter().map(|(run, _)| problem.twin.runs.runs[*run].name.clone()).collect();
            let at = single.iter().map(|(_, at)| Some(*at)).collect();
            let detail = Detail::InRuns { runs: Runs::Named(names), at_s: Some(at) };
            let regressors: Vec<Regressor> =
                single.iter().map(|(run, at)| Regressor::InRun(*run, what.from(*at))).collect();
            let search = (TIME_PENALTY + chance) * regressors.len() as f64;
            let most = times.runs.iter().flatten().map(|(_, z)| z.abs()).fold(0.0, f64::max);
            found.push((entry.candidate(regressors, (-limit, limit), detail, search), most));
        }
    }
    found
}

/// Times of steps of one sign, the likelier one, in runs that show any, and what they come to: the root of what each z² has beyond
/// the greatest of as many times in noise, which is 2 ln(times).
fn one_size(times: &Times) -> Option<(Vec<Option<f64>>, f64)> {
    let all: Vec<(f64, f64)> = times.runs.iter().flatten().copied().collect();
    let sign = all.iter().map(|(_, z)| z * z.abs()).sum::<f64>().signum();
    let of_sign = |best: &Option<(f64, f64)>| best.filter(|(_, z)| z * sign > LEAST_STEP).map(|(at, _)| at);
    let at: Vec<Option<f64>> = times.runs.iter().map(of_sign).collect();
    let chance = 2.0 * (times.looks as f64).max(1.0).ln();
    let sum: f64 =
        all.iter().filter(|(_, z)| z * sign > LEAST_STEP).map(|(_, z)| (z * z - chance).max(0.0)).sum();
    let count = at.iter().flatten().count();
    (count >= 2).then(|| (at, sum.sqrt()))
}

fn run_name<'a, const N: usize>(problem: &'a Problem<'_, N>, regressor: &Regressor) -> &'a str {
    match regressor {
        Regressor::Mass(run) | Regressor::InRun(run, _) => &problem.twin.runs.runs[*run].name,
        _ => "",
    }
}

/// Base and effects projected out of columns that live in one run.
struct Projector {
    /// Inverse of the normal matrix of base and effects, prior included.
    inverse: DMatrix<f64>,
    /// Their products with the residual.
    right: DVector<f64>,
    size: usize,
}

impl Projector {
    fn new(total: &DMatrix<f64>, size: usize, prior: &Prior, offset: &DVector<f64>) -> Option<Self> {
        let residual = total.ncols() - 1;
        let mut matrix = total.view((0, 0), (size, size)).into_owned();
        let mut right = total.view((0, residual), (size, 1)).column(0).into_owned();
        let pull = &prior.precision * offset;
        for i in 0..offset.len() {
            right[i] -= pull[i];
            for j in 0..offset.len() {
                matrix[(i, j)] += prior.precision[(i, j)];
            }
        }
        let scale = DVector::from_fn(size, |i, _| 1.0 / matrix[(i, i)].max(1e-300).sqrt());
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            matrix[(i, j)] * scale[i] * scale[j] + if i == j { RIDGE } else { 0.0 }
        });
        let inverse = scaled.cholesky()?.inverse();
        let inverse = DMatrix::from_fn(size, size, |i, j| inverse[(i, j)] * scale[i] * scale[j]);
        Some(Self { inverse, right, size })
    }

    /// Products of a column with base, effects, residual and itself; the column is of the run whose panel is given.
    fn sums(&self, panel: &Panel<'_>, run: usize, column: &[f64]) -> (DVector<f64>, f64, f64) {
        let column = DVector::from_column_slice(column);
        let with = panel.head_products(run, self.size, &column);
        let residual = panel.residual(run).dot(&column);
        (with, residual, column.norm_squared())
    }

    fn score(&self, panel: &Panel<'_>, run: usize, column: &[f64]) -> Option<f64> {
        let (with, residual, own) = self.sums(panel, run, column);
        self.z(&with, residual, own)
    }

    /// 1 where the noise of the run is as elsewhere, more where it is greater.
    fn variance_inflation<const N: usize>(
        &self,
        problem: &Problem<'_, N>,
        run: usize,
        column: &[f64],
    ) -> f64 {
        let own: f64 = column.iter().map(|x| x * x).sum();
        let scattered = problem.noise.run_score_variance(problem.twin.runs.period_s, run, column);
        if scattered > own { scattered / own } else { 1.0 }
    }

    fn z(&self, with: &DVector<f64>, residual: f64, own: f64) -> Option<f64> {
        let by = &self.inverse * with;
        let variance = own - by.dot(with);
        (own > 0.0 && variance > LEAST_SHARE * own)
            .then(|| (residual - by.dot(&self.right)) / variance.sqrt())
    }
}

/// The times at which a step explains most.
fn times<const N: usize>(
    problem: &Problem<'_, N>,
    state: &State,
    panel: &Panel<'_>,
    projector: &Projector,
    what: Switched,
) -> Times {
    let runs = problem.twin.runs;
    let longest = runs.runs.iter().filter_map(|run| run.rows.last()).map(|row| row.time).fold(0.0, f64::max);
    let step = TIME_GRID_S.max(longest / MOST_TIMES);
    let count = (longest / step) as usize;
    let mut common: Vec<(DVector<f64>, f64, f64)> = vec![(DVector::zeros(projector.size), 0.0, 0.0); count];
    let mut best = Vec::new();
    for (place, run) in runs.runs.iter().enumerate() {
        if run.clean {
            best.push(None);
            continue;
        }
        let whole = if what == Switched::Rolling {
            problem.twin.columns(place, state, 0, &[Regressor::Term(Term::Rolling)]).swap_remove(0)
        } else {
            vec![1.0; run.rows.len()]
        };
        let end = run.rows.last().map_or(0.0, |row| row.time);
        let mut found: Option<(f64, f64)> = None;
        for (index, sums) in common.iter_mut().enumerate() {
            let at = index as f64 * step;
            let column: Vec<f64> =
                run.rows.iter().zip(&whole).map(|(row, x)| if row.time >= at { *x } else { 0.0 }).collect();
            let column = problem.noise.whiten(runs, place, &column);
            let (with, residual, own) = projector.sums(panel, place, &column);
            let inside = at >= RUN_ENDS * end && at <= (1.0 - RUN_ENDS) * end;
            if inside
                && let Some(z) = projector.z(&with, residual, own)
                && let z = z / projector.variance_inflation(problem, place, &column).sqrt()
                && found.is_none_or(|(_, most)| z.abs() > most.abs())
            {
                found = Some((at, z));
            }
            sums.0 += with;
            sums.1 += residual;
            sums.2 += own;
        }
        best.push(found);
    }
    let mut all: Option<(f64, f64)> = None;
    for (index, (with, residual, own)) in common.iter().enumerate() {
        let at = index as f64 * step;
        if at >= RUN_ENDS * longest
            && at <= (1.0 - RUN_ENDS) * longest
            && let Some(z) = projector.z(with, *residual, *own)
            && all.is_none_or(|(_, most)| z.abs() > most.abs())
        {
            all = Some((at, z));
        }
    }
    Times { runs: best, common: all, looks: count }
}
