//! The size of a cause in the plant: the one with the least gap of the simulated open runs.

use support::error::Result;

use residuals::thresholds::driven_plant::{FIRST_SIZE, SAME_SIZE, SIZE_STEPS};

/// Searches a size within a range by secants: the change of power with the last step sets the next.
/// `power` gives the simulated power of all runs, `now` is that without the cause.
///
/// # Errors
/// What the plant refuses.
pub fn size(
    mut power: impl FnMut(f64) -> Result<Vec<f64>>,
    measured: &[f64],
    now: &[f64],
    (low, high): (f64, f64),
) -> Result<(f64, Vec<f64>)> {
    let residual = |power: &[f64]| -> Vec<f64> { measured.iter().zip(power).map(|(m, p)| m - p).collect() };
    let mut best = (0.0, now.to_vec());
    let mut last = best.clone();
    let mut size = (FIRST_SIZE * high).clamp(low, high);
    for _ in 0..SIZE_STEPS {
        let there = power(size)?;
        if squares(&residual(&there)) < squares(&residual(&best.1)) {
            best = (size, there.clone());
        }
        let slope: Vec<f64> = there.iter().zip(&last.1).map(|(t, l)| (t - l) / (size - last.0)).collect();
        let steep = squares(&slope);
        if steep <= 0.0 {
            break;
        }
        let along: f64 = residual(&there).iter().zip(&slope).map(|(r, s)| r * s).sum();
        let next = (size + along / steep).clamp(low, high);
        last = (size, there);
        if (next - size).abs() <= SAME_SIZE * next.abs().max(size.abs()) {
            break;
        }
        size = next;
    }
    Ok(best)
}

/// Sum of squares.
pub(super) fn squares(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum()
}

#[cfg(test)]
mod tests {
    use super::size;

    /// Powers that grow with the size and a little with its square: (1 + 0.2 s) s x, wanted at s =
    /// −1.3.
    #[test]
    fn a_size_is_found_within_a_few_runs_on_either_side_of_zero() {
        let x: Vec<f64> = (0..50).map(|k| (f64::from(k) * 0.7).sin()).collect();
        let at = |s: f64| -> Vec<f64> { x.iter().map(|x| (1.0 + 0.2 * s) * s * x).collect() };
        let mut runs = 0;
        let mut power = |s: f64| {
            runs += 1;
            Ok(at(s))
        };
        let (best, there) = size(&mut power, &at(-1.3), &at(0.0), (-2.0, 2.0)).unwrap();
        assert!((best + 1.3).abs() < 0.005, "{best}");
        assert_eq!(there, at(best));
        assert!(runs <= 6);
        // An end of the range stops it.
        let (best, _) = size(|s| Ok(at(s)), &at(-1.3), &at(0.0), (0.0, 2.0)).unwrap();
        assert!(best.abs() < 1e-12, "{best}");
    }
}
