//! Evidences of every cause about no effect at all, at each scale of what differs between runs.

use model::effects::{
    Candidate, Detail, PAYLOAD_MISLABEL, Regressor, Runs, STATIC_STEP, SURFACE_SWITCH, Switched,
};
use rayon::prelude::*;
use residuals::thresholds::problem::ONE_MASS;

use super::evidence::{Marginal, Reduced, Totals, Variances, reduce};
use super::normal::{log_mean, log_sum};
use super::priors::{FORM_ERRORS, FORM_SIZES, RUN_SCALES};
use super::products::Posed;
use super::relinearise::{size, totals};
use super::step_times::{SingleRuns, steps};
use super::variances;
use super::ways::{Way, sizes};
use super::wrong_masses::masses;

/// What is known of noise and discrepancy, and the evidence of none.
#[derive(Debug, Clone)]
pub struct Scales {
    /// In variances of the noise.
    pub variances: Variances,
    /// What may be so beside the effects, each with its prior.
    pub cases: Vec<Case>,
    /// At each scale of [`RUN_SCALES`], run by run.
    pub marginals: Vec<Vec<Marginal>>,
    /// In each case.
    pub reduced: Vec<Reduced>,
    /// ln evidence of none, up to what all share.
    pub none: f64,
    /// ln evidence of none that each field run adds.
    pub none_by_run: Vec<f64>,
    /// Sizes that an effect may have.
    pub sizes: Vec<f64>,
}

/// How much differs between runs, and how much the form of known effects gets wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// ln prior.
    pub weight: f64,
    /// Its place among [`RUN_SCALES`].
    pub scale: usize,
    /// Variance of what the form of known effects gets wrong, a function.
    pub form: f64,
}

impl Scales {
    /// Variances by the clean runs, then each scale.
    pub fn told(posed: &Posed<'_>) -> Option<Self> {
        let told: Vec<usize> = (0..posed.runs.len()).filter(|&run| !posed.is_field(run)).collect();
        let variances = variances_of(posed, &told)?;
        let forms = &FORM_ERRORS[..if posed.known > 0.0 { FORM_ERRORS.len() } else { 1 }];
        let mut cases = Vec::new();
        for (scale, weight) in scale_weights(told.len()).into_iter().enumerate() {
            cases.extend(forms.iter().map(|share| Case {
                weight: weight - (forms.len() as f64).ln(),
                scale,
                form: (share * posed.known).powi(2) / posed.shape.functions as f64,
            }));
        }
        let mut scales = Self {
            variances,
            cases,
            marginals: Vec::new(),
            reduced: Vec::new(),
            none: 0.0,
            none_by_run: Vec::new(),
            sizes: sizes(posed.power),
        };
        for scale in 0..RUN_SCALES.len() {
            let variances = scales.run_variances(scale);
            let marginals: Option<Vec<Marginal>> =
                posed.runs.iter().map(|run| Marginal::of(&run.products, posed.shape, &variances)).collect();
            scales.marginals.push(marginals?);
        }
        let reduced: Option<Vec<Reduced>> =
            scales.cases.iter().map(|case| scales.reduce(posed, case, 0.0)).collect();
        scales.reduced = reduced?;
        scales.none = scales.over_none(|case| -0.5 * scales.reduced[case].minus_two_log);
        let middle = scales.likeliest();
        let form = scales.cases[middle].form;
        scales.none_by_run = each_run(posed, scales.in_case(middle), |totals| {
            Some(-0.5 * reduce(totals, posed.shape, &scales.variances, form)?.minus_two_log)
        })?;
        Some(scales)
    }

    /// What each field run adds to a value of sums over runs, less what it adds to none.
    pub fn by_run(
        &self,
        posed: &Posed<'_>,
        runs: &[Marginal],
        value: impl Fn(&Totals) -> Option<f64> + Sync,
    ) -> Option<Vec<f64>> {
        let each = each_run(posed, runs, value)?;
        Some(each.iter().zip(&self.none_by_run).map(|(with, none)| with - none).collect())
    }

    /// From run to run at a scale.
    pub fn run_variances(&self, scale: usize) -> Vec<f64> {
        self.variances.runs.iter().map(|variance| variance * RUN_SCALES[scale]).collect()
    }

    /// The case that is likeliest without effects.
    pub fn likeliest(&self) -> usize {
        let value = |case: &usize| self.cases[*case].weight - 0.5 * self.reduced[*case].minus_two_log;
        (0..self.cases.len()).max_by(|a, b| value(a).total_cmp(&value(b))).unwrap_or(0)
    }

