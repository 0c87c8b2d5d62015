//! Bayesian estimation of the longitudinal parameters: a normal prior, updated at every point of
//! the drive.

use support::error::Result;

use super::estimator::Recursive;
use super::prior::Prior;
use crate::baselines::baseline::{Baseline, Parameter, named};
use crate::baselines::longitudinal::{SYMBOLS, TERMS, terms};
use crate::baselines::point::Point;
use crate::baselines::regression::{rows, unfitted};

const NAME: &str = "sadrpour-bayes";

/// Length of a segment, s: each has an estimate. The source has one a road segment; logs name no
/// roads.
const SEGMENT_S: f64 = 10.0;

/// Smallest share of the mean squared power that counts as noise: below it is the rounding of data
/// without noise.
const LEAST_NOISE: f64 = 1e-12;

/// Longitudinal dynamics with a prior.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bayes {
    prior: Option<Recursive<TERMS>>,
}

impl Baseline for Bayes {
    /// The prior: mean and covariance of the parameters between segments of ten seconds of the
    /// training runs.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.prior = None;
        let rows = rows(NAME, training, terms)?;
        let same = |a: &Point, b: &Point| a.run == b.run && segment(a) == segment(b);
        let mut rest = rows.as_slice();
        let mut segments = Vec::new();
        for points in training.chunk_by(same) {
            let (segment, others) = rest.split_at(points.len());
            rest = others;
            // A segment with hardly more points than parameters shows no noise.
            if segment.len() > 2 * TERMS {
                segments.push(segment);
            }
        }
        let prior = Prior::of(&segments)?;
        let square = rows.iter().map(|(_, power)| power * power).sum::<f64>() / rows.len() as f64;
        let noise = prior.noise.max(LEAST_NOISE * square).max(f64::MIN_POSITIVE);
        self.prior = Some(Recursive::with_prior(prior.mean, prior.covariance / noise));
        Ok(())
    }

    /// Nothing is forgotten: the parameters of a drive are constant, only unknown.
    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let prior = self.prior.ok_or_else(|| unfitted(NAME))?;
        Ok(prior.drive(points, f64::INFINITY, terms))
    }

    fn parameters(&self) -> Vec<Parameter> {
        self.prior.map_or(Vec::new(), |prior| named(SYMBOLS, &prior.estimate()))
    }
}

fn segment(point: &Point) -> i64 {
    (point.time / SEGMENT_S).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::{Bayes, Prior, SEGMENT_S, rows, terms};
    use crate::baselines::testing::{PERIOD_S, drive};
    use crate::baselines::{Baseline, Point};

    const PER_SEGMENT: usize = (SEGMENT_S / PERIOD_S) as usize;

    /// Rolling resistance of the segment in which a point is: 2 N and 4 N in turn, mean 3 N, and
    /// for n segments of each a variance of 1 · 2n/(2n - 1) N².
    fn patchwork(point: &Point) -> f64 {
        let force = if (point.time / SEGMENT_S).floor() as i64 % 2 == 0 { 2.0 } else { 4.0 };
        1.0 + force * terms(point)[1]
    }

    /// Mean and variance of the parameters that the training was made with: exact but for the
    /// leaning of each segment's estimate on the mean by 1 % (0.01 N of the deviation of 1 N; twice
    /// that in the variance, and three times as much where a segment is less excited than the
    /// average).
    #[test]
    fn the_prior_is_the_distribution_of_the_training() {
        let points = drive(10 * PER_SEGMENT, patchwork);
        let rows = rows("", &points, terms).unwrap();
        let segments: Vec<_> = rows.chunks(PER_SEGMENT).collect();
        let prior = Prior::of(&segments).unwrap();
        for (mean, truth) in prior.mean.iter().zip([1.0, 3.0, 0.0]) {
            assert!((mean - truth).abs() < 0.03, "{:?}", prior.mean);
        }
        assert!((prior.covariance[(1, 1)] - 10.0 / 9.0).abs() < 0.06, "{}", prior.covariance);
        assert!(
            prior.covariance[(0, 0)] < 0.01 && prior.noise < 1e-3,
            "{} {}",
            prior.covariance,
            prior.noise
        );
    }

    /// On a ground of 4 N it begins at the prior's 3 N, and reaches the truth within one segment.
    #[test]
    fn the_drive_updates_the_prior() {
        let mut model = Bayes::default();
        model.fit(&drive(10 * PER_SEGMENT, patchwork)).unwrap();
        let points = drive(PER_SEGMENT, |point| 1.0 + 4.0 * terms(point)[1]);
        let predicted = model.predict(&points).unwrap();
        let error = |i: usize| (predicted[i] - points[i].power) / terms(&points[i])[1];
        assert!((error(1) + 1.0).abs() < 0.3, "first {}", error(1));
        let last = (0..PER_SEGMENT).rfind(|i| points[*i].speed.vx.abs() > 0.1).unwrap();
        assert!(error(last).abs() < 0.05, "last {}", error(last));
    }

    /// One speed on level ground: the terms are collinear, and the prior holds what the segments
    /// cannot distinguish.
    #[test]
    fn one_speed_gives_finite_predictions() {
        let mut points = drive(10 * PER_SEGMENT, |point| 1.0 + 0.1 * point.time.sin());
        for point in &mut points {
            point.speed.vx = 0.2;
            point.acceleration.vx = 0.0;
            point.readings.pitch = f64::NAN;
        }
        let mut model = Bayes::default();
        model.fit(&points).unwrap();
        for power in model.predict(&points).unwrap() {
            assert!((power - 1.0).abs() < 0.11, "{power}");
        }
    }

    #[test]
    fn refuses_too_short_a_training() {
        let error = Bayes::default().fit(&drive(2 * PER_SEGMENT, patchwork)).unwrap_err().to_string();
        assert_eq!(
            error,
            "sadrpour-bayes: 2 training segments; expected at least 4 for a prior of 3 parameters"
        );
        assert!(Bayes::default().predict(&[]).unwrap_err().to_string().contains("not fitted"));
    }
}
