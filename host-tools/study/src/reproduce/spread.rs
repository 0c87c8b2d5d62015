//! A figure over seeds, with the interval of its mean.

use numerics::intervals::mean_interval;
use serde::Serialize;

/// A figure over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Spread {
    /// Mean over seeds.
    pub(super) mean: f64,
    /// 95 % interval of the mean (Student's t over seeds); NaN with one seed.
    pub(super) low: f64,
    /// 95 % interval of the mean (Student's t over seeds); NaN with one seed.
    pub(super) high: f64,
    /// The least of a seed.
    pub(super) least: f64,
    /// The greatest of a seed.
    pub(super) greatest: f64,
    /// Seeds that have a value.
    pub(super) count: usize,
}

impl Spread {
    /// Over one value a seed; seeds without one (NaN) do not count.
    pub(super) fn over(values: &[f64]) -> Self {
        let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        let interval = mean_interval(&known);
        let (low, high) = interval.ends().unwrap_or((f64::NAN, f64::NAN));
        Self {
            mean: interval.mean,
            low,
            high,
            least: known.iter().copied().fold(f64::NAN, f64::min),
            greatest: known.iter().copied().fold(f64::NAN, f64::max),
            count: interval.count,
        }
    }

    /// Of several figures of each seed, each over all seeds.
    pub(super) fn of_each<const N: usize>(seeds: impl Iterator<Item = [f64; N]>) -> [Self; N] {
        let seeds: Vec<[f64; N]> = seeds.collect();
        std::array::from_fn(|place| Self::over(&seeds.iter().map(|seed| seed[place]).collect::<Vec<_>>()))
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    /// By hand: 1, 2, 3, 4 have the mean 2.5 and the standard deviation 1.29099; t(3 degrees,
    /// 97.5 %) = 3.18245.
    #[test]
    fn the_interval_is_students() {
        let spread = Spread::over(&[1.0, f64::NAN, 2.0, 3.0, 4.0]);
        let half = 3.182_45 * 1.290_99 / 2.0;
        assert!((spread.mean - 2.5).abs() < 1e-12 && spread.count == 4);
        assert!(
            (spread.high - 2.5 - half).abs() < 1e-4 && (2.5 - spread.low - half).abs() < 1e-4,
            "{spread:?}"
        );
        assert_eq!((spread.least, spread.greatest), (1.0, 4.0));
    }

    #[test]
    fn one_seed_has_no_interval() {
        let spread = Spread::over(&[7.0]);
        assert!(spread.mean == 7.0 && spread.low.is_nan() && spread.high.is_nan());
        assert!(Spread::over(&[]).mean.is_nan());
    }
}
