//! Recursive least squares: parameters that are learned while driving.

use nalgebra::{SMatrix, SVector};

use crate::baselines::point::Point;
use crate::baselines::regression::weigh;

/// Largest variance of a parameter, in variances of the power's noise per squared SI unit: the
/// start where nothing is known, and the limit of forgetting. It is negligible beside the
/// information of one minute of driving, at least about 1 in these units.
const DIFFUSE: f64 = 1e6;

/// Limit of forgetting in one step, whatever the time since the last.
const MOST_FORGETTING: f64 = 0.01;

/// Parameters of a power that is linear in them, and how well they are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recursive<const TERMS: usize> {
    estimate: SVector<f64, TERMS>,
    /// In variances of the power's noise.
    covariance: SMatrix<f64, TERMS, TERMS>,
}

impl<const TERMS: usize> Recursive<TERMS> {
    /// Nothing is known.
    pub fn diffuse() -> Self {
        Self { estimate: SVector::zeros(), covariance: SMatrix::identity() * DIFFUSE }
    }

    /// A normal prior; the covariance in variances of the power's noise.
    pub fn with_prior(mean: [f64; TERMS], covariance: SMatrix<f64, TERMS, TERMS>) -> Self {
        Self { estimate: mean.into(), covariance }
    }

    /// The parameters.
    pub fn estimate(&self) -> [f64; TERMS] {
        self.estimate.into()
    }

    /// The same parameters, known as if from this share of the data (above 0 and at most 1).
    #[must_use]
    pub fn forget(&self, share: f64) -> Self {
        let covariance = self.covariance / share.clamp(MOST_FORGETTING, 1.0);
        let within = covariance.diagonal().map(|variance| (DIFFUSE / variance.max(DIFFUSE)).sqrt());
        // Without bounds, forgetting what is not refreshed lets its variance grow to infinity
        // (wind-up).
        Self { covariance: covariance.component_mul(&(within * within.transpose())), ..*self }
    }

    /// Forgets by a factor λ (1: nothing), then learns from one power. Ignores what is not finite.
    pub fn update(&mut self, terms: &[f64; TERMS], power: f64, forgetting: f64) {
        if !(power.is_finite() && terms.iter().all(|term| term.is_finite())) {
            return;
        }
        *self = self.forget(forgetting);
        let x = SVector::from(*terms);
        let spread = self.covariance * x;
        let gain = spread / (1.0 + x.dot(&spread));
        self.estimate += gain * (power - x.dot(&self.estimate));
        let covariance = self.covariance - gain * spread.transpose();
        // Rounding must not make it lopsided: errors grow exponentially with forgetting.
        self.covariance = (covariance + covariance.transpose()) * 0.5;
    }

    /// Predicts the power of every point from the powers before it in its run; each run begins with
    /// the present knowledge. Knowledge loses the weight exp(-Δt / `memory_s`) from point to point.
    pub fn drive(&self, points: &[Point], memory_s: f64, terms: impl Fn(&Point) -> [f64; TERMS]) -> Vec<f64> {
        let mut powers = Vec::with_capacity(points.len());
        for run in points.chunk_by(|a, b| a.run == b.run) {
            let (mut known, mut last) = (*self, run[0].time);
            for point in run {
                let terms = terms(point);
                powers.push(weigh(&terms, &known.estimate()));
                known.update(&terms, point.power, (-(point.time - last).max(0.0) / memory_s).exp());
                last = point.time;
            }
        }
        powers
    }
}

#[cfg(test)]
mod tests {
    use super::{DIFFUSE, Recursive};
    use crate::baselines::regression::least_squares;
    use crate::baselines::testing::drive;
    use crate::baselines::{Point, longitudinal};

    /// A smooth disturbance that no term explains, so that the estimate keeps changing.
    fn rows() -> Vec<([f64; 3], f64)> {
        let points = drive(1000, |point| 0.5 + 3.0 * point.speed.vx.abs() + (7.0 * point.time).sin());
        points.iter().map(|point| (longitudinal::terms(point), point.power)).collect()
    }

