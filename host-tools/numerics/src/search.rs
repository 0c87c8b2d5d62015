//! Minima and roots of functions of one variable, without derivatives.

/// A minimum that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minimum {
    /// Where.
    pub at: f64,
    /// The function there; never NaN.
    pub cost: f64,
}

/// 1/φ: each step of the search keeps this share of the interval.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Golden-section search (Kiefer 1953) for the minimum of a function with one minimum between `low`
/// and `high`, to the share `tolerance` of the interval. A cost that is not a number counts as
/// infinite. `None` where every cost met was.
pub fn golden_section(
    mut low: f64,
    mut high: f64,
    tolerance: f64,
    mut cost: impl FnMut(f64) -> f64,
) -> Option<Minimum> {
    let mut best: Option<Minimum> = None;
    let mut tried = |at: f64| {
        let value = finite(cost(at));
        if value < f64::INFINITY && best.is_none_or(|best| value < best.cost) {
            best = Some(Minimum { at, cost: value });
        }
        value
    };
    let end = tolerance.max(f64::EPSILON) * (high - low).abs();
    let inner = |low: f64, high: f64| (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut left, mut right) = inner(low, high);
    let (mut left_cost, mut right_cost) = (tried(left), tried(right));
    while high - low > end {
        if left_cost < right_cost {
            (high, right, right_cost) = (right, left, left_cost);
            left = inner(low, high).0;
            left_cost = tried(left);
        } else {
            (low, left, left_cost) = (left, right, right_cost);
            right = inner(low, high).1;
            right_cost = tried(right);
        }
    }
    best
}

/// The best of `grid` (ascending), then golden section between its neighbours: for functions with
/// several minima, as many as the grid can separate. Never worse than the grid's best. `None` where
/// no cost on the grid is a number.
pub fn grid_then_golden(grid: &[f64], tolerance: f64, mut cost: impl FnMut(f64) -> f64) -> Option<Minimum> {
    let costs: Vec<f64> = grid.iter().map(|at| finite(cost(*at))).collect();
    let (place, best) = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
    if best.is_infinite() {
        return None;
    }
    let (low, high) = (grid[place.saturating_sub(1)], grid[(place + 1).min(grid.len() - 1)]);
    let on_grid = Minimum { at: grid[place], cost: *best };
    let refined = golden_section(low, high, tolerance, cost);
    Some(refined.filter(|refined| refined.cost < on_grid.cost).unwrap_or(on_grid))
}

/// Where a function that is above 0 at `low` and not at `high` crosses it, to a double's precision
/// of the interval.
pub fn bisect(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

fn finite(cost: f64) -> f64 {
    if cost.is_nan() { f64::INFINITY } else { cost }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interval ends a millionth of its first length wide, and a cost of order 1 near its
    /// minimum is flat to 1e-8.
    #[test]
    fn finds_the_minimum_inside_and_at_an_end() {
        let at = |cost: fn(f64) -> f64| golden_section(-1.0, 2.0, 1e-6, cost).unwrap().at;
        assert!((at(|x| (x - 0.3).powi(2)) - 0.3).abs() < 3e-6);
        assert!((at(|x| -x) - 2.0).abs() < 3e-6);
    }

    /// cos(3 x) + x/10 has minima at 3 x = π − asin(1/30) (mod 2π); the one left of 0 is the least
    /// on [−2, 4].
    #[test]
    fn a_grid_finds_the_least_of_several() {
        let grid: Vec<f64> = (0..13).map(|k| -2.0 + 0.5 * f64::from(k)).collect();
        let least = grid_then_golden(&grid, 1e-7, |x| (3.0 * x).cos() + x / 10.0).unwrap();
        let truth = -((1.0_f64 / 30.0).asin() + std::f64::consts::PI) / 3.0;
        assert!((least.at - truth).abs() < 1e-6, "{least:?} {truth}");
    }

    #[test]
    fn a_cost_that_is_no_number_is_never_the_least() {
        let root = |x: f64| if x < 0.5 { f64::NAN } else { x };
        let least = golden_section(0.0, 1.0, 1e-6, root).unwrap();
        assert!(least.cost >= 0.5 && least.cost < 0.62, "{least:?}");
        assert!(golden_section(0.0, 1.0, 1e-6, |_| f64::NAN).is_none());
        assert!(grid_then_golden(&[0.0, 1.0], 1e-6, |_| f64::NAN).is_none());
        assert!(grid_then_golden(&[], 1e-6, |x| x).is_none());
    }
}
