//! The next coefficients from sums near the last: one step of Gauss and Newton of the signed model,
//! clamp, delay and slip memory included.

use std::path::Path;

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use model::coefficients::{CoefficientsFile, Taking};
use model_core::model::Model;
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector};
use numerics::scaled_inverse::ScaledInverse;
use serde::Serialize;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};

use super::local::Local;
use super::read::checksum_of;
use super::run::{RunGram, total};
use crate::physical::{Bounds, FreeTerms, parameters, torque};
use crate::verdict;

/// A parameter before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Moved {
    /// Its name in coefficients.toml.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Where the sums were taken.
    pub before: f64,
    /// Where they lead.
    pub after: f64,
    /// Standard error: of the equations, or by how runs differ, whichever is greater.
    pub std_err: f64,
}

/// What came of a step.
#[derive(Debug, Clone)]
pub struct Step {
    /// The coefficients that it leads to; all else is as in those that it began at.
    pub file: CoefficientsFile,
    /// The step itself.
    pub told: Told,
}

/// A step as it is told.
#[derive(Debug, Clone)]
pub struct Told {
    /// Parameter by parameter.
    pub moved: Vec<Moved>,
    /// Rows in which a wheel draws power.
    pub rows: u64,
    /// Their root mean square residual before, W.
    pub before_rmse_w: f64,
    /// The same after, as far as the model is linear in between.
    pub after_rmse_w: f64,
    /// The longest move, in standard errors: a further pass is worth it where it is not far below
    /// 1.
    pub longest_std_errs: f64,
}

/// The step that runs ask for, whose sums were taken near the coefficients of this file (`gmr
/// gram --coeffs`).
///
/// # Errors
/// Sums of other settings, or taken near other coefficients; coefficients of another model.
pub fn step(robot: &Robot, file: &Path, runs: &[RunGram]) -> Result<Step> {
    let all = total(runs)?;
    let text = read_text(file, MOST_DESCRIPTION)?;
    let mut next = CoefficientsFile::parse(&text, file, robot, Taking::default())?;
    let Model::Signed { torque: reference, drive } = next.coefficients.model else {
        return Err(Error::failed("model eq18; expected signed").in_file(file).in_column("model"));
    };
    let near = (file, &*checksum_of(&text));
    let (torque, covariance, told) = solve(robot, &next.coefficients.robot, &reference, near, &all, runs)?;
    next.coefficients.model = Model::Signed { torque, drive };
    next.covariance = covariance;
    next.origin.rows = all.summary.rows;
    next.origin.rmse_w = told.after_rmse_w;
    Ok(Step { file: next, told })
}

/// The step from coefficients of this file and checksum, and their covariance without that of the
/// sides' imbalance.
fn solve(
    robot: &Robot,
    core: &Chassis,
    reference: &TorqueModel<f64>,
    (file, near): (&Path, &str),
    all: &RunGram,
    runs: &[RunGram],
) -> Result<(TorqueModel<f64>, DMatrix<f64>, Told)> {
    let sums =
        all.local.as_ref().filter(|_| all.setting.reference.as_deref() == Some(near)).ok_or_else(|| {
            let origin = match &all.setting.reference {
                Some(other) => format!("sums near other coefficients ({other}; these are {near})"),
                None => "sums near no coefficients".to_owned(),
            };
            Error::failed(format!("{origin}; expected those of gmr gram --coeffs {}", file.display()))
                .in_file(file)
        })?;
    if sums.rows == 0 {
        return Err(Error::failed("no row in which a wheel draws power; expected a drive"));
    }
    let start = parameters(reference);
    // Sides that were alike stay so. Sums say nothing of the losses of gear and bridge, which stay
    // as they are.
    let free_terms = FreeTerms::of(reference);
    let places = FreeTerms { gear_loss: None, bridge_drop: false, ..free_terms }.places(core.scrubs());
    let shared = verdict::TORQUE.len() - usize::from(!core.scrubs());
    let bounds = Bounds::up_to(core, all.summary.fastest_rad_s, robot.motor(), free_terms);
    let of = |local: &Local| {
        let (normal, score) = (local.matrix(), local.scores());
        let matrix = DMatrix::from_fn(places.len(), places.len(), |i, j| normal[(places[i], places[j])]);
        (matrix, DVector::from_fn(places.len(), |i, _| score[places[i]]))
    };
    let (normal, score) = of(sums);
    let ends: Vec<[f64; 2]> = places
        .iter()
        .map(|&place| [bounds.lower()[place] - start[place], bounds.upper()[place] - start[place]])
        .collect();
    let step = bounded(&normal, &score, &ends);
    let after_squares = sums.squares - 2.0 * step.dot(&score) + step.dot(&(&normal * &step));
    let mean = |squares: f64| (squares.max(0.0) / sums.rows as f64).sqrt();
    let runs: Vec<(DMatrix<f64>, DVector<f64>)> =
        runs.iter().filter_map(|run| run.local.as_ref()).map(of).collect();
    let covariance = covariance(&normal, &runs, &step, mean(after_squares));
    let mut values = start;
    let mut moved = Vec::new();
    for (i, &place) in places.iter().enumerate() {
        values[place] += step[i];
        let description = verdict::of_torque(place);
        moved.push(Moved {
            name: description.name,
            unit: description.unit,
            before: start[place],
            after: values[place],
            std_err: covariance[(i, i)].sqrt(),
        });
    }
    let lengths = moved.iter().map(|one| (one.after - one.before).abs() / one.std_err.max(f64::MIN_POSITIVE));
    let longest_std_errs = lengths.filter(|length| length.is_finite()).fold(0.0, f64::max);
    let told = Told {
        rows: sums.rows,
        before_rmse_w: mean(sums.squares),
        after_rmse_w: mean(after_squares),
        longest_std_errs,
        moved,
    };
    Ok((torque(&values), covariance.view((0, 0), (shared, shared)).into_owned(), told))
}

