//! Effects and figures in words.

use std::path::Path;

use serde_json::{Map, Value};

use crate::effects::{Candidate, Regressor, find};
use crate::gap::types::Named;
use model_core::effects::Term;
use model_core::torque::TorqueModel;

/// Its physical meaning, one sentence; an effect of the user that has none says its name.
pub fn meaning(candidate: &Candidate) -> &str {
    find(&candidate.id).map_or(&candidate.id, |entry| entry.meaning)
}

/// The one number of an effect with its standard error: its coefficient. Of a slope in a direction of the world its size; of an
/// effect with a coefficient for each of several runs the greatest.
pub fn headline(named: &Named) -> (f64, f64) {
    let pairs = || named.coefficients.iter().copied().zip(named.std_errs.iter().copied());
    if direction(named).is_some() {
        let size = pairs().map(|(c, _)| c * c).sum::<f64>().sqrt();
        // Of √(a² + b²), a and b taken for independent.
        let error = pairs().map(|(c, e)| (c * e).powi(2)).sum::<f64>().sqrt() / size.max(f64::MIN_POSITIVE);
        return (size, error);
    }
    pairs().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap_or((f64::NAN, f64::NAN))
}

/// Where a slope along a direction of the world rises, rad counter-clockwise from the heading at the start.
pub fn direction(named: &Named) -> Option<f64> {
    let along = |regressor: &Regressor| matches!(regressor, Regressor::Term(Term::GradeAlong(_)));
    match (&named.candidate.regressors[..], &named.coefficients[..]) {
        ([a, b], [x, y]) if along(a) && along(b) => Some(y.atan2(*x)),
        _ => None,
    }
}

/// A slope, rad: the drive's efficiency is folded into the torques, so the base's inertia gain multiplies weights as it does masses.
pub fn slope(named: &Named, base: &TorqueModel<f64>) -> Option<f64> {
    let is_slope =
        |regressor: &Regressor| matches!(regressor, Regressor::Term(Term::GradeAlong(_) | Term::GradeAhead));
    let sine = headline(named).0 / base.inertia_gain;
    (named.candidate.regressors.iter().all(is_slope) && sine.abs() < 1.0).then(|| sine.asin())
}

/// `0.0266 ± 0.0004 N·m`: as many digits as the error has sense for.
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

/// Watts with their sign, two decimals, without the unit; what rounds to nought is no −0.
pub fn signed_watts(value: f64) -> String {
    let value = if value.abs() < 0.005 { 0.0 } else { value };
    format!("{value:+.2}")
}

/// A share as percent.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// What is special about an effect, in words; empty where nothing is.
pub fn detail(detail: &Map<String, Value>) -> String {
    detail.iter().filter_map(|(key, value)| phrase(key, value)).collect::<Vec<_>>().join(", ")
}

fn phrase(key: &str, value: &Value) -> Option<String> {
    let text = plain(value)?;
    Some(match key {
        "wheel" => format!("wheel {text}"),
        "side" if text == "both" => "both sides".to_owned(),
        "side" => format!("{text} side"),
        "speed_rad_s" => format!("width {text} rad/s"),
        "time_constant_s" => format!("time constant {text} s"),
        "hold_s" => format!("held for {text} s after it"),
        "with" => format!("with {text}"),
        "from" => format!("from {text}"),
        "from_c" => format!("above {text} °C"),
        "by" => format!("by {text}"),
        "along" => format!("along {text}"),
        "at_s" => format!("at {text} s"),
        "runs" if text == "all" => "in all runs".to_owned(),
        "runs" => format!("in {text}"),
        "depends_on_mass" => {
            if value == &Value::Bool(true) { "grows with the mass" } else { "whatever the mass" }.to_owned()
        }
        // Told with the coefficient.
        "coefficients" | "std_errs" | "heading_rad" => return None,
        other => format!("{} {text}", other.replace('_', " ")),
    })
}

/// Entries of a list that are said one by one.
const SAID: usize = 3;

fn plain(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(file_name(text)),
        Value::Number(number) => number.as_f64().map(|x| format!("{:.3}", x)).map(|text| {
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }),
        Value::Array(entries) => Some(some_of(entries.iter().filter_map(plain))),
        other => Some(other.to_string()),
    }
}

/// The first few of a list, and how many more there are.
pub fn some_of(entries: impl IntoIterator<Item = String>) -> String {
    let all: Vec<String> = entries.into_iter().collect();
    // One more is as short as its name.
    match all.len() - SAID.min(all.len()) {
        0 | 1 => all.join(", "),
        more => format!("{} and {more} more", all[..SAID].join(", ")),
    }
}

/// A run's log without its folder.
pub fn file_name(run: &str) -> String {
    match Path::new(run).file_name() {
        Some(name) if run.contains(".csv") => name.to_string_lossy().into_owned(),
        _ => run.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::{detail, quantity, signed_watts, some_of, watts};

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

    #[test]
    fn details_are_said_as_one_would() {
        let all = json!({"wheel": 1, "side": "left", "time_constant_s": 9.0, "runs": ["a/b.csv", "a/c.csv#2"], "at_s": [1.5, null]});
        let words = detail(all.as_object().unwrap());
        assert_eq!(words, "wheel 1, left side, time constant 9 s, in b.csv, c.csv#2, at 1.5 s");
        assert_eq!(some_of(["a", "b", "c", "d"].map(str::to_owned)), "a, b, c, d");
        assert_eq!(some_of(["a", "b", "c", "d", "e"].map(str::to_owned)), "a, b, c and 2 more");
    }
}
