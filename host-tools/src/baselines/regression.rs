//! Ordinary least squares over a few terms of a point: what most regressions of the literature are.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::{Baseline, Parameter, Point};
use crate::error::{Error, Result};

/// Symbol and unit of a coefficient.
pub type Symbol = (&'static str, &'static str);

/// What coefficients multiply: as many for every point.
pub type Terms<T> = Box<dyn Fn(&Point) -> T>;

/// A regression of the power on terms of a point.
pub struct Regression {
    /// In refusals.
    name: &'static str,
    /// Of every coefficient, or of none.
    symbols: Vec<Symbol>,
    terms: Terms<Vec<f64>>,
    coefficients: Option<Vec<f64>>,
}

impl Regression {
    /// Not fitted, with a coefficient for each of these symbols.
    pub fn new<const TERMS: usize>(
        name: &'static str,
        symbols: [Symbol; TERMS],
        terms: impl Fn(&Point) -> [f64; TERMS] + 'static,
    ) -> Self {
        Self::sized(name, symbols.to_vec(), move |point| terms(point).to_vec())
    }

    /// Not fitted, where the robot tells how many terms there are; without symbols the coefficients have no names.
    pub fn sized(
        name: &'static str,
        symbols: Vec<Symbol>,
        terms: impl Fn(&Point) -> Vec<f64> + 'static,
    ) -> Self {
        Self { name, symbols, terms: Box::new(terms), coefficients: None }
    }

    /// The coefficients, once fitted.
    pub fn coefficients(&self) -> Option<&[f64]> {
        self.coefficients.as_deref()
    }
}

impl Baseline for Regression {
    /// Terms that repeat others (the mass, where there is only one) get the smallest share.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.coefficients = None;
        let rows = rows(self.name, training, &self.terms)?;
        let failed = || Error::failed(format!("{}: the regression has no finite solution", self.name));
        self.coefficients = Some(least_squares(&rows).ok_or_else(failed)?);
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let coefficients = self.coefficients.as_ref().ok_or_else(|| unfitted(self.name))?;
        Ok(points.iter().map(|point| weigh(&(self.terms)(point), coefficients)).collect())
    }

    fn parameters(&self) -> Vec<Parameter> {
        named(&self.symbols, self.coefficients.as_deref().unwrap_or_default())
    }
}

/// Terms of a point, and its power.
pub type Observation<T> = (T, f64);

/// The terms and the power of every training point.
///
/// # Errors
/// Fewer points than terms, or a point whose terms or power are not finite.
pub fn rows<T: AsRef<[f64]>>(
    name: &str,
    training: &[Point],
    terms: impl Fn(&Point) -> T,
) -> Result<Vec<Observation<T>>> {
    let rows: Vec<_> = training.iter().map(|point| (terms(point), point.power)).collect();
    let expected = rows.first().map_or(1, |(terms, _)| terms.as_ref().len());
    if rows.len() < expected {
        return Err(Error::failed(format!(
            "{name}: {} training points; expected at least {expected}, one for each coefficient",
            rows.len()
        )));
    }
    let broken = |(terms, power): &Observation<T>| {
        !(power.is_finite() && terms.as_ref().iter().all(|term| term.is_finite()))
    };
    if let Some(index) = rows.iter().position(broken) {
        let (terms, power) = &rows[index];
        return Err(Error::failed(format!(
            "{name}: training point {index} has the terms {:?} and a power of {power} W; expected finite numbers",
            terms.as_ref()
        )));
    }
    Ok(rows)
}

