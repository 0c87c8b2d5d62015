//! Fits from sums alone: Eq. 18 as from the rows, the signed model from the rows that its clamp
//! leaves alone.

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model_core::eq18::REGRESSORS;
use model_core::torque::Drive;
use nalgebra::{DMatrix, DVector};
use numerics::levenberg_marquardt::{self, Ending, Tolerances};
use serde::Serialize;
use support::error::{Error, Result};

use super::polynomial::{self, Cost};
use super::run::{RunGram, total};
use crate::assess::{Uncertainty, sandwich};
use crate::gram::{Gram, Vector};
use crate::linear;
use crate::physical::{self, Bounds, FreeTerms};
use crate::verdict::{self, Description, Parameter, Verdict};
use crate::warning::Warning;
use model::coefficients::ModelKind;

/// A model fitted to sums.
#[derive(Debug, Clone, Serialize)]
pub struct Fitted {
    /// Which.
    pub model: ModelKind,
    /// 1 − Σ(P − P̂)² / Σ(P − P̄)²; none where the power never changes.
    pub r2: Option<f64>,
    /// Root mean square of P − P̂, W, over the rows in the sums.
    pub rmse_w: f64,
    /// Rows in the sums.
    pub rows: u64,
    /// Rows after the filter that are not in them: in which a wheel can be clamped (signed model).
    pub left_out_rows: u64,
    /// The parameters; their standard errors are drawn from how runs differ.
    pub parameters: Vec<Parameter>,
    /// What sums cannot tell, or do not here, sentences.
    pub warnings: Vec<String>,
}

/// What a run says of a model that has not seen it.
#[derive(Debug, Clone, Serialize)]
pub struct LeftOut {
    /// The run.
    pub run: String,
    /// As [`Fitted::r2`], of its rows.
    pub r2: Option<f64>,
    /// As [`Fitted::rmse_w`], of its rows.
    pub rmse_w: f64,
    /// Its rows.
    pub rows: u64,
}

/// The Gram matrix of a kind of Eq. 18.
fn of_kind(kind: ModelKind, gram: &RunGram) -> &Gram<REGRESSORS> {
    if kind == ModelKind::Eq18Published { &gram.eq18_published } else { &gram.eq18 }
}

/// Eq. 18's exact optimum (non-negative least squares): that of the rows, to rounding.
///
/// # Errors
/// Runs of different settings; no row.
pub fn eq18(kind: ModelKind, runs: &[RunGram]) -> Result<Fitted> {
    let all = of_kind(kind, &total(runs)?).clone();
    check_rows(&all)?;
    let (beta, _) = linear::by_nnls(&all);
    let each = runs.iter().map(|run| (of_kind(kind, run).xx(), of_kind(kind, run).scores(&beta)));
    let clusters: Vec<(DMatrix<f64>, DVector<f64>)> = each
        .map(|(normal, score)| {
            (dynamic(REGRESSORS, |i, j| normal[(i, j)]), DVector::from_column_slice(score.as_slice()))
        })
        .collect();
    let mut warnings = Vec::new();
    let parameters = judged(&verdict::EQ18, beta.as_slice(), &clusters, all.rows(), &mut warnings);
    Ok(fitted(kind, &all, &beta, 0, parameters, warnings))
}

