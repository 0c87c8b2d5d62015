//! The distribution of a drive's parameters, from segments of earlier drives.

use nalgebra::{SMatrix, SVector};
use support::error::{Error, Result};

use super::estimator::Recursive;
use crate::baselines::longitudinal::TERMS;
use crate::baselines::regression::{Observation, least_squares};

type Vector = SVector<f64, TERMS>;
type Square = SMatrix<f64, TERMS, TERMS>;

/// Fewest segments: fewer leave the covariance of the parameters singular.
const FEWEST_SEGMENTS: usize = TERMS + 1;

/// Weight of all segments in a segment's estimate, in average segments: enough to hold the
/// parameters that its own manoeuvres do not show.
const LEANING: f64 = 0.01;

/// Smallest information about a parameter, as in recursive least squares that know nothing.
const LEAST_INFORMATION: f64 = 1e-6;

/// A normal prior, and the noise that it is relative to.
pub(super) struct Prior {
    pub(super) mean: [f64; TERMS],
    /// Of the parameters, between segments.
    pub(super) covariance: Square,
    /// Of the power within a segment, W².
    pub(super) noise: f64,
}

impl Prior {
    /// Mean and covariance of the segments' estimates, and the variance of the residual within
    /// segments.
    pub(super) fn of(segments: &[&[Observation<[f64; TERMS]>]]) -> Result<Self> {
        if segments.len() < FEWEST_SEGMENTS {
            return Err(Error::failed(format!(
                "sadrpour-bayes: {} training segments; expected at least {FEWEST_SEGMENTS} for a prior of {TERMS} parameters",
                segments.len()
            )));
        }
        let all: Vec<_> = segments.concat();
        let failed = || Error::failed("sadrpour-bayes: the training drives have no finite solution");
        let pooled: [f64; TERMS] =
            least_squares(&all).and_then(|mean| mean.try_into().ok()).ok_or_else(failed)?;
        let count = segments.len() as f64;
        let gram: Square = all.iter().map(|(terms, _)| Vector::from(*terms)).map(|x| x * x.transpose()).sum();
        let information = gram * (LEANING / count) + Square::identity() * LEAST_INFORMATION;
        let leaning = Recursive::with_prior(pooled, information.try_inverse().ok_or_else(failed)?);
        let estimates: Vec<Vector> = segments.iter().map(|segment| estimate(leaning, segment)).collect();
        let mean = estimates.iter().sum::<Vector>() / count;
        let deviations = estimates.iter().map(|estimate| estimate - mean);
        let covariance = deviations.map(|d| d * d.transpose()).sum::<Square>() / (count - 1.0);
        let squares: f64 =
            segments.iter().zip(&estimates).map(|(segment, estimate)| residual(segment, estimate)).sum();
        let noise = squares / (all.len() - segments.len() * TERMS).max(1) as f64;
        Ok(Self { mean: mean.into(), covariance, noise })
    }
}

fn estimate(mut known: Recursive<TERMS>, segment: &[Observation<[f64; TERMS]>]) -> Vector {
    for (terms, power) in segment {
        known.update(terms, *power, 1.0);
    }
    known.estimate().into()
}

/// Sum of squared residuals, W².
fn residual(segment: &[Observation<[f64; TERMS]>], estimate: &Vector) -> f64 {
    segment.iter().map(|(terms, power)| (power - Vector::from(*terms).dot(estimate)).powi(2)).sum()
}
