//! Figures over seeds: mean, interval, extremes.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::study::Spread;

impl Spread {
    /// Of one value a seed; values that are not finite are left out, and without any all is NaN.
    ///
    /// The interval is mean ± t₀.₉₇₅(n − 1) s ∕ √n: seeds are independent, and their means nearly normal.
    pub fn of(values: &[f64]) -> Self {
        let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        let count = finite.len() as f64;
        let mean = finite.iter().sum::<f64>() / count;
        let squares: f64 = finite.iter().map(|value| (value - mean).powi(2)).sum();
        let half = match StudentsT::new(0.0, 1.0, count - 1.0) {
            Ok(student) => student.inverse_cdf(0.975) * (squares / (count - 1.0) / count).sqrt(),
            Err(_) => f64::NAN,
        };
        let extreme = |pick: fn(f64, f64) -> f64| finite.iter().copied().reduce(pick).unwrap_or(f64::NAN);
        Self {
            mean,
            low: mean - half,
            high: mean + half,
            least: extreme(f64::min),
            greatest: extreme(f64::max),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    /// By hand: mean 2, s = 1, t₀.₉₇₅ of two degrees of freedom 4.302653, so ± 4.302653 ∕ √3 = 2.484138.
    #[test]
    fn three_seeds_by_hand() {
        let spread = Spread::of(&[1.0, 3.0, f64::NAN, 2.0]);
        assert_eq!([spread.mean, spread.least, spread.greatest], [2.0, 1.0, 3.0]);
        assert!((spread.low + 0.484138).abs() < 1e-6 && (spread.high - 4.484138).abs() < 1e-6, "{spread:?}");
    }

    #[test]
    fn one_seed_has_no_interval_and_none_has_nothing() {
        let one = Spread::of(&[5.0]);
        assert!(one.mean == 5.0 && one.low.is_nan() && one.high.is_nan(), "{one:?}");
        let none = Spread::of(&[f64::NAN]);
        assert!(none.mean.is_nan() && none.least.is_nan(), "{none:?}");
    }
}
