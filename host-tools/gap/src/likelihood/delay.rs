//! Power that is late, without what interpolation takes from it.
//!
//! Cubics through four rows smooth what changes fast, the more the farther between two rows, and
//! whichever sign a delay has: a likelihood takes that for an effect. The filter passes next to
//! nothing above its cutoff, so a sine cardinal under a window of some rows shifts it as it is.

use std::f64::consts::PI;

/// Rows on either side. Chosen: the window errs by 2e-4 of what is below six tenths of the band.
const REACH: isize = 8;

/// Shape of Kaiser's window. Derived: of 7, 8, 9 and 10 the one that errs least there: 1e-3, 4e-4,
/// 2e-4, and 4e-4 again, as the window cuts off what is above.
const KAISER: f64 = 9.0;

/// Values as they would be seen `delay` s later, rows being `period_s` apart; ends hold.
pub fn later(values: &[f64], delay: f64, period_s: f64) -> Vec<f64> {
    let rows = delay / period_s;
    let whole = rows.round();
    let fraction = rows - whole;
    let last = values.len() as isize - 1;
    if last < 0 {
        return Vec::new();
    }
    let weights: Vec<f64> = (-REACH..=REACH).map(|k| weight(k as f64 + fraction)).collect();
    let sum: f64 = weights.iter().sum();
    (0..=last)
        .map(|t| {
            let from = t - whole as isize;
            let taken = (-REACH..=REACH).zip(&weights);
            taken.map(|(k, weight)| weight * values[(from + k).clamp(0, last) as usize]).sum::<f64>() / sum
        })
        .collect()
}

fn weight(x: f64) -> f64 {
    let share = x / (REACH as f64 + 0.5);
    if share.abs() >= 1.0 {
        return 0.0;
    }
    let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    sinc * bessel(KAISER * (1.0 - share * share).sqrt()) / bessel(KAISER)
}

/// The modified Bessel function of the first kind, of order 0.
fn bessel(x: f64) -> f64 {
    let square = 0.25 * x * x;
    let terms = (1..30).scan(1.0, |term, k| {
        *term *= square / f64::from(k * k);
        Some(*term)
    });
    1.0 + terms.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 5.6 Hz in rows of 50 ms, 63 ms later: to 3e-4 of its size.
    #[test]
    fn what_a_filter_passes_is_shifted_as_it_is() {
        let wave = |time: f64| (2.0 * PI * 5.6 * time + 0.4).sin();
        let values: Vec<f64> = (0..200).map(|k| wave(0.05 * f64::from(k))).collect();
        for delay in [0.063, -0.025, 0.1, 0.011] {
            let later = later(&values, delay, 0.05);
            for k in 20..180 {
                let expected = wave(0.05 * f64::from(k) - delay);
                assert!(
                    (later[k as usize] - expected).abs() < 3e-4,
                    "{delay}: {} {expected}",
                    later[k as usize]
                );
            }
        }
    }
}
