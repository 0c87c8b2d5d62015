//! Figures for people.

/// Three significant digits, without a power of ten where people read them without: 0.0492, 12.3,
/// 4920, −2.60.
pub fn figure(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return "–".to_owned();
    }
    // What rounds up to the next power of ten has one digit less behind the point.
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let power = rounded.abs().log10().floor() as i32;
    let text = match power {
        -5..=2 => format!("{rounded:.*}", (2 - power) as usize),
        3..=5 => format!("{rounded:.0}"),
        _ => format!("{rounded:e}"),
    };
    text.replace('-', "−")
}

/// With so many digits; a figure that has grown absurd by its power of ten, so that the columns
/// stay narrow.
pub fn number(value: Option<f64>, digits: usize) -> String {
    match value {
        Some(value) if value.abs() >= 1e4 => format!("{value:.1e}"),
        Some(value) if value.is_finite() => format!("{value:.digits$}"),
        _ => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits_and_no_power_of_ten() {
        let cases = [
            (4.918_28e-2, "0.0492"),
            (-2.6, "−2.60"),
            (0.999_96, "1.00"),
            (98.23, "98.2"),
            (2286.4, "2290"),
            (0.0, "0"),
            (1.0, "1.00"),
            (3.2e-9, "3.2e−9"),
            (f64::NAN, "–"),
        ];
        for (value, expected) in cases {
            assert_eq!(figure(value), expected);
        }
    }

    #[test]
    fn figures_of_tables_stay_narrow() {
        let cells = [Some(0.123_456), Some(-123_456.0), Some(f64::NAN), None].map(|value| number(value, 4));
        assert_eq!(cells, ["0.1235", "-1.2e5", "–", "–"]);
    }
}