    /// Runs in a case.
    pub fn in_case(&self, case: usize) -> &[Marginal] {
        &self.marginals[self.cases[case].scale]
    }

    /// With the effects that all field runs share. `other`: variance of what a form gets wrong, too.
    fn reduce(&self, posed: &Posed<'_>, case: &Case, other: f64) -> Option<Reduced> {
        let size = posed.mass_column();
        let runs = self.marginals[case.scale].iter();
        let cut: Vec<Marginal> = runs.map(|run| run.cut(size.min(run.products.ncols()))).collect();
        reduce(&totals(posed, &cut), posed.shape, &self.variances, case.form + other)
    }

    /// Over the cases, less that of none.
    pub fn over_none(&self, of_case: impl Fn(usize) -> f64) -> f64 {
        log_sum(self.cases.iter().enumerate().map(|(place, case)| case.weight + of_case(place))) - self.none
    }
}

/// What each field run adds to a value of sums over runs: that of all less that without it. What
/// is of single runs alone, more columns of a longer one, has no sum.
fn each_run(
    posed: &Posed<'_>,
    runs: &[Marginal],
    value: impl Fn(&Totals) -> Option<f64> + Sync,
) -> Option<Vec<f64>> {
    let size = posed.mass_column();
    let cut: Vec<Marginal> = runs.iter().map(|run| run.cut(size.min(run.products.ncols()))).collect();
    let without = |left_out: Option<usize>| {
        let kept = cut.iter().enumerate().filter(|(run, _)| Some(*run) != left_out);
        value(&Totals::of(posed.shape, kept.map(|(run, marginal)| (posed.is_field(run), marginal))))
    };
    let all = without(None)?;
    let field: Vec<usize> = (0..runs.len()).filter(|&run| posed.is_field(run)).collect();
    field.par_iter().map(|run| Some(all - without(Some(*run))?)).collect()
}

/// ln prior of each scale of what differs between runs. So many runs tell it as well as so many
/// normal values, less their mean, tell a variance.
pub fn scale_weights(told: usize) -> Vec<f64> {
    let half = 0.5 * (told as f64 - 1.0);
    let weights: Vec<f64> = RUN_SCALES.iter().map(|scale| -half * (scale.ln() + scale.recip())).collect();
    let total = log_sum(weights.iter().copied());
    weights.iter().map(|weight| weight - total).collect()
}

/// By the restricted likelihood of some runs.
pub fn variances_of(posed: &Posed<'_>, runs: &[usize]) -> Option<Variances> {
    let products: Vec<_> = runs.iter().map(|&run| &posed.runs[run].products).collect();
    variances::told(&products, &[], posed.shape, &posed.groups, &posed.base, None)
}

/// One hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// What shows, and how.
    pub way: Way,
    /// ln evidence over none.
    pub evidence: f64,
    /// Coefficients that are likeliest.
    pub coefficients: Vec<f64>,
    /// ln prior of what was searched for in single runs, which the way's gain lacks.
    pub searched: f64,
    /// Whether it lives in single runs, or at times of their own.
    pub in_single_runs: bool,
    /// By how much likelier than none each field run is when the others tell of the cause, nats;
    /// empty where it was not asked.
    pub by_run: Vec<f64>,
}

/// Of every way, with all that may be wrong with its form.
pub fn ways(posed: &Posed<'_>, scales: &Scales) -> Vec<Scored> {
    // At a grid of sizes: the nearest one is taken for what a form gets wrong.
    let grid = FORM_SIZES;
    let with: Vec<Vec<Option<Reduced>>> = scales
        .cases
        .iter()
        .map(|case| grid.iter().map(|size| scales.reduce(posed, case, size * size)).collect())
        .collect();
    let count = (posed.shape.functions as f64).sqrt();
    let middle = scales.likeliest();
    let score = |way: &Way| {
        let (coefficients, _) = way.likeliest(&scales.reduced[middle], &scales.sizes)?;
        let size = size(way, &coefficients);
        let evidence = scales.over_none(|case| {
            log_mean(way.form_errors().iter().map(|share| {
                let wanted = share * size / count;
                let reduced = match nearest(&grid, wanted) {
                    Some(place) => with[case][place].as_ref(),
                    None => Some(&scales.reduced[case]),
                };
                let value =
                    |reduced: &Reduced| way.gain(reduced, &scales.sizes) - 0.5 * reduced.minus_two_log;
                reduced.map_or(f64::NEG_INFINITY, value)
            }))
        });
        Some(Scored {
            way: way.clone(),
            evidence,
            coefficients,
            searched: 0.0,
            in_single_runs: false,
            by_run: Vec::new(),
        })
    };
    posed.ways.iter().filter_map(score).collect()
}