    /// Without forgetting it ends at the batch solution, but for the prior, whose pull is at most
    /// |θ| / (DIFFUSE λ), with the smallest eigenvalue λ of XᵀX (asserted above 1) and |θ| below
    /// 10.
    #[test]
    fn agrees_with_the_batch_where_nothing_is_forgotten() {
        let rows = rows();
        let mut recursive = Recursive::diffuse();
        let mut gram = nalgebra::Matrix3::zeros();
        for (terms, power) in &rows {
            recursive.update(terms, *power, 1.0);
            let x = nalgebra::Vector3::from(*terms);
            gram += x * x.transpose();
        }
        assert!(gram.symmetric_eigenvalues().min() > 1.0, "{gram}");
        for (recursive, batch) in recursive.estimate().iter().zip(least_squares(&rows).unwrap()) {
            assert!((recursive - batch).abs() < 10.0 / DIFFUSE, "{recursive} {batch}");
        }
    }

    /// With forgetting λ it minimises the sum of squares weighted by λ^age: the batch solution of
    /// rows scaled by the root.
    #[test]
    fn agrees_with_the_weighted_batch_where_it_forgets() {
        let (rows, forgetting) = (rows(), 0.99_f64);
        let mut recursive = Recursive::diffuse();
        let mut weighted = Vec::new();
        for (index, (terms, power)) in rows.iter().enumerate() {
            recursive.update(terms, *power, forgetting);
            let root = forgetting.powf(0.5 * (rows.len() - 1 - index) as f64);
            weighted.push((terms.map(|term| root * term), root * power));
        }
        // A weight of 100 rows in place of 1000: a tenth of the information above, hence ten times
        // the tolerance.
        for (recursive, batch) in recursive.estimate().iter().zip(least_squares(&weighted).unwrap()) {
            assert!((recursive - batch).abs() < 100.0 / DIFFUSE, "{recursive} {batch}");
        }
    }

    /// An hour of standing forgets the other parameters, but stays finite and learns again from the
    /// first motion.
    #[test]
    fn does_not_wind_up() {
        let mut recursive = Recursive::diffuse();
        for (terms, power) in rows() {
            recursive.update(&terms, power, 1.0);
        }
        for _ in 0..72_000 {
            recursive.update(&[1.0, 0.0, 0.0], 0.5, 0.9);
        }
        let bound = recursive.covariance.diagonal().max();
        assert!((bound / DIFFUSE - 1.0).abs() < 1e-9, "{bound}");
        for (terms, _) in rows() {
            recursive.update(&terms, 0.5 + 4.0 * terms[1], 1.0);
        }
        assert!((recursive.estimate()[1] - 4.0).abs() < 1e-4, "{:?}", recursive.estimate());
    }

    #[test]
    fn ignores_what_is_not_finite() {
        let mut recursive = Recursive::diffuse();
        recursive.update(&[1.0, f64::NAN], 1.0, 1.0);
        recursive.update(&[1.0, 1.0], f64::NAN, 1.0);
        recursive.update(&[1.0, f64::INFINITY], 1.0, 1.0);
        assert_eq!(recursive, Recursive::diffuse());
    }

    /// A point's own power and later ones must not reach its prediction, nor must those of another
    /// run.
    #[test]
    fn predicts_from_the_past_of_the_same_run() {
        let mut points = drive(200, |point| 0.5 + 3.0 * point.speed.vx.abs());
        points[100..].iter_mut().for_each(|point| point.run = 1);
        let known = Recursive::with_prior([0.1, 1.0, 0.0], nalgebra::Matrix3::identity());
        let predict = |points: &[Point]| known.drive(points, 60.0, longitudinal::terms);
        let before = predict(&points);
        points[50].power += 100.0;
        let after = predict(&points);
        let same: Vec<bool> = before.iter().zip(&after).map(|(before, after)| before == after).collect();
        assert!(same[..=50].iter().all(|same| *same), "the past and itself");
        assert!(same[51..100].iter().all(|same| !same), "its future");
        assert!(same[100..].iter().all(|same| *same), "another run");
    }
}
