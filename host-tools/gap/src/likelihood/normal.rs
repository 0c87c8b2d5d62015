//! Logarithms of sums and of normal probabilities.

use std::f64::consts::PI;

use statrs::function::erf::erfc;

/// ln Σ exp x; what is no number is impossible.
pub fn log_sum(values: impl IntoIterator<Item = f64>) -> f64 {
    let impossible = |x: f64| if x.is_nan() { f64::NEG_INFINITY } else { x };
    let values: Vec<f64> = values.into_iter().map(impossible).collect();
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY {
        return most;
    }
    most + values.iter().map(|x| (x - most).exp()).sum::<f64>().ln()
}

/// ln of the mean of exp x: hypotheses that are as likely as each other.
pub fn log_mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    let count = values.len() as f64;
    log_sum(values) - count.ln()
}

/// ln Φ(x).
fn log_below(x: f64) -> f64 {
    if x > -20.0 {
        (0.5 * erfc(-x / 2.0_f64.sqrt())).ln()
    } else {
        // The first terms of the asymptotic series; the next is below 1e-7.
        let s = 1.0 / (x * x);
        -0.5 * x * x - 0.5 * (2.0 * PI).ln() - (-x).ln() + (-s + 2.5 * s * s).ln_1p()
    }
}

/// ln of the probability that a normal variable is in a range.
pub fn log_within((low, high): (f64, f64), mean: f64, std_dev: f64) -> f64 {
    let (a, b) = ((low - mean) / std_dev, (high - mean) / std_dev);
    // By the nearer tail: differences of probabilities near 1 are all rounding.
    let (near, far) = if a > 0.0 { (log_below(-a), log_below(-b)) } else { (log_below(b), log_below(a)) };
    if near <= far { f64::NEG_INFINITY } else { near + (-(far - near).exp()).ln_1p() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Φ(−8) = 6.220960574271785e−16, Φ(−25) = e^(−316.63940835) (NumPy's and SciPy's log_ndtr).
    #[test]
    fn tails_are_right_far_out() {
        let within = |low, high| log_within((low, high), 0.0, 1.0);
        assert!((within(f64::NEG_INFINITY, -8.0) - 6.220_960_574_271_785e-16_f64.ln()).abs() < 1e-9);
        assert!((within(25.0, f64::INFINITY) + 316.639_408_35).abs() < 1e-6);
        assert!((within(-1.0, 1.0) - 0.682_689_492_137_086_f64.ln()).abs() < 1e-9);
        assert!((log_within((0.0, f64::INFINITY), 0.0, 3.0) - 0.5_f64.ln()).abs() < 1e-12);
        assert!((log_mean([1.0, 1.0]) - 1.0).abs() < 1e-12);
    }
}