/// The signed model by least squares on rows in which no wheel can be clamped; all rows where
/// drives do not clamp. Sides alike.
///
/// Not what [`crate::fit`] finds: that knows clamped rows, weighs rows far beyond the others down,
/// and looks for delay, slip memory and unequal sides. What it costs to be the same: docs/fleet.md.
///
/// # Errors
/// Runs of different settings; no row; sums that are not of this robot.
pub fn signed(core: &Chassis, robot: &Robot, runs: &[RunGram]) -> Result<Fitted> {
    let all = total(runs)?;
    check_rows(&all.signed)?;
    let bounds = Bounds::up_to(core, all.summary.fastest_rad_s, robot.motor(), FreeTerms::default());
    let cost = Cost::of(&all.signed);
    let tolerances = Tolerances { cost_share: 1e-15, ..Tolerances::default() };
    let ends = cost.alone().ordered_starts().into_iter();
    let ends = ends.map(|start| levenberg_marquardt::descend(&cost, &start, bounds.as_box(), &tolerances));
    let best = ends.filter(|end| end.cost.is_finite()).min_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = best.ok_or_else(|| {
        Error::failed("no start of the search has a finite cost: the sums are not of a drive")
    })?;
    // Sums that were added in a different order, by an engine, end at the same coefficients.
    let polished = levenberg_marquardt::polish(&cost, &best.parameters, bounds.as_box());
    let torque = physical::torque(&polished);
    let mut warnings: Vec<String> =
        bounds.met_by(&polished).iter().map(|at| Warning::at_bound(at).text).collect();
    if best.ending == Ending::OutOfSteps {
        warnings.push("the search used up its steps: the coefficients are the best that were met".to_owned());
    }
    if robot.drive() == Drive::Dissipative {
        warnings.push(format!(
            "from the {} rows in which no wheel can be clamped, each counted squared; the other {} need their rows: gmr fit LOG… is the fit \
             of all, with robust weights, delay and slip memory",
            all.signed.rows(),
            all.may_clamp
        ));
    } else {
        warnings.push(
            "every row counts squared, without delay or slip memory being looked for: gmr fit LOG… does"
                .to_owned(),
        );
    }
    let places = verdict::TORQUE.len() - usize::from(!core.scrubs());
    let clusters: Vec<(DMatrix<f64>, DVector<f64>)> = runs
        .iter()
        .map(|run| {
            let (normal, score) = polynomial::normal(&run.signed, &torque);
            (dynamic(places, |i, j| normal[(i, j)]), DVector::from_fn(places, |i, _| score[i]))
        })
        .collect();
    let values = &polished.as_slice()[..places];
    let parameters = judged(&verdict::TORQUE[..places], values, &clusters, all.signed.rows(), &mut warnings);
    let beta = polynomial::expand(&torque);
    Ok(fitted(ModelKind::Signed, &all.signed, &beta, all.may_clamp, parameters, warnings))
}

/// Every run by Eq. 18 fitted to all others.
///
/// # Errors
/// As [`eq18`]; fewer than two runs.
pub fn leave_one_out(kind: ModelKind, runs: &[RunGram]) -> Result<Vec<LeftOut>> {
    if runs.len() < 2 {
        return Err(Error::failed("one run only; expected two at least, to leave one out"));
    }
    // Their settings agree.
    total(runs)?;
    let left_out = runs.iter().enumerate().map(|(place, run)| {
        // Added again: subtracted from the whole, a small run would be lost in rounding.
        let mut others = Gram::default();
        for (_, other) in runs.iter().enumerate().filter(|(other, _)| *other != place) {
            others.merge(of_kind(kind, other));
        }
        let (beta, _) = linear::by_nnls(&others);
        let gram = of_kind(kind, run);
        let (r2, rmse_w) = quality(gram, &beta);
        LeftOut { run: run.run.clone(), r2, rmse_w, rows: gram.rows() }
    });
    Ok(left_out.collect())
}

fn check_rows<const P: usize>(gram: &Gram<P>) -> Result<()> {
    if gram.rows() > 0 { Ok(()) } else { Err(Error::failed("no row in the sums; expected a drive")) }
}

fn dynamic(size: usize, entry: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, entry)
}

fn quality<const P: usize>(gram: &Gram<P>, beta: &Vector<P>) -> (Option<f64>, f64) {
    let (mean_square, variation) = (gram.cost(beta), gram.variation());
    let r2 = (variation > 0.0).then(|| 1.0 - mean_square * gram.rows() as f64 / variation);
    (r2, mean_square.sqrt())
}

fn fitted<const P: usize>(
    model: ModelKind,
    gram: &Gram<P>,
    beta: &Vector<P>,
    left_out_rows: u64,
    parameters: Vec<Parameter>,
    warnings: Vec<String>,
) -> Fitted {
    let (r2, rmse_w) = quality(gram, beta);
    Fitted { model, r2, rmse_w, rows: gram.rows(), left_out_rows, parameters, warnings }
}

/// Parameters with standard errors from how runs differ; without where there are too few of them.
fn judged(
    descriptions: &[Description],
    values: &[f64],
    clusters: &[(DMatrix<f64>, DVector<f64>)],
    rows: u64,
    warnings: &mut Vec<String>,
) -> Vec<Parameter> {
    let size = values.len();
    let normal = clusters.iter().fold(DMatrix::zeros(size, size), |sum, (normal, _)| sum + normal);
    let scores: Vec<DVector<f64>> = clusters.iter().map(|(_, score)| score.clone()).collect();
    let uncertainty: Uncertainty = sandwich(&normal, &scores, rows as usize);
    let mut parameters = verdict::judge(descriptions, values, &uncertainty);
    if clusters.len() <= size {
        warnings.push(format!(
            "no standard errors: sums tell them by how runs differ, and {} runs are not more than {size} parameters; gmr fit LOG… has them \
             from the rows",
            clusters.len()
        ));
        for parameter in &mut parameters {
            parameter.std_err = None;
            parameter.verdict = Verdict::Undetermined;
            parameter.advice = Some("standard errors from sums need more runs".to_owned());
        }
    }
    parameters
}
