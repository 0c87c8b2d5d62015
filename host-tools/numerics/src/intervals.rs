//! What a handful of values says about its mean.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A mean with its 95 % interval, `mean` ± `half_width`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanInterval {
    /// Arithmetic mean; NaN of no values.
    pub mean: f64,
    /// Standard deviation of the values (n − 1); `None` below two.
    pub std_dev: Option<f64>,
    /// Half the 95 % interval of the mean; `None` below two values: one value says nothing about
    /// its own scatter.
    pub half_width: Option<f64>,
    /// How many values.
    pub count: usize,
}

impl MeanInterval {
    /// Ends of the interval.
    pub fn ends(&self) -> Option<(f64, f64)> {
        self.half_width.map(|half| (self.mean - half, self.mean + half))
    }

    /// Whether the whole interval is above `value`; false where there is no interval.
    pub fn is_above(&self, value: f64) -> bool {
        self.ends().is_some_and(|(low, _)| low > value)
    }

    /// Standard error of the mean; `None` below two values.
    pub fn std_err(&self) -> Option<f64> {
        self.std_dev.map(|std_dev| std_dev / (self.count as f64).sqrt())
    }
}

/// The mean of independent values with its 95 % interval by Student's t; right for normal values,
/// whatever their number.
pub fn mean_interval(values: &[f64]) -> MeanInterval {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let freedom = count as f64 - 1.0;
    let std_dev = (count > 1)
        .then(|| (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / freedom).sqrt());
    let half_width = std_dev.and_then(|std_dev| Some(student_95(freedom)? * std_dev / (count as f64).sqrt()));
    MeanInterval { mean, std_dev, half_width, count }
}

/// Size that Student's t with so many degrees of freedom exceeds once in twenty; `None` without a
/// degree of freedom.
pub fn student_95(freedom: f64) -> Option<f64> {
    StudentsT::new(0.0, 1.0, freedom).ok().map(|student| student.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// By hand: 1, 2, 3, 4 have the mean 2.5 and the standard deviation 1.29099; t(3 degrees,
    /// 97.5 %) = 3.18245.
    #[test]
    fn the_interval_is_students() {
        let interval = mean_interval(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!((interval.mean, interval.count), (2.5, 4));
        assert!((interval.std_dev.unwrap() - 1.290_994_45).abs() < 1e-8);
        assert!((interval.half_width.unwrap() - 3.182_446_3 * 1.290_994_45 / 2.0).abs() < 1e-6);
        assert!(interval.is_above(0.4) && !interval.is_above(0.5));
    }

    #[test]
    fn one_value_has_no_interval() {
        let interval = mean_interval(&[7.0]);
        assert_eq!((interval.mean, interval.std_dev, interval.half_width), (7.0, None, None));
        assert!(!interval.is_above(-1e9));
        assert!(mean_interval(&[]).mean.is_nan());
    }

    /// Of 2,000 means of three normal values 95 % are inside; the binomial's standard deviation is
    /// 0.5 %. With 1.96 it were 81 %.
    #[test]
    fn covers_with_three_values() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let inside = (0..2000).filter(|_| {
            let values: [f64; 3] = std::array::from_fn(|_| random.sample::<f64, _>(StandardNormal));
            let (low, high) = mean_interval(&values).ends().unwrap();
            low <= 0.0 && high >= 0.0
        });
        let share = inside.count() as f64 / 2000.0;
        assert!((0.935..0.965).contains(&share), "{share}");
    }
}