/// The coefficients that lower the sum of squared residuals most, the smallest where several do. `None` without rows, and if
/// a sum is not finite.
pub fn least_squares<T: AsRef<[f64]>>(rows: &[Observation<T>]) -> Option<Vec<f64>> {
    let count = rows.first()?.0.as_ref().len();
    let mut normal = DMatrix::<f64>::zeros(count, count);
    let mut right = DVector::<f64>::zeros(count);
    for (terms, value) in rows {
        let x = DVectorView::from_slice(terms.as_ref(), count);
        normal.ger(1.0, &x, &x, 1.0);
        right.axpy(*value, &x, 1.0);
    }
    if normal.iter().chain(&right).any(|sum| !sum.is_finite()) {
        return None;
    }
    let scale = normal.diagonal().map(|square| if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(count, count, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let solution = scaled.pseudo_inverse(1e-10).ok()? * right.component_mul(&scale);
    let solution = solution.component_mul(&scale);
    solution.iter().all(|value| value.is_finite()).then(|| solution.as_slice().to_vec())
}

/// Σ c x, W; NaN if that is not finite.
pub fn weigh(terms: &[f64], coefficients: &[f64]) -> f64 {
    let sum: f64 = terms.iter().zip(coefficients).map(|(x, c)| x * c).sum();
    if sum.is_finite() { sum } else { f64::NAN }
}

/// The values with their symbols.
pub(super) fn named(symbols: &[Symbol], values: &[f64]) -> Vec<Parameter> {
    let parameter = |((name, unit), value): (&Symbol, &f64)| Parameter { name, value: *value, unit };
    symbols.iter().zip(values).map(parameter).collect()
}

/// Asked to predict before it has learned.
pub(super) fn unfitted(name: &str) -> Error {
    Error::failed(format!("{name}: not fitted"))
}

#[cfg(test)]
mod tests {
    use super::{Regression, least_squares};
    use crate::baselines::testing::drive;
    use crate::baselines::{Baseline, Point};

    fn line() -> Regression {
        Regression::new("line", [("a", "W"), ("b", "W s/m")], |point| [1.0, point.speed.vx])
    }

    /// y = 1 + 2 x and the residuals (1, -2, 1), which sum to 0 and are orthogonal to x: exact in small integers.
    #[test]
    fn residuals_are_orthogonal_to_the_terms() {
        let found = least_squares(&[([1.0, 0.0], 2.0), ([1.0, 1.0], 1.0), ([1.0, 2.0], 6.0)]).unwrap();
        assert!((found[0] - 1.0).abs() < 1e-12 && (found[1] - 2.0).abs() < 1e-12, "{found:?}");
    }

    /// Of x + y = 2 with equal columns the smallest solution is (1, 1); a column of zeros gets 0.
    #[test]
    fn shares_what_repeats_and_leaves_out_what_is_not_there() {
        let found = least_squares(&[([1.0, 1.0, 0.0], 2.0), ([2.0, 2.0, 0.0], 4.0)]).unwrap();
        assert!(found.iter().zip([1.0, 1.0, 0.0]).all(|(found, truth)| (found - truth).abs() < 1e-12));
        assert!(least_squares::<[f64; 2]>(&[]).is_none());
    }

    #[test]
    fn refuses_what_it_cannot_learn_from() {
        let points = drive(10, |_| 1.0);
        let refusal = |points: &[Point]| line().fit(points).unwrap_err().to_string();
        assert_eq!(
            refusal(&points[..1]),
            "line: 1 training points; expected at least 2, one for each coefficient"
        );
        assert!(refusal(&[]).contains("0 training points"));
        let mut broken = points.clone();
        broken[3].speed.vx = f64::NAN;
        assert!(refusal(&broken).starts_with("line: training point 3 has the terms [1.0, NaN]"));
        broken[3] = Point { power: f64::INFINITY, ..points[3] };
        assert!(refusal(&broken).contains("a power of inf W"));
        assert_eq!(line().predict(&points).unwrap_err().to_string(), "line: not fitted");
        assert!(line().parameters().is_empty());
    }

    #[test]
    fn predicts_nothing_for_what_is_not_finite() {
        let mut points = drive(10, |_| 1.0);
        let mut model = line();
        model.fit(&points).unwrap();
        points[1].speed.vx = f64::NAN;
        points[2].speed.vx = f64::INFINITY;
        let finite: Vec<bool> =
            model.predict(&points).unwrap().iter().map(|power| power.is_finite()).collect();
        assert_eq!(finite[..4], [true, false, false, true]);
        assert!(model.predict(&points).unwrap()[2].is_nan());
    }
}