/// The place of the nearest size by its logarithm; none for what is far below the least.
fn nearest(grid: &[f64], wanted: f64) -> Option<usize> {
    if wanted < 0.5 * grid[0] {
        return None;
    }
    let distance = |place: &usize| (grid[*place] / wanted).ln().abs();
    (0..grid.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Steps at each run's own time, and masses of single runs.
pub fn of_single_runs(posed: &Posed<'_>, scales: &Scales, removed: &[String]) -> Vec<Scored> {
    let middle = scales.likeliest();
    let field: Vec<usize> = (0..posed.runs.len()).filter(|&run| posed.is_field(run)).collect();
    let runs: Vec<(bool, &Marginal)> =
        field.iter().map(|&run| (true, &scales.in_case(middle)[run])).collect();
    let first = posed.mass_column();
    let of = |columns: Vec<std::ops::Range<usize>>| {
        SingleRuns::of(&scales.reduced[middle], posed.shape, &runs, &columns)
    };
    let may = |id: &str| removed.iter().all(|removed| removed != id);
    let mut scored = Vec::new();
    for (place, ((what, range), unit)) in posed.switches.iter().zip(&posed.switch_units).enumerate() {
        let (entry, allowed) = match what {
            Switched::Static => (&STATIC_STEP, may(STATIC_STEP.id)),
            _ => (&SURFACE_SWITCH, may(SURFACE_SWITCH.id)),
        };
        if !allowed {
            continue;
        }
        let columns = field.iter().map(|&run| posed.steps(run, place));
        let within = (range.0 * unit, range.1 * unit);
        let Some(best) = steps(&of(columns.collect()), &scales.sizes, within) else { continue };
        let mut times = vec![f64::INFINITY; posed.runs.len()];
        let at_s: Vec<Option<f64>> = field
            .iter()
            .zip(&best.at)
            .map(|(&run, at)| at.and_then(|at| posed.runs[run].step_times.get(at).copied()))
            .collect();
        for (&run, at) in field.iter().zip(&at_s) {
            times[run] = at.unwrap_or(f64::INFINITY);
        }
        let detail = Detail::InRuns { runs: Runs::All, at_s: Some(at_s) };
        let mut candidate =
            entry.candidate(vec![Regressor::Switch(*what, times.into())], *range, detail, 0.0);
        if *what == Switched::HalfSlip {
            candidate.unit = "1".to_owned();
        }
        scored.push(Scored {
            way: Way { candidate, units: vec![*unit], first: 0 },
            evidence: best.evidence,
            coefficients: vec![0.0],
            searched: best.evidence - best.gain,
            in_single_runs: true,
            by_run: Vec::new(),
        });
    }
    if may(PAYLOAD_MISLABEL.id) {
        let products = of(field.iter().map(|_| first..first + 1).collect());
        if let Some(best) = masses(&products, &scales.sizes) {
            scored.push(mislabelled(posed, &field, &best.runs, best.evidence, best.gain));
        }
    }
    scored
}

/// Masses of some runs that were noted wrongly: none below the empty robot's.
fn mislabelled(posed: &Posed<'_>, field: &[usize], wrong: &[usize], evidence: f64, gain: f64) -> Scored {
    let runs = &posed.predictor.runs.runs;
    let masses = |run: usize| runs[run].rows.iter().map(|row| row.mass);
    let heaviest = field.iter().flat_map(|&run| masses(run)).fold(0.0, f64::max);
    let empty = (1.0 - ONE_MASS) * posed.predictor.runs.robot.range().no_load();
    let mut wrong: Vec<usize> = wrong.iter().map(|place| field[*place]).collect();
    wrong.sort_unstable();
    let least = wrong.iter().map(|&run| -(masses(run).fold(f64::INFINITY, f64::min) - empty).max(0.0));
    let names = wrong.iter().map(|&run| runs[run].name.clone()).collect();
    let detail = Detail::InRuns { runs: Runs::Named(names), at_s: None };
    let regressors: Vec<Regressor> = wrong.iter().map(|&run| Regressor::Mass(run)).collect();
    let candidate = Candidate {
        least: least.collect(),
        ..PAYLOAD_MISLABEL.candidate(regressors, (-heaviest, heaviest), detail, 0.0)
    };
    Scored {
        way: Way { candidate, units: wrong.iter().map(|&run| posed.runs[run].mass_unit).collect(), first: 0 },
        evidence,
        coefficients: vec![0.0; wrong.len()],
        searched: evidence - gain,
        in_single_runs: true,
        by_run: Vec::new(),
    }
}
