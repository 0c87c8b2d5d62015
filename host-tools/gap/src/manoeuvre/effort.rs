//! How often a profile has to be driven to distinguish rivals with a wanted probability.

use statrs::distribution::{ContinuousCDF, Normal};

use residuals::thresholds::detect::NO_DIFFERENCE;
use residuals::thresholds::manoeuvre::TRUSTED;

/// The probability of distinguishing rivals that are expected to differ by `z` standard errors.
///
/// The difference of their χ² is normal about z² with a standard deviation of 2 z, and has to
/// exceed the tie's 9, with the share of z that is [`TRUSTED`].
pub fn probability(z: f64) -> f64 {
    let z = TRUSTED * z;
    if z <= 0.0 || z.is_nan() {
        return 0.0;
    }
    Normal::standard().cdf((z * z - NO_DIFFERENCE.powi(2)) / (2.0 * z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_expected_at_the_tie_s_edge_is_parted_every_other_time() {
        assert!((probability(NO_DIFFERENCE / TRUSTED) - 0.5).abs() < 1e-12);
        assert!(probability(2.0 * NO_DIFFERENCE / TRUSTED) > 0.98);
        assert_eq!(probability(0.0), 0.0);
        // 9.0816 by hand: z' = q + √(q² + 9) with q = 1.2816 is 4.544, and twice that for the
        // model.
        assert!((probability(9.0876) - 0.9).abs() < 1e-4, "{}", probability(9.0876));
    }
}
