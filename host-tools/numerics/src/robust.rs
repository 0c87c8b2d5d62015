//! Order statistics, and scales that a few wild values do not move.

/// Standard deviation of a normal variable over the median of its size: 1/Φ⁻¹(3/4) = 1.482602…,
/// since half of |N(0, 1)| is below Φ⁻¹(3/4) = 0.674490.
pub const MEDIAN_TO_STD: f64 = 1.482_602_218_505_602;

/// Size that a standard normal variable exceeds once in twenty: Φ⁻¹(0.975). For quantiles of a
/// known distribution; an interval of a mean over a handful of values takes
/// [`super::intervals::mean_interval`].
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// What a standard normal variable exceeds once in twenty, to one side: Φ⁻¹(0.95).
pub const ONE_SIDED_95: f64 = 1.644_853_626_951_472;

/// The middle value, the mean of the two middle ones of an even number; `None` of none. Reorders
/// the values. NaN sorts after every number.
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let odd = values.len() % 2 == 1;
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    if odd {
        return Some(upper);
    }
    let lower = below.iter().copied().max_by(f64::total_cmp)?;
    Some(0.5 * (lower + upper))
}

/// The value that a share (0 to 1) of the others lies below, linear between neighbours (definition
/// 7 of Hyndman and Fan 1996, NumPy's default); `None` of no values. Reorders the values.
pub fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let place = share.clamp(0.0, 1.0) * values.len().checked_sub(1)? as f64;
    let below = place.floor() as usize;
    let (_, low, above) = values.select_nth_unstable_by(below, f64::total_cmp);
    let low = *low;
    let high = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
    let between = place - below as f64;
    // At a value itself its neighbour does not count, however large.
    Some(if between > 0.0 { low + between * (high - low) } else { low })
}

/// Standard deviation of zero-mean normal values, from the median of their sizes; `None` of none.
/// Takes sizes |x|, reorders them.
pub fn scale_of_sizes(sizes: &mut [f64]) -> Option<f64> {
    median(sizes).map(|middle| MEDIAN_TO_STD * middle)
}

/// Standard deviation of normal values about their median (the median absolute deviation, scaled);
/// `None` of none.
pub fn scale(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    let middle = median(&mut sorted)?;
    for value in &mut sorted {
        *value = (*value - middle).abs();
    }
    scale_of_sizes(&mut sorted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn constants_are_those_of_the_normal_distribution() {
        let normal = Normal::standard();
        assert!((MEDIAN_TO_STD * normal.inverse_cdf(0.75) - 1.0).abs() < 1e-12);
        assert!((NORMAL_95 - normal.inverse_cdf(0.975)).abs() < 1e-12);
        assert!((ONE_SIDED_95 - normal.inverse_cdf(0.95)).abs() < 1e-12);
    }

    #[test]
    fn median_of_odd_even_and_none() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 30.0]), Some(3.0));
        assert_eq!(median(&mut [5.0]), Some(5.0));
        assert_eq!(median(&mut []), None);
    }

    /// By numpy.quantile([1, 2, 4, 8, 16], …).
    #[test]
    fn quantiles_are_linear_between_neighbours() {
        let at = |share| quantile(&mut [8.0, 1.0, 16.0, 4.0, 2.0], share).unwrap();
        for (share, expected) in [(0.0, 1.0), (0.1, 1.4), (0.5, 4.0), (0.9, 12.8), (1.0, 16.0)] {
            assert!((at(share) - expected).abs() < 1e-12, "{share}");
        }
        assert_eq!(quantile(&mut [], 0.5), None);
        assert_eq!(quantile(&mut [1.0, f64::INFINITY], 0.0), Some(1.0));
    }

    /// A quarter of a normal sample thrown far away moves the scale by less than a third: the 50 %
    /// of |x| becomes the 2/3 quantile, Φ⁻¹(5/6)/Φ⁻¹(3/4) = 1.434, and no outlier's size enters.
    #[test]
    fn scale_does_not_see_sizes_of_outliers() {
        let normal = Normal::standard();
        let clean: Vec<f64> = (1..3000).map(|k| 2.0 * normal.inverse_cdf(f64::from(k) / 3000.0)).collect();
        assert!((scale(&clean).unwrap() - 2.0).abs() < 0.01);
        let mut spoiled = clean.clone();
        spoiled.extend((0..500).flat_map(|k| [1e3 + f64::from(k), -1e6 - f64::from(k)]));
        assert!((scale(&spoiled).unwrap() / 2.0 - 1.434).abs() < 0.01, "{:?}", scale(&spoiled));
        assert_eq!(scale(&[]), None);
    }
}
