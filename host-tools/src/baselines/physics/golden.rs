//! Golden-section search.

/// Where a function of one minimum is least, to a millionth of the interval.
pub(super) fn section(mut low: f64, mut high: f64, cost: impl Fn(f64) -> f64) -> f64 {
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let end = 1e-6 * (high - low);
    let inner = |low: f64, high: f64| (high - SHARE * (high - low), low + SHARE * (high - low));
    let (mut left, mut right) = inner(low, high);
    let (mut left_cost, mut right_cost) = (cost(left), cost(right));
    while high - low > end {
        if left_cost < right_cost {
            (high, right, right_cost) = (right, left, left_cost);
            left = inner(low, high).0;
            left_cost = cost(left);
        } else {
            (low, left, left_cost) = (left, right, right_cost);
            right = inner(low, high).1;
            right_cost = cost(right);
        }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::section;

    /// The interval ends a millionth of its first length wide, and a cost of order 1 near its minimum is flat to 1e-8.
    #[test]
    fn finds_the_minimum_inside_and_at_an_end() {
        let within = 3e-6;
        assert!((section(-1.0, 2.0, |x| (x - 0.3).powi(2)) - 0.3).abs() < within);
        assert!((section(-1.0, 2.0, |x| -x) - 2.0).abs() < within);
    }
}
