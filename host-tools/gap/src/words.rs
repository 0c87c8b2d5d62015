//! Effects and figures in words.

pub use model::effects::words::{file_name, some_of};
use model::effects::{Candidate, Regressor, find};

use model_core::effects::Term;
use residuals::types::Named;

/// Its physical meaning, one sentence; an effect of the user that has none says its name.
pub fn meaning(candidate: &Candidate) -> &str {
    find(&candidate.id).map_or(&candidate.id, |entry| entry.meaning)
}

/// The headline of an effect, with its standard error: its coefficient. A slope's is its size; that
/// of an effect of several runs the greatest; that of an effect with a half slip its own.
/// Coefficients are taken for independent.
pub fn headline(named: &Named) -> (f64, f64) {
    if named.coefficients.is_empty() {
        return (f64::NAN, f64::NAN);
    }
    let weights = headline_weights(named);
    let value = weights.iter().zip(&named.coefficients).map(|(w, c)| w * c).sum();
    let variance: f64 = weights.iter().zip(&named.std_errs).map(|(w, e)| (w * e).powi(2)).sum();
    (value, variance.sqrt())
}

/// How the headline grows with each coefficient.
pub fn headline_weights(named: &Named) -> Vec<f64> {
    let coefficients = &named.coefficients;
    if direction(named).is_some() {
        let size = coefficients.iter().map(|c| c * c).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        return coefficients.iter().map(|c| c / size).collect();
    }
    if half_slip(named).is_some() {
        return (0..coefficients.len()).map(|place| f64::from(u8::from(place == 0))).collect();
    }
    let greatest = (0..coefficients.len())
        .max_by(|&a, &b| coefficients[a].abs().total_cmp(&coefficients[b].abs()))
        .unwrap_or(0);
    (0..coefficients.len()).map(|place| f64::from(u8::from(place == greatest))).collect()
}

/// The place of the half slip that another effect comes with.
fn half_slip(named: &Named) -> Option<usize> {
    let place = named.candidate.regressors.iter().position(|regressor| *regressor == Regressor::HalfSlip)?;
    (place > 0).then_some(place)
}

/// `0.0250 ± 0.0009 rad (1.4°), coefficient 0.0332 ± 0.0009`: the physical size first, then the
/// coefficient if it differs.
pub fn size(named: &Named) -> String {
    let (value, error) = headline(named);
    let mut coefficient = quantity(value, error, &named.candidate.unit);
    if let (Some(place), [_, share]) = (half_slip(named), &named.coefficients[..]) {
        let error = named.std_errs.get(place).copied().unwrap_or(f64::NAN);
        coefficient += &format!(", half slip by {} %", quantity(100.0 * share, 100.0 * error, "1"));
    }
    match physical(named) {
        Some(size) if size != coefficient => format!("{size}, coefficient {coefficient}"),
        _ => coefficient,
    }
}

/// The physical size; that of a slope in degrees, too.
pub fn physical(named: &Named) -> Option<String> {
    let physical = named.physical.as_ref()?;
    let degrees = match physical.unit.as_str() {
        "rad" => format!(" ({:.1}°)", physical.value.to_degrees()),
        _ => String::new(),
    };
    Some(quantity(physical.value, physical.std_err, &physical.unit) + &degrees)
}

/// Where a slope along a direction of the world rises, rad counter-clockwise from the heading at
/// the start.
pub fn direction(named: &Named) -> Option<f64> {
    let along = |regressor: &Regressor| matches!(regressor, Regressor::Term(Term::GradeAlong(_)));
    match (&named.candidate.regressors[..], &named.coefficients[..]) {
        ([a, b], [x, y]) if along(a) && along(b) => Some(y.atan2(*x)),
        _ => None,
    }
}

/// `0.0266 ± 0.0004 N·m`: with two digits of the error.
pub fn quantity(value: f64, error: f64, unit: &str) -> String {
    let unit = if unit == "1" || unit.is_empty() { String::new() } else { format!(" {unit}") };
    if !value.is_finite() {
        return "unknown".to_owned();
    }
    let scale = if error > 0.0 && error.is_finite() { error } else { 1e-3 * value.abs() };
    let size = value.abs().max(scale);
    // Below a thousandth: in powers of ten.
    let power = if size > 0.0 && size < 1e-3 { size.log10().floor() } else { 0.0 };
    let ten = 10.0_f64.powf(power);
    let digits = match scale / ten {
        scale if scale > 0.0 => (1.0 - scale.log10().floor()).clamp(0.0, 6.0) as usize,
        _ => 0,
    };
    let (value, error) = (value / ten, error / ten);
    let text = if error.is_finite() {
        format!("{value:.digits$} ± {error:.digits$}")
    } else {
        format!("{value:.digits$}")
    };
    if power == 0.0 { text + &unit } else { format!("({text})·10{}{unit}", superscript(power as i32)) }
}

fn superscript(power: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    power.to_string().chars().map(digit).collect()
}

/// Watts with three significant digits.
pub fn watts(value: f64) -> String {
    let size = value.abs();
    let digits = if size > 0.0 { (2.0 - size.log10().floor()).clamp(0.0, 6.0) as usize } else { 0 };
    format!("{value:.digits$} W")
}

/// Watts with their sign, two decimals, without the unit; what rounds to zero is no −0.
pub fn signed_watts(value: f64) -> String {
    let value = if value.abs() < 0.005 { 0.0 } else { value };
    format!("{value:+.2}")
}

/// A share as percent.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A probability as percent: none is sure.
pub fn probability(probability: f64) -> String {
    match probability {
        p if p > 0.99 => "over 99 %".to_owned(),
        p if p < 0.01 => "below 1 %".to_owned(),
        p => percent(p),
    }
}

#[cfg(test)]
mod tests {
    use super::{probability, quantity, signed_watts, watts};

    #[test]
    fn no_probability_is_sure() {
        let said = [1.0, 0.991, 0.99, 0.344, 0.01, 0.004].map(probability);
        assert_eq!(said, ["over 99 %", "over 99 %", "99 %", "34 %", "1 %", "below 1 %"].map(str::to_owned));
    }

    #[test]
    fn figures_have_the_digits_that_their_error_allows() {
        assert_eq!(quantity(2.6594e-2, 8.2e-5, "1"), "0.026594 ± 0.000082");
        assert_eq!(quantity(0.1328, 0.011, "N·m"), "0.133 ± 0.011 N·m");
        assert_eq!(quantity(4.9151e-4, 3.3e-6, "N·m·s/rad"), "(4.915 ± 0.033)·10⁻⁴ N·m·s/rad");
        assert_eq!(quantity(-12.34, 1.6, "W"), "-12.3 ± 1.6 W");
        assert_eq!(quantity(f64::NAN, 1.0, "W"), "unknown");
        assert_eq!(
            [0.04972, 0.4796, 80.13, 1234.5].map(watts),
            ["0.0497 W", "0.480 W", "80.1 W", "1234 W"].map(str::to_owned)
        );
        assert_eq!([-0.001, 0.214].map(signed_watts), ["+0.00", "+0.21"].map(str::to_owned));
    }
}
