//! Multivariate linear regression on the body's motion: Leng 2024 (Eq. 30), with mass as in Parasuraman 2014 (Eq. 31).

use nalgebra::{DMatrix, DVector};

use super::{Baseline, Point};
use crate::error::{Error, Result};

const TERMS: usize = 8;

/// Eq. 31. The slope terms of Eq. 30 are nought on level ground.
#[derive(Debug, Clone, Default)]
pub struct Linear {
    coefficients: Option<[f64; TERMS]>,
}

impl Linear {
    /// c0 … c7 of Eq. 31, once fitted.
    pub fn coefficients(&self) -> Option<&[f64; TERMS]> {
        self.coefficients.as_ref()
    }
}

/// 1, v, max(v̇, 0) v, min(v̇, 0) v, ω, max(ω̇, 0) ω, min(ω̇, 0) ω, m.
fn terms(point: &Point) -> [f64; TERMS] {
    let (v, omega) = (point.speed.vx, point.speed.omega);
    let (dv, domega) = (point.acceleration.vx, point.acceleration.omega);
    [
        1.0,
        v,
        dv.max(0.0) * v,
        dv.min(0.0) * v,
        omega,
        domega.max(0.0) * omega,
        domega.min(0.0) * omega,
        point.mass,
    ]
}

impl Baseline for Linear {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn source(&self) -> &'static str {
        "multivariate linear regression, Leng 2024 with mass (Eq. 31)"
    }

    /// Ordinary least squares. Terms that repeat others (the mass, where there is only one) get the smallest share.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        let mut normal = DMatrix::<f64>::zeros(TERMS, TERMS);
        let mut right = DVector::<f64>::zeros(TERMS);
        for point in training {
            let x = DVector::from_row_slice(&terms(point));
            normal.ger(1.0, &x, &x, 1.0);
            right.axpy(point.power, &x, 1.0);
        }
        let scale = normal.diagonal().map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(TERMS, TERMS, |i, j| normal[(i, j)] * scale[i] * scale[j]);
        let inverse = scaled
            .pseudo_inverse(1e-10)
            .map_err(|error| Error::failed(format!("the linear regression has no solution: {error}")))?;
        let solution = inverse * right.component_mul(&scale);
        let coefficients: [f64; TERMS] = std::array::from_fn(|i| solution[i] * scale[i]);
        if coefficients.iter().any(|value| !value.is_finite()) {
            return Err(Error::failed("the linear regression has no finite solution"));
        }
        self.coefficients = Some(coefficients);
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let coefficients = self.coefficients.ok_or_else(|| Error::failed("linear: not fitted"))?;
        let predict = |point: &Point| terms(point).iter().zip(&coefficients).map(|(x, c)| x * c).sum();
        Ok(points.iter().map(predict).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::{Linear, TERMS, terms};
    use crate::baselines::{Baseline, Point};
    use model_core::kinematics::Twist;

    /// Data made by Eq. 31 itself give its coefficients back.
    #[test]
    fn recovers_its_own_coefficients() {
        let truth: [f64; TERMS] = [0.3, 2.0, 5.0, -1.0, 0.4, 0.7, -0.2, 0.05];
        let wave = |i: usize, k: f64| (i as f64 * k).sin();
        let points: Vec<Point> = (0..2000)
            .map(|i| {
                let mut point = Point {
                    speed: Twist { vx: wave(i, 0.11), vy: 0.0, omega: 2.0 * wave(i, 0.17) },
                    acceleration: Twist { vx: wave(i, 0.23), vy: 0.0, omega: wave(i, 0.31) },
                    mass: 1.0 + (i % 3) as f64,
                    power: 0.0,
                };
                point.power = terms(&point).iter().zip(&truth).map(|(x, c)| x * c).sum();
                point
            })
            .collect();
        let mut model = Linear::default();
        model.fit(&points).unwrap();
        for (found, expected) in model.coefficients().unwrap().iter().zip(&truth) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let predicted = model.predict(&points).unwrap();
        assert!(predicted.iter().zip(&points).all(|(p, point)| (p - point.power).abs() < 1e-9));
    }
}