/// Least squares within bounds. A parameter that would leave them is held at the bound it crosses,
/// and the others are solved for anew.
fn bounded(normal: &DMatrix<f64>, score: &DVector<f64>, ends: &[[f64; 2]]) -> DVector<f64> {
    let size = score.len();
    let mut held: Vec<Option<f64>> = vec![None; size];
    loop {
        let free: Vec<usize> = (0..size).filter(|&i| held[i].is_none()).collect();
        let fixed = DVector::from_fn(size, |i, _| held[i].unwrap_or(0.0));
        let right = score - normal * &fixed;
        let matrix = DMatrix::from_fn(free.len(), free.len(), |i, j| normal[(free[i], free[j])]);
        let inverse = ScaledInverse::of(&matrix);
        let solved = inverse.unscaled(&inverse.inverse) * DVector::from_fn(free.len(), |i, _| right[free[i]]);
        let mut step = fixed;
        let mut newly_held = false;
        for (&place, value) in free.iter().zip(&solved) {
            let [low, high] = ends[place];
            step[place] = value.clamp(low, high);
            if step[place] != *value {
                held[place] = Some(step[place]);
                newly_held = true;
            }
        }
        if !newly_held {
            return step;
        }
    }
}

/// σ² N⁻¹, or as large as runs disagree at the end of the step, whichever is greater for each
/// parameter.
fn covariance(
    normal: &DMatrix<f64>,
    runs: &[(DMatrix<f64>, DVector<f64>)],
    step: &DVector<f64>,
    rmse_w: f64,
) -> DMatrix<f64> {
    let size = step.len();
    let inverse = ScaledInverse::of(normal);
    let bread = inverse.unscaled(&inverse.inverse);
    let mut meat = DMatrix::zeros(size, size);
    for (matrix, score) in runs {
        let residual = score - matrix * step;
        meat.ger(1.0, &residual, &residual, 1.0);
    }
    let count = runs.len() as f64;
    let by_runs = &bread * meat * &bread * (count / (count - 1.0).max(1.0));
    let formal = &bread * (rmse_w * rmse_w);
    let wider = DVector::from_fn(size, |i, _| {
        let ratio = by_runs[(i, i)] / formal[(i, i)].max(f64::MIN_POSITIVE);
        ratio.max(1.0).sqrt()
    });
    DMatrix::from_fn(size, size, |i, j| formal[(i, j)] * wider[i] * wider[j])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// min ½ xᵀNx − sᵀx with N = [[2, 1], [1, 2]]: free (1, 1); with x₁ ≥ 1.5 the other moves to (3
    /// − 1.5)/2.
    #[test]
    fn what_leaves_its_bounds_is_held_and_the_others_make_room() {
        let normal = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let score = DVector::from_vec(vec![3.0, 3.0]);
        let wide = [-9.0, 9.0];
        let free = bounded(&normal, &score, &[wide, wide]);
        assert!((free - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-12);
        let held = bounded(&normal, &score, &[[1.5, 9.0], wide]);
        assert!((held - DVector::from_vec(vec![1.5, 0.75])).norm() < 1e-12);
    }
}
